"""Contact area, mean gap and what else was asked for over the load, with the theory of the
surface."""

from collections.abc import Callable, Iterator
from math import hypot, isfinite
from typing import Any

import numpy as np

from ..output.table import converged
from .drawn import Drawn
from .style import COLOURS, THEORY, WARNING, WIDTH, legend_below, ticks
from .units import Scale, good

COLUMNS = 3


def curves(fig: Any, drawn: Drawn) -> None:
    """A panel for every quantity that the loads have. drawn: drawn.Drawn."""
    steps = [step for step in (drawn.result.steps[k] for k in drawn.chosen) if good(step.get("p"))]
    panels = [
        panel
        for panel in _panels(drawn, steps)
        if any(good(step.get(key)) for step in steps for key, *_ in panel[1])
    ]
    columns = min(COLUMNS, max(1, len(panels)))
    rows = max(1, -(-len(panels) // columns))
    fig.set_size_inches(WIDTH, 2.35 * rows + 0.35)
    axes = fig.subplots(rows, columns, squeeze=False)
    x = drawn.units.pressures([step["p"] for step in steps])
    for ax, (label, series, theory) in zip(axes.flat, panels, strict=False):
        for key, error_keys, scale, colour, marker, name in series:
            _points(ax, steps, x, key, error_keys, scale, colour, marker, name)
        if theory is not None and steps:
            _line(ax, steps, x, series[0][2], *theory)
        _axes(ax, x, label)
    for ax in axes.flat[len(panels) :]:
        ax.set_axis_off()
    legend_below(fig)


def _panels(drawn: Drawn, steps: list[dict]) -> Iterator[Any]:
    """(label, [(key, keys of its errors, scale, colour, marker, name)], (name, function of p) or
    None) of every panel."""
    theory: Any = drawn.theory
    one = Scale(1.0)
    heights = drawn.units.heights([step.get("gap_mean") for step in steps])
    depths = drawn.units.heights([step.get("approach") for step in steps])
    area = ("a_r_error", "a_r_discretisation")

    def of(name: str) -> Any:
        function = theory and getattr(theory, name)
        return (theory.name, function) if function else None

    simulated = ("simulation (bars: solver and grid)", "edge-corrected")
    yield "$a_r$", [("a_r", area, one, COLOURS[0], "o", simulated[0])], of("area")
    if drawn.units.rough:
        unit = next((step["p"] / step["p_star"] for step in steps if good(step.get("p_star"))), 1.0)
        kappa = of("area") and (theory.name, lambda p: unit * theory.area(p) / p)
        yield (
            r"$\kappa = a_r/p^*$",
            [
                ("kappa", area, one, COLOURS[0], "o", simulated[0]),
                ("kappa_corrected", (), one, COLOURS[1], "s", simulated[1]),
            ],
            kappa,
        )
    yield (
        heights.label(r"\langle g \rangle"),
        [("gap_mean", ("gap_error",), heights, COLOURS[0], "o", simulated[0])],
        of("gap"),
    )
    yield (
        depths.label(r"\delta"),
        [("approach", (), depths, COLOURS[0], "o", simulated[0])],
        of("approach"),
    )


def _points(
    ax: Any,
    steps: list[dict],
    scale_x: Scale,
    key: Any,
    error_keys: Any,
    scale: Scale,
    colour: str,
    marker: str,
    name: str,
) -> None:
    for good_ones in (True, False):
        chosen = [
            s
            for s in steps
            if isinstance(s.get(key), int | float)
            and isfinite(s[key])
            and converged(s) == good_ones
        ]
        if not chosen:
            continue
        x, y = np.array([[step["p"] / scale_x.unit, step[key] / scale.unit] for step in chosen]).T
        relative = np.array(
            [hypot(*(step.get(error) or 0.0 for error in error_keys)) for step in chosen]
        )
        how = {"color": colour, "marker": marker, "label": name}
        if not good_ones:
            how = {"color": WARNING, "marker": "x", "label": "not converged"}
        bars = np.abs(y) * np.where(np.isfinite(relative), relative, 0) if error_keys else None
        ax.errorbar(x, y, bars, linestyle="", capsize=1.5, elinewidth=0.8, **how)


def _line(ax: Any, steps: list[dict], x: Any, scale: Scale, name: Any, function: Callable) -> None:
    loads = [step["p"] for step in steps]
    p = np.geomspace(min(loads) / 2, max(loads) * 2, 80)
    low, high = ax.get_ylim()
    shown = ax.dataLim.intervaly
    ax.plot(p / x.unit, function(p) / scale.unit, label=name, zorder=1, **THEORY)
    ax.set_ylim(min(low, shown[0] / 2), max(high, shown[1] * 2))


def _axes(ax: Any, x: Any, y_label: str) -> None:
    ax.set_xlabel(
        x.label("p_0") if not x.relative or " " not in x.name else r"$p^* = p_0/(E^* \bar{g})$"
    )
    ax.set_ylabel(y_label)
    ax.set_xscale("log")
    ticks(ax.xaxis)
    values = np.concatenate(
        [line.get_ydata() for line in ax.get_lines() if line.get_linestyle() == "None"] or [[1.0]]
    ).astype(float)
    positive = values[values > 0]
    if len(positive) and positive.max() > 10 * positive.min() and positive.min() == values.min():
        ax.set_yscale("log")
        ticks(ax.yaxis)
        ax.set_ylim(positive.min() / 2.5, positive.max() * 2.5)
    else:
        span = values.max() - min(values.min(), 0)
        ax.set_ylim(min(0, values.min()), values.max() + 0.15 * (span or 1.0))
