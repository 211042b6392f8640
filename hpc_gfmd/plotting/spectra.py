"""Power spectra and autocorrelations of heights, pressure and gap."""

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np

from .context import FigureContext
from .page import Page
from .style import colour, log_axis
from .units import label

FIELDS = {"heights": "z", "pressure": "p", "gap": "g"}
ROUNDING = 1e-12  # relative, of a power


def spectra(context: FigureContext) -> Page:
    """Make a column for each field, spectra above autocorrelations, as far as the result has
    them."""
    rows = [
        [
            partial(panel, context=context, name=name)
            for name in FIELDS
            if any(f"{name}_{kind}" in step for step in context.steps)
        ]
        for panel, kind in ((_spectrum, "spectrum_q"), (_autocorrelation, "autocorrelation_r"))
    ]
    return Page([row for row in rows if row], height=2.3)


def has_spectra(step: Mapping[str, Any]) -> bool:
    """Tell whether a load step has any spectrum or autocorrelation."""
    return any(
        f"{name}_{rest}" in step for name in FIELDS for rest in ("spectrum_q", "autocorrelation_r")
    )


def _lines(context: FigureContext, name: str, x: str, y: str) -> Iterator[Any]:
    """Yield (x, y, how it is drawn) of every load; the heights are the same under all."""
    for k, step in enumerate(context.steps):
        if f"{name}_{x}" in step:
            same = name == "heights"
            how = {
                "color": "black" if same else colour(k),
                "label": "heights" if same else context.name_of(k),
            }
            yield *(np.array(step[f"{name}_{of}"], dtype=float) for of in (x, y)), how
            if same:
                return


def _spectrum(ax: Any, context: FigureContext, name: str) -> None:
    length = context.units.lengths()
    lines = list(_lines(context, name, "spectrum_q", "spectrum_power"))
    dims = context.dimensions
    size = np.sqrt(max(power.max() for _, power, _ in lines) / context.units.size**dims)
    scale = context.units.of(name, [float(size)])
    for q, power, how in lines:
        some = power > ROUNDING * power.max()
        y = power[some] / (scale.unit**2 * length.unit**dims)
        ax.loglog(q[some] * length.unit, y, "." if some.sum() == 1 else "-", **how)
    ax.set(
        xlabel=label("q", (length, -1)),
        ylabel=label(f"C_{FIELDS[name]}(q)", (scale, 2), (length, dims)),
        title=name,
    )
    log_axis(ax, "x")
    log_axis(ax, "y")


def _autocorrelation(ax: Any, context: FigureContext, name: str) -> None:
    length = context.units.lengths()
    ax.axhline(0, color="0.8", linewidth=0.7, zorder=0)
    for r, found, how in _lines(context, name, "autocorrelation_r", "autocorrelation_correlation"):
        if found[0] > 0:  # not of a gap that is closed
            ax.plot(r / length.unit, found / found[0], **how)
    symbol = FIELDS[name]
    ax.set(xlabel=length.label("r"), ylabel=f"$A_{symbol}(r)/A_{symbol}(0)$", title=name)
