"""Distributions of pressure, gap and patch sizes; power spectra and autocorrelations."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from ..output.result import Result
from .maps import hardness_of, slabs
from .style import THEORY, Page, Units, colour, label, line, load_label, log_axis
from .theory import Theory

BINS = 48  # of pressure
GAP_DECADES = 6  # of the gap in bins, below the largest one
PER_DECADE = 10  # bins of the gap
DECADES = 5  # of the gap that are shown; smaller ones are rounding
# symbol, title, least share of a bin (over the smallest that is not 0), power of the unit
DISTRIBUTIONS = {
    "pressure": ("p", "pressure in the contact: share of all points", 4, 1),
    "gap": ("g", "gap outside: share of all points", 4, 1),
    "patches": ("A", "contact patches", 1, 2),
}
SYMBOLS = {"heights": "z", "pressure": "p", "gap": "g"}
SPECTRA = [f"{name}_{kind}" for kind in ("spectrum", "autocorrelation") for name in SYMBOLS]
ROUNDING = 1e-12  # relative, of a power


def distributions(
    result: Result, names: list[str], units: Units, theory: Theory | None = None
) -> Page:
    """Return a page with a panel for each of DISTRIBUTIONS in names, made from fields where the
    result has none.
    """
    draw = partial(_distribution, result=result, units=units, theory=theory)
    return Page([partial(draw, name=name) for name in names])


def spectra(result: Result, names: list[str], units: Units) -> Page:
    """Return a page with a panel for each of SPECTRA in names."""
    draw = {"spectrum": _spectrum, "autocorrelation": _autocorrelation}
    kinds = [name.split("_") for name in names]
    return Page(
        [partial(draw[kind], result=result, name=name, units=units) for name, kind in kinds]
    )


def _distribution(ax: Any, result: Result, name: str, units: Units, theory: Theory | None) -> None:
    """Draw one distribution of every load and the theory; titles tell if there is none."""
    symbol, title, fewest, power = DISTRIBUTIONS[name]
    densities = [(k, *_joined(edges, shares, fewest)) for k, edges, shares in _shares(result, name)]
    if not densities:
        ax.set(title=f"{title}: none", xticks=[], yticks=[])
        return
    highest = max(edges[-1] for _, edges, _ in densities)
    scale = units.lengths if power == 2 else units.of(name, [highest])
    unit = scale.unit**power
    for k, edges, values in densities:
        ax.stairs(
            values * unit,
            edges / unit,
            baseline=None,
            linewidth=1.1,
            color=colour(k),
            linestyle=line(k),
            label=load_label(result, k, units),
        )
    density = label(f"P({symbol})", (scale, -power))
    ax.set(xlabel=scale.label(symbol, power), ylabel=density, title=title)
    drawn = np.concatenate([values for *_, values in densities]) * unit
    ax.set_ylim(drawn.min() / 2, drawn.max() * 3)
    log_axis(ax, "y")
    if name == "pressure":
        ax.set_xlim(0, 1.03 * highest / unit)
        hardness = hardness_of(result)
        if hardness is not None:
            ax.axvline(hardness / unit, label="hardness", color="0.5", linewidth=0.8, linestyle=":")
        if theory and theory.density:
            _theory(ax, theory.density, theory.name, result, densities, unit)
    else:
        lowest = min(edges[edges > 0][0] for _, edges, _ in densities)
        below = highest / 10**DECADES if name == "gap" else 0.0
        ax.set_xlim(max(lowest, below) / unit / 1.5, highest / unit * 1.5)
        log_axis(ax, "x")


def _theory(
    ax: Any, density: Callable, name: str, result: Result, densities: list[Any], unit: float
) -> None:
    """Draw a theory's density for each load (index, edges, values); unit: of the axis."""
    for k, edges, _ in densities:
        x = np.linspace(0, edges[-1], 301)[1:]
        y = density(x, result.steps[k]["p"])
        ax.plot(x / unit, y * unit, **THEORY | {"color": colour(k)})
    ax.plot([], [], label=name, **THEORY)


def _shares(result: Result, name: str) -> Iterator[Any]:
    """Yield (index, edges, shares) of steps, from the file or else fields; they add up to a_r
    (pressure), 1 - a_r (gap), 1 (patches).
    """
    for k, (step, fields) in enumerate(zip(result.steps, result.fields)):
        if f"{name}_edges" in step:
            edges, density = (np.array(step[f"{name}_{x}"], float) for x in ("edges", "density"))
            area = step.get("a_r", np.nan)
            share = {"pressure": area, "gap": 1 - area}.get(name, 1.0)
            if np.isnan(share):  # the mean of all points over that of these, about
                whole = step["p" if name == "pressure" else "gap_mean"]
                share = whole / (density @ np.diff(edges**2) / 2)
            shares = density * np.diff(edges) * share
        elif name in fields:
            edges, shares = histogram(fields, name)
        else:
            continue
        if shares.any():
            yield k, edges, shares


def _joined(edges: np.ndarray, shares: np.ndarray, fewest: int) -> tuple[np.ndarray, np.ndarray]:
    """Return (edges, density), joining bins until each has `fewest` times the smallest share."""
    filled = np.flatnonzero(shares)
    stop = filled[-1] + 1
    chosen = [filled[0]]
    total = np.append(0.0, shares.cumsum())
    smallest = fewest * shares[filled].min() * (1 - 1e-9)
    for k in range(chosen[0] + 1, stop + 1):
        if total[k] - total[chosen[-1]] >= smallest:
            chosen.append(k)
    chosen = [*chosen[: max(1, len(chosen) - 1)], stop]
    return edges[chosen], np.diff(total[chosen]) / np.diff(edges[chosen])


def histogram(fields: dict, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return (edges, shares of all points) of the pressure where points touch, in even bins from 0,
    or of the gap elsewhere, in logarithmic bins of which the first reaches down to 0. The fields
    are read twice.
    """
    n_x, n_y = fields[name].shape

    def values() -> Iterator[np.ndarray]:
        for slab in slabs(fields, 0, n_x, 1, slice(None)):
            touching = slab["contact"]
            yield slab[name][touching if name == "pressure" else ~touching]

    top = max(block.max(initial=0.0) for block in values()) or 1.0
    edges = np.linspace(0, top, BINS + 1)
    if name == "gap":
        edges = np.append(
            0.0, np.geomspace(top / 10**GAP_DECADES, top, GAP_DECADES * PER_DECADE + 1)
        )
    return edges, sum(np.histogram(block, edges)[0] for block in values()) / (n_x * n_y)


def _lines(result: Result, name: str, x: str, y: str, units: Units) -> Iterator[Any]:
    """Yield (x, y, keywords of plot) of a field for each load, heights once; x, y: ends of keys."""
    for k, step in enumerate(result.steps):
        if f"{name}_{x}" in step:
            of_heights = name == "heights"
            how = {
                "color": "black" if of_heights else colour(k),
                "linestyle": "-" if of_heights else line(k),
                "label": "heights" if of_heights else load_label(result, k, units),
            }
            yield *(np.array(step[f"{name}_{of}"], dtype=float) for of in (x, y)), how
            if of_heights:
                return


def _spectrum(ax: Any, result: Result, name: str, units: Units) -> None:
    """Draw the power spectrum of a field for each load, without powers below rounding."""
    length = units.lengths
    lines = list(_lines(result, name, "spectrum_q", "spectrum_power", units))
    size = np.sqrt(max(power.max() for _, power, _ in lines) / units.size**2)
    scale = units.of(name, [float(size)])
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


def _autocorrelation(ax: Any, result: Result, name: str, units: Units) -> None:
    """Draw the autocorrelation of a field over its value at 0 for each load, unless that is 0."""
    length = units.lengths
    ax.axhline(0, color="0.8", linewidth=0.7, zorder=0)
    keys = "autocorrelation_r", "autocorrelation_correlation"
    for r, correlation, how in _lines(result, name, *keys, units):
        if correlation[0] > 0:  # not of a gap that is closed
            ax.plot(r / length.unit, correlation / correlation[0], **how)
    symbol = SYMBOLS[name]
    ax.set(xlabel=length.label("r"), ylabel=f"$A_{symbol}(r)/A_{symbol}(0)$", title=name)
