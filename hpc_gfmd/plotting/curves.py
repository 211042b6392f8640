"""Contact area, mean gap and what else was asked for over the load, with the theory of the
surface."""

from collections.abc import Sequence
from functools import partial
from math import hypot
from typing import Any, NamedTuple

import numpy as np

from ..output.summary import converged
from ..util.errors import SceneError
from .context import FigureContext
from .page import Page
from .style import THEORY, WARNING, colour, log_axis
from .units import Scale, finite

DOUBTFUL = {"color": WARNING, "marker": "x", "label": "not converged"}
BEYOND = 2  # of the loads: how far the axis goes on


class Quantity(NamedTuple):
    """What a panel shows: a symbol, the keys of its relative errors in a load step, whether it is
    measured in the unit of heights."""

    symbol: str
    errors: tuple[str, ...] = ()
    length: bool = False


AREA = ("a_r_error", "a_r_discretisation")
QUANTITIES = {
    "a_r": Quantity("a_r", AREA),
    "kappa": Quantity(r"\kappa = a_r/p^*", AREA),
    "gap_mean": Quantity(r"\langle g \rangle", ("gap_error",), True),
    "approach": Quantity(r"\delta", (), True),
}


def curves(contexts: Sequence[FigureContext], names: list[str]) -> Page:
    """Make a panel for each quantity, of one result or of several together. Raises SceneError where
    they are not measured in the same units."""
    units = {tuple(one.units.of(of, [1.0]).name for of in ("pressure", "gap")) for one in contexts}
    if len(units) > 1:
        raise SceneError(
            "results: found different units, allowed: the same for all, or dimensionless = True"
        )
    if not all(one.units.rough for one in contexts):
        names = [name for name in names if name != "kappa"] or names
    return Page([partial(_panel, contexts=contexts, key=name) for name in names])


def _panel(ax: Any, contexts: Sequence[FigureContext], key: str) -> None:
    quantity, alone = QUANTITIES[key], len(contexts) == 1
    every, theories = [step for one in contexts for step in one.result.steps], []
    for k, one in enumerate(contexts):
        x = one.units.of("pressure", [step["p"] for step in every])
        y = one.units.of("gap", [step.get(key) for step in every]) if quantity.length else Scale()
        name = "simulation (bars: solver and grid)" if alone else one.name
        _points(ax, one, key, (x, y), quantity.errors, color=colour(k), marker="o", label=name)
        if key == "kappa" and alone:
            _points(
                ax,
                one,
                "kappa_corrected",
                (x, y),
                (),
                color=colour(1),
                marker="s",
                label="edge-corrected",
            )
        if one.theory and key in one.theory.curves:
            loads = [step["p"] for step in one.result.steps]
            p = np.geomspace(min(loads) / BEYOND, max(loads) * BEYOND, 80)
            line = THEORY | ({} if alone else {"color": colour(k)}) | {"label": one.theory.name}
            theories.append((p / x.unit, one.theory.curves[key](p) / y.unit, line))
    p_star = x.relative and one.units.rough
    ax.set_xlabel(r"$p^* = p_0/(E^* g_\mathrm{rms})$" if p_star else x.label("p_0"))
    ax.set_ylabel(y.label(quantity.symbol))
    log_axis(ax, "x")
    _limits(ax)  # a theory may leave the panel, a load with its error may not
    for p, values, line in theories:
        ax.plot(p, values, zorder=1, **line)


def _points(
    ax: Any,
    context: FigureContext,
    key: str,
    scales: tuple[Scale, Scale],
    errors: tuple[str, ...],
    **how: Any,
) -> None:
    for sound, changed in ((True, {}), (False, DOUBTFUL)):
        steps = [
            step
            for step in context.result.steps
            if converged(step) == sound and finite(step.get(key))
        ]
        if steps:
            x, y = np.array([[s["p"] / scales[0].unit, s[key] / scales[1].unit] for s in steps]).T
            relative = np.array([hypot(*(s.get(error) or 0.0 for error in errors)) for s in steps])
            bars = np.abs(y) * np.nan_to_num(relative, posinf=0) if errors else None
            how = {"linestyle": "", "capsize": 1.5, "elinewidth": 0.8} | how | changed
            ax.errorbar(x, y, bars, **how)


def _limits(ax: Any) -> None:
    """Frame what has been drawn."""
    x0, low, x1, high = ax.dataLim.extents
    ax.set_xlim(x0 / BEYOND, x1 * BEYOND)
    if low > 0 and high > 10 * low:
        log_axis(ax, "y")
        ax.set_ylim(low / 2, high * 2)
    else:
        low = min(0, low)
        ax.set_ylim(low, high + 0.15 * (high - low) or 1)
