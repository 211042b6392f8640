"""Contact area, mean gap and what else was asked for over the load, with the theory of the
surface."""

from collections.abc import Callable, Sequence
from functools import partial
from math import hypot
from typing import Any, NamedTuple

import numpy as np

from ..output.summary import converged
from ..util.errors import SceneError
from .context import FigureContext
from .page import Page
from .style import THEORY, WARNING, colour, log_axis
from .theories import Theory
from .units import Scale, finite, good

DOUBTFUL = {"color": WARNING, "marker": "x", "label": "not converged"}
BEYOND = 2  # of the loads: how far the axis goes on


class Quantity(NamedTuple):
    """What a panel shows: a symbol, the keys of its relative errors in a load step, the name in
    theories.Theory, whether it is measured in the unit of heights."""

    symbol: str
    errors: tuple[str, ...] = ()
    theory: str = ""
    length: bool = False


AREA = ("a_r_error", "a_r_discretisation")
QUANTITIES = {
    "a_r": Quantity("a_r", AREA, "area"),
    "kappa": Quantity(r"\kappa = a_r/p^*", AREA),
    "gap_mean": Quantity(r"\langle g \rangle", ("gap_error",), "gap", True),
    "approach": Quantity(r"\delta", (), "approach", True),
}


def curves(contexts: Sequence[FigureContext], names: Sequence[str]) -> Page:
    """Make a panel for each quantity that the loads have, of one result or of several together.
    Raises SceneError where they are not measured in the same units."""
    units = {(one.units.pressures([1.0]).name, one.units.heights([1.0]).name) for one in contexts}
    if len(units) > 1:
        raise SceneError(
            "results: found different units, allowed: the same for all, or dimensionless = True"
        )
    panels = [
        partial(_panel, contexts=contexts, key=key)
        for key in names
        if any(good(step.get(key)) for one in contexts for step in _steps(one))
        and (key != "kappa" or all(one.units.rough for one in contexts))
    ]
    columns = 2 if len(panels) == 4 else 3
    return Page([panels[i : i + columns] for i in range(0, len(panels), columns)], height=2.2)


def _steps(context: FigureContext) -> list[dict]:
    return [step for step in context.steps if good(step.get("p"))]


def _panel(ax: Any, contexts: Sequence[FigureContext], key: str) -> None:
    quantity, alone = QUANTITIES[key], len(contexts) == 1
    every, theories = [step for one in contexts for step in _steps(one)], []
    for k, one in enumerate(contexts):
        x = one.units.pressures([step["p"] for step in every])
        y = one.units.heights([step.get(key) for step in every]) if quantity.length else Scale(1.0)
        name = "simulation (bars: solver and grid)" if alone else one.name
        _points(ax, one, key, (x, y), quantity.errors, color=colour(k), marker="o", label=name)
        if key == "kappa" and alone:
            how = {"color": colour(1), "marker": "s", "label": "edge-corrected"}
            _points(ax, one, "kappa_corrected", (x, y), (), **how)
        theory: Any = one.theory
        function = theory and _theory(theory, one.units.p_star, key)
        if function:
            loads = [step["p"] for step in _steps(one)]
            p = np.geomspace(min(loads) / BEYOND, max(loads) * BEYOND, 80)
            line = THEORY | ({} if alone else {"color": colour(k)}) | {"label": theory.name}
            theories.append((p / x.unit, function(p) / y.unit, line))
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
            step for step in _steps(context) if converged(step) == sound and finite(step.get(key))
        ]
        if steps:
            x, y = np.array([[s["p"] / scales[0].unit, s[key] / scales[1].unit] for s in steps]).T
            relative = np.array([hypot(*(s.get(error) or 0.0 for error in errors)) for s in steps])
            bars = np.abs(y) * np.where(np.isfinite(relative), relative, 0) if errors else None
            how = {"linestyle": "", "capsize": 1.5, "elinewidth": 0.8} | how | changed
            ax.errorbar(x, y, bars, **how)


def _theory(theory: Theory, p_star: float | None, key: str) -> Callable | None:
    """Return what theory says of a quantity, as a function of the pressure; p_star: that of p* =
    1."""
    area = theory.area
    if key == "kappa":
        return (lambda p: p_star * area(p) / p) if area and p_star else None
    return getattr(theory, QUANTITIES[key].theory)


def _limits(ax: Any) -> None:
    """Frame what has been drawn."""
    x0, y0, x1, y1 = ax.dataLim.extents
    ax.set_xlim(x0 / BEYOND, x1 * BEYOND)
    if y0 > 0 and y1 > 10 * y0:
        log_axis(ax, "y")
        ax.set_ylim(y0 / 2.5, y1 * 2.5)
    else:
        ax.set_ylim(min(0, y0), y1 + 0.15 * ((y1 - min(y0, 0)) or 1.0))
