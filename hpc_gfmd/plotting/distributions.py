"""Distributions of pressure, gap and patch sizes, with what theory says of the pressure."""

from typing import Any

import numpy as np

from ..output.table import converged
from .drawn import Drawn
from .style import COLOURS, THEORY, WIDTH, legend_below
from .survey import density

BINS = 48  # of pressure
HEIGHT = 3.0


def distributions(fig: Any, drawn: Drawn) -> None:
    """A panel for each of them that the result has, stored or in its fields. drawn: drawn.Drawn."""
    there = set().union(*(_has(drawn, k) for k in range(len(drawn.chosen))))
    panels = [panel for name, panel in PANELS.items() if name in there]
    fig.set_size_inches(WIDTH, HEIGHT)
    for ax, panel in zip(fig.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        panel(ax, drawn)
    legend_below(fig)


def stored(step: Any, name: str) -> bool:
    """Whether a load step has a distribution of this name."""
    return f"{name}_edges" in step


def _has(drawn: Drawn, k: int) -> set[str]:
    step, fields = drawn.result.steps[drawn.chosen[k]], drawn.result.fields[drawn.chosen[k]]
    return {name for name in PANELS if stored(step, name) or (name in fields)}


def _of(drawn: Drawn, k: int, name: str) -> tuple[np.ndarray, np.ndarray]:
    """(edges, density), which integrates to the share of the area; empty where there is none."""
    step = drawn.result.steps[drawn.chosen[k]]
    if stored(step, name):
        share = {"pressure": step.get("a_r", 1.0), "gap": 1 - step.get("a_r", 0.0)}.get(name, 1.0)
        return np.array(step[f"{name}_edges"], dtype=float), share * np.array(
            step[f"{name}_density"], dtype=float
        )
    fields = drawn.fields(k)
    if name not in fields:
        return np.zeros(1), np.zeros(0)
    return density(
        {n: fields[n] for n in ("pressure", "gap") if n in fields},
        name,
        drawn.units.of(name, [step["p"]]).unit,
    )


def _pressures(ax: Any, drawn: Drawn) -> None:
    found = [_of(drawn, k, "pressure") for k in range(len(drawn.chosen))]
    scale = drawn.units.pressures([edges[-1] for edges, _ in found])
    lowest, highest = np.inf, 0.0
    for k, (edges, values) in enumerate(found):
        if not len(values):
            continue
        edges, values = _coarser(edges, values, np.linspace(0, edges[-1], BINS + 1))
        lowest, highest = (
            min(lowest, values[values > 0].min() * scale.unit),
            max(highest, values.max() * scale.unit),
        )
        some = values > 0
        ax.plot(
            (edges[1:] + edges[:-1])[some] / 2 / scale.unit,
            values[some] * scale.unit,
            "o",
            markersize=2.5,
            color=COLOURS[k],
            label=_label(drawn, k),
        )
        if drawn.theory and drawn.theory.density:
            x = np.linspace(0, edges[-1], 301)[1:]
            expected = drawn.theory.density(x, drawn.result.steps[drawn.chosen[k]]["p"])
            ax.plot(
                x / scale.unit,
                expected * scale.unit,
                label=f"{drawn.theory.name} (lines)",
                **THEORY | {"color": COLOURS[k]},
            )
    ax.set(
        xlabel=scale.label("p"),
        ylabel=scale.density_label("P(p)"),
        yscale="log",
        xlim=(0, None),
        title="pressure in the contact",
    )
    if highest:
        ax.set_ylim(lowest / 2, highest * 3)


def _gaps(ax: Any, drawn: Drawn) -> None:
    found = [_of(drawn, k, "gap") for k in range(len(drawn.chosen))]
    scale = drawn.units.heights([edges[-1] for edges, _ in found])
    for k, (edges, values) in enumerate(found):
        edges = (
            edges[1:] if len(edges) and edges[0] == 0 else edges
        )  # all smaller gaps together have no place on this axis
        values = values[len(values) - len(edges) + 1 :]
        if len(values):
            edges, values = _coarser(
                edges,
                values,
                np.geomspace(edges[0], edges[-1], int(10 * np.log10(edges[-1] / edges[0])) + 2),
            )
            some = values > 0
            ax.plot(
                np.sqrt(edges[1:] * edges[:-1])[some] / scale.unit,
                values[some] * scale.unit,
                "o-",
                markersize=2,
                linewidth=0.8,
                color=COLOURS[k],
                label=_label(drawn, k),
            )
    ax.set(
        xlabel=scale.label("g"),
        ylabel=scale.density_label("P(g)"),
        xscale="log",
        yscale="log",
        title="gap outside",
    )
    _no_more_than(ax, 5)


def _patches(ax: Any, drawn: Drawn) -> None:
    scale = drawn.units.lengths()
    for k in range(len(drawn.chosen)):
        edges, values = _of(drawn, k, "patches")
        if len(values):
            some = values > 0
            area = np.sqrt(edges[1:] * edges[:-1])[some] / scale.unit**2
            ax.plot(
                area,
                values[some] * scale.unit**2,
                "o-",
                markersize=2.5,
                linewidth=0.8,
                color=COLOURS[k],
                label=_label(drawn, k),
            )
    ax.set(
        xlabel=scale.label("A", 2),
        ylabel=scale.density_label("P(A)", 2),
        xscale="log",
        yscale="log",
        title="contact patches",
    )


PANELS = {"pressure": _pressures, "gap": _gaps, "patches": _patches}


def _no_more_than(ax: Any, decades: float) -> None:
    """Of the largest values; what lies below is rounding."""
    low, high = ax.dataLim.intervalx
    if high > low * 10**decades > 0:
        ax.set_xlim(high / 10**decades, high * 1.5)


def _coarser(edges: np.ndarray, values: Any, wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same density in fewer bins, whose edges are those that are nearest to `wanted`."""
    chosen = np.unique(np.abs(edges[:, None] - wanted).argmin(axis=0))
    if len(chosen) < 2:
        return edges, values
    return edges[chosen], np.add.reduceat(values * np.diff(edges), chosen[:-1])[
        : len(chosen) - 1
    ] / np.diff(edges[chosen])


def _label(drawn: Drawn, k: int) -> str:
    step = drawn.result.steps[drawn.chosen[k]]
    return drawn.name_of(k) + ("" if converged(step) else ", not converged")
