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
NAMES = {  # symbol, title, how many of the smallest count a bin has at least, power of the unit
    "pressure": ("p", "pressure in the contact", 4, 1),
    "gap": ("g", "gap outside", 4, 1),
    "patches": ("A", "contact patches", 1, 2),
}


def distributions(contexts: Sequence[FigureContext], names: list[str]) -> Page:
    """Make a panel for each distribution of one result, stored or of its fields."""
    return Page([partial(_panel, context=contexts[0], name=name) for name in names])


def _panel(ax: Any, context: FigureContext, name: str) -> None:
    symbol, title, fewest, power = NAMES[name]
    steps = zip(context.result.steps, context.result.fields)
    found = [
        (k, *_joined(*shares, fewest))
        for k, (step, fields) in enumerate(steps)
        if (shares := _shares(step, fields, name))
    ]
    highest = max((edges[-1] for _, edges, _ in found), default=1.0)
    scale = context.lengths if power == 2 else context.units.of(name, [highest])
    unit = scale.unit**power
    for k, edges, values in found:
        how = {"baseline": None, "color": colour(k), "label": context.name_of(k)}
        ax.stairs(values * unit, edges / unit, linewidth=1.1, **how)
    density = label(f"P({symbol})", (scale, -power))
    ax.set(xlabel=scale.label(symbol, power), ylabel=density, title=title)
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


def _shares(step: dict, fields: dict, name: str) -> tuple[np.ndarray, np.ndarray] | None:
    """Return (edges, share of the area in each bin, of patches of their number) of a load step;
    None where there is nothing."""
    edges, shares = np.zeros(0), np.zeros(0)
    if f"{name}_edges" in step:
        edges, density = (np.array(step[f"{name}_{x}"], float) for x in ("edges", "density"))
        share = {"pressure": step["a_r"], "gap": 1 - step["a_r"]}.get(name, 1.0)
        shares = density * np.diff(edges) * share
    elif name in fields:
        edges, shares = histogram(fields, name)
    return (edges, shares) if shares.any() else None


def _joined(edges: np.ndarray, shares: np.ndarray, fewest: int) -> tuple[np.ndarray, np.ndarray]:
    """Return (edges, density) of a histogram without empty ends, in bins that are joined until each
    has `fewest` times the smallest count of all."""
    filled = np.flatnonzero(shares)
    last, chosen, total = filled[-1] + 1, [filled[0]], np.append(0.0, shares.cumsum())
    least = fewest * shares[filled].min() * (1 - 1e-9)
    while (k := np.searchsorted(total, total[chosen[-1]] + least)) <= last:
        chosen.append(k)
    chosen = [*chosen[: max(1, len(chosen) - 1)], last]
    return edges[chosen], np.diff(total[chosen]) / np.diff(edges[chosen])
