"""Distributions of pressure, gap and patch sizes, and the theory of the pressure."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from ..output.result import Result
from .context import FigureContext
from .page import Page
from .style import THEORY, colour, line, log_axis
from .survey import histogram
from .units import label

DECADES = 5  # of the gap, below the largest one; smaller ones are rounding
# symbol, title, least share of a bin (over the smallest that is not 0), power of the unit
NAMES = {
    "pressure": ("p", "pressure in the contact", 4, 1),
    "gap": ("g", "gap outside", 4, 1),
    "patches": ("A", "contact patches", 1, 2),
}


def distributions(contexts: Sequence[FigureContext], names: list[str]) -> Page:
    """Return a page with a panel for each distribution of one result.

    Parameters
    ----------
    contexts : sequence of FigureContext
        Only the first is used.
    names : list of str
        "pressure", "gap" or "patches". Distributions that are not in the result file are made from
        the fields.

    Returns
    -------
    Page
        Not drawn yet; fields are read when it is drawn.
    """
    return Page([partial(_panel, context=contexts[0], name=name) for name in names])


def _panel(ax: Any, context: FigureContext, name: str) -> None:
    """Draw one distribution of every load on axes, with labels, limits and the theory.

    If there is nothing to draw the axes stay empty and their title says so.
    """
    symbol, title, fewest, power = NAMES[name]
    densities = [
        (k, *_joined(edges, shares, fewest)) for k, edges, shares in _shares(context.result, name)
    ]
    if not densities:
        ax.set(title=f"{title}: none", xticks=[], yticks=[])
        return
    highest = max(edges[-1] for _, edges, _ in densities)
    scale = context.lengths if power == 2 else context.units.of(name, [highest])
    unit = scale.unit**power
    for k, edges, values in densities:
        ax.stairs(
            values * unit,
            edges / unit,
            baseline=None,
            linewidth=1.1,
            color=colour(k),
            linestyle=line(k),
            label=context.name_of(k),
        )
    density = label(f"P({symbol})", (scale, -power))
    ax.set(xlabel=scale.label(symbol, power), ylabel=density, title=title)
    drawn = np.concatenate([values for *_, values in densities]) * unit
    ax.set_ylim(drawn.min() / 2, drawn.max() * 3)
    log_axis(ax, "y")
    if name == "pressure":
        ax.set_xlim(0, 1.03 * highest / unit)
        if context.hardness is not None:
            ax.axvline(
                context.hardness / unit, label="hardness", color="0.5", linewidth=0.8, linestyle=":"
            )
        _theory(ax, context, densities, unit)
    else:
        lowest = min(edges[edges > 0][0] for _, edges, _ in densities)
        below = highest / 10**DECADES if name == "gap" else 0.0
        ax.set_xlim(max(lowest, below) / unit / 1.5, highest / unit * 1.5)
        log_axis(ax, "x")


def _theory(ax: Any, context: FigureContext, densities: list[Any], unit: float) -> None:
    """Draw on axes the density that the theory gives for each load; nothing if it gives none.

    densities: (index of the load, edges, values). unit: of the axis, in the unit of the result.
    """
    theory = context.theory
    if not (theory and theory.density):
        return
    for k, edges, _ in densities:
        x = np.linspace(0, edges[-1], 301)[1:]
        y = theory.density(x, context.result.steps[k]["p"])
        ax.plot(x / unit, y * unit, **THEORY | {"color": colour(k)})
    ax.plot([], [], label=theory.name, **THEORY)


def _shares(result: Result, name: str) -> Iterator[Any]:
    """Yield (index of the load, edges, shares) of every load step that has this distribution.

    Shares of the pressure add up to the area in contact, a_r, those of the gap to 1 - a_r, and
    those of patches to 1. Loads with an empty histogram are left out. They come from the result
    file if it has them, otherwise from the fields, which are read.
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
    """Return (edges, density) of a histogram, joining bins until each is filled enough.

    Empty bins at the ends are dropped; each bin then has at least `fewest` times the smallest share
    of a bin that is not empty.
    """
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
