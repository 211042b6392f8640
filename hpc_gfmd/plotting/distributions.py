"""Distributions of pressure, gap and patch sizes, with what theory says of the pressure."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from .context import FigureContext
from .page import Page
from .style import THEORY, colour, log_axis
from .survey import histogram
from .units import label

HARDNESS = {"color": "0.5", "linewidth": 0.8, "linestyle": ":"}
DECADES = 5  # of the gap, below the largest one; smaller ones are rounding
NAMES = {  # symbol, density, title; how many of the smallest count a bin has at least
    "pressure": ("p", "P(p)", "pressure in the contact", 4),
    "gap": ("g", "P(g)", "gap outside", 4),
    "patches": ("A", "P(A)", "contact patches", 1),
}


def distributions(contexts: Sequence[FigureContext], names: list[str]) -> Page:
    """Make a panel for each distribution of one result, stored or of its fields."""
    return Page([partial(_panel, context=contexts[0], name=name) for name in names])


def _panel(ax: Any, context: FigureContext, name: str) -> None:
    symbol, density_symbol, title, _ = NAMES[name]
    found = [(k, *_density(context, k, name)) for k in range(len(context.result.steps))]
    found = [one for one in found if len(one[1])]
    highest = max((edges[-1] for _, edges, _ in found), default=1.0)
    power = 2 if name == "patches" else 1
    scale = context.lengths if power == 2 else context.units.of(name, [highest])
    unit = scale.unit**power
    for k, edges, values in found:
        how = {"baseline": None, "color": colour(k), "label": context.name_of(k)}
        ax.stairs(values * unit, edges / unit, linewidth=1.1, **how)
    ax.set(xlabel=scale.label(symbol, power), ylabel=label(density_symbol, (scale, -power)))
    ax.set_title(title)
    if not found:  # all points touch
        return
    drawn = np.concatenate([values for *_, values in found]) * unit
    ax.set_ylim(drawn.min() / 2, drawn.max() * 3)
    log_axis(ax, "y")
    if name == "pressure":
        ax.set_xlim(0, 1.03 * highest / unit)
        if context.hardness is not None:
            ax.axvline(context.hardness / unit, label="hardness", **HARDNESS)
        _theory(ax, context, found, unit)
    else:
        lowest = min(edges[edges > 0][0] for _, edges, _ in found)
        below = highest / 10**DECADES if name == "gap" else 0.0
        ax.set_xlim(max(lowest, below) / unit / 1.5, highest / unit * 1.5)
        log_axis(ax, "x")


def _theory(ax: Any, context: FigureContext, found: list[Any], unit: float) -> None:
    theory = context.theory
    if theory is None or theory.density is None:
        return
    for k, edges, _ in found:
        x = np.linspace(0, edges[-1], 301)[1:]
        y = theory.density(x, context.result.steps[k]["p"])
        ax.plot(x / unit, y * unit, **THEORY | {"color": colour(k)})
    ax.plot([], [], label=theory.name, **THEORY)


def _density(context: FigureContext, k: int, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return (edges, density), which integrates to the share of the area, that of patches to 1;
    empty where there is none."""
    step, fields, fewest = context.result.steps[k], context.result.fields[k], NAMES[name][-1]
    if f"{name}_edges" in step:
        edges, density = (np.array(step[f"{name}_{x}"], float) for x in ("edges", "density"))
        share = {"pressure": step["a_r"], "gap": 1 - step["a_r"]}.get(name, 1.0)
        return _joined(edges, density * np.diff(edges) * share, fewest)
    if name in fields:
        return _joined(*histogram(fields, name), fewest)
    return np.zeros(0), np.zeros(0)


def _joined(edges: np.ndarray, shares: np.ndarray, fewest: int) -> tuple[np.ndarray, np.ndarray]:
    """Return (edges, density) of a histogram without empty ends, in bins that are joined until each
    has `fewest` times the smallest count of all."""
    filled = np.flatnonzero(shares)
    if not len(filled):
        return np.zeros(0), np.zeros(0)
    first, last = filled[0], filled[-1] + 1
    total, chosen = np.append(0.0, shares.cumsum()), [first]
    least = fewest * shares[filled].min() * (1 - 1e-9)
    for k in range(first + 1, last + 1):
        if total[k] - total[chosen[-1]] >= least:
            chosen.append(k)
    chosen = [*chosen[: max(1, len(chosen) - 1)], last]
    return edges[chosen], np.diff(total[chosen]) / np.diff(edges[chosen])
