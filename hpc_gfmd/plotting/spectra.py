"""Power spectra and autocorrelations of heights, pressure and gap."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from .context import FigureContext
from .page import Page
from .style import colour, line, log_axis
from .units import label

SYMBOLS = {"heights": "z", "pressure": "p", "gap": "g"}
PANELS = [f"{name}_{kind}" for kind in ("spectrum", "autocorrelation") for name in SYMBOLS]
ROUNDING = 1e-12  # relative, of a power


def spectra(contexts: Sequence[FigureContext], names: list[str]) -> Page:
    """Return a page of spectra and autocorrelations of one result.

    Parameters
    ----------
    contexts : sequence of FigureContext
        Only the first is used.
    names : list of str
        Entries of PANELS: "heights_spectrum", "gap_autocorrelation", ...

    Returns
    -------
    Page
        Not drawn yet.
    """
    draw = {"spectrum": _spectrum, "autocorrelation": _autocorrelation}
    kinds = [name.split("_") for name in names]
    return Page([partial(draw[kind], context=contexts[0], name=name) for name, kind in kinds])


def _lines(context: FigureContext, name: str, x: str, y: str) -> Iterator[Any]:
    """Yield (x, y, keywords of plot) of a field for every load that has this distribution.

    x, y: endings of its keys in a load step. Heights are the same under all loads and come once.
    """
    for k, step in enumerate(context.result.steps):
        if f"{name}_{x}" in step:
            of_heights = name == "heights"
            how = {
                "color": "black" if of_heights else colour(k),
                "linestyle": "-" if of_heights else line(k),
                "label": "heights" if of_heights else context.name_of(k),
            }
            yield *(np.array(step[f"{name}_{of}"], dtype=float) for of in (x, y)), how
            if of_heights:
                return


def _spectrum(ax: Any, context: FigureContext, name: str) -> None:
    """Draw the power spectrum of a field for each load on axes, with labels and log scales.

    name: of the panel, such as "gap_spectrum". Powers below rounding are left out.
    """
    length = context.lengths
    lines = list(_lines(context, name, "spectrum_q", "spectrum_power"))
    size = np.sqrt(max(power.max() for _, power, _ in lines) / context.units.size**2)
    scale = context.units.of(name, [float(size)])
    for q, power, how in lines:
        shown = power > ROUNDING * power.max()
        y = power[shown] / (scale.unit**2 * length.unit**2)
        if shown.sum() == 1:
            how |= {"linestyle": "", "marker": "."}
        ax.loglog(q[shown] * length.unit, y, **how)
    ax.set(
        xlabel=label("q", (length, -1)),
        ylabel=label(f"C_{SYMBOLS[name]}(q)", (scale, 2), (length, 2)),
        title=name,
    )
    log_axis(ax, "x")
    log_axis(ax, "y")


def _autocorrelation(ax: Any, context: FigureContext, name: str) -> None:
    """Draw the autocorrelation of a field over its value at 0 for each load on axes, with labels.

    name: of the panel, such as "gap_autocorrelation". A field whose value at 0 is 0 is left out.
    """
    length = context.lengths
    ax.axhline(0, color="0.8", linewidth=0.7, zorder=0)
    keys = "autocorrelation_r", "autocorrelation_correlation"
    for r, correlation, how in _lines(context, name, *keys):
        if correlation[0] > 0:  # not of a gap that is closed
            ax.plot(r / length.unit, correlation / correlation[0], **how)
    symbol = SYMBOLS[name]
    ax.set(xlabel=length.label("r"), ylabel=f"$A_{symbol}(r)/A_{symbol}(0)$", title=name)
