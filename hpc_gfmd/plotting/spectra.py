"""Power spectra and autocorrelations of heights, pressure and gap."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from .drawn import Drawn
from .style import COLOURS, WIDTH, legend_below

FIELDS = {"heights": "z", "pressure": "p", "gap": "g"}


def spectra(fig: Any, drawn: Drawn) -> None:
    """A column for each field, spectra above autocorrelations, as far as the result has them.
    drawn: drawn.Drawn."""
    steps = [drawn.result.steps[k] for k in drawn.chosen]
    rows = [
        (kind, [name for name in FIELDS if any(f"{name}_{kind}_{x}" in step for step in steps)])
        for kind, x in (("spectrum", "q"), ("autocorrelation", "r"))
    ]
    rows = [(kind, names) for kind, names in rows if names]
    columns = max(len(names) for _, names in rows)
    fig.set_size_inches(WIDTH, 2.3 * len(rows) + 0.4)
    axes = fig.subplots(len(rows), columns, squeeze=False)
    for line, (kind, names) in zip(axes, rows, strict=True):
        for ax, name in zip(line, names, strict=False):
            (_spectrum if kind == "spectrum" else _autocorrelation)(ax, drawn, steps, name)
        for ax in line[len(names) :]:
            ax.set_axis_off()
    legend_below(fig)


def has_spectra(step: Any) -> bool:
    """Whether a load step has any."""
    return any(
        f"{name}_{rest}" in step for name in FIELDS for rest in ("spectrum_q", "autocorrelation_r")
    )


def _curves(drawn: Drawn, steps: list[dict], name: str, x: str, y: str) -> Iterator[Any]:
    """(colour, label, x, y) of every load; the heights are the same under all."""
    for k, step in enumerate(steps):
        if f"{name}_{x}" in step:
            same = name == "heights"
            yield (
                "black" if same else COLOURS[k],
                "heights" if same else drawn.name_of(k),
                np.array(step[f"{name}_{x}"], dtype=float),
                np.array(step[f"{name}_{y}"], dtype=float),
            )
            if same:
                return


def _spectrum(ax: Any, drawn: Drawn, steps: list[dict], name: str) -> None:
    length = drawn.units.lengths()
    lines = list(_curves(drawn, steps, name, "spectrum_q", "spectrum_power"))
    size = np.sqrt(max(power.max() for *_, power in lines)) / drawn.units.size
    scale = drawn.units.of(name, [float(size)])
    for colour, label, q, power in lines:
        shown = power > 1e-12 * power.max()  # below are rounding errors
        ax.loglog(
            q[shown] * length.unit,
            power[shown] / (scale.unit * length.unit) ** 2,
            "-",
            color=colour,
            label=label,
        )
    squared = (
        f"({scale.name}$^2$ {length.name}$^2$)"
        if not length.relative
        else f"$/(({scale.name})^2 L_x^2)$"
    )
    ax.set(
        xlabel="$q\\,L_x$" if length.relative else f"$q$ (1/{length.name})",
        ylabel=f"$C_{FIELDS[name]}(q)$ {squared}",
        title=name,
    )


def _autocorrelation(ax: Any, drawn: Drawn, steps: list[dict], name: str) -> None:
    length = drawn.units.lengths()
    for colour, label, r, found in _curves(
        drawn, steps, name, "autocorrelation_r", "autocorrelation_correlation"
    ):
        ax.plot(r / length.unit, found / found[0], "-", color=colour, label=label)
    ax.axhline(0, color="0.8", linewidth=0.7, zorder=0)
    ax.set(
        xlabel=length.label("r"), ylabel=f"$A_{FIELDS[name]}(r)/A_{FIELDS[name]}(0)$", title=name
    )
