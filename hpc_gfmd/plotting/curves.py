"""Contact area, mean gap and other numbers against the load, with the theory of the surface.

Several results are drawn one by one; if they are many, their mean and scatter.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from ..output.summary import converged
from ..util.errors import SceneError
from .context import FigureContext
from .page import Page
from .quantities import LoadAxis, PlottedQuantity, load_axis, quantity_of, relative_error
from .style import THEORY, WARNING, colour, log_axis, marker
from .units import finite

DOUBTFUL = {"color": WARNING, "marker": "x", "label": "not converged"}
BEYOND = 2  # factor by which the axis of loads goes on beyond the loads
MOST_NAMED = 6  # more results than this are shown by their mean and scatter
SAME_LOAD = 1e-6  # relative


def curves(contexts: Sequence[FigureContext], names: list[str]) -> Page:
    """Return a page with a panel for each number, of one result or of several together.

    Parameters
    ----------
    contexts : sequence of FigureContext
        One for each result.
    names : list of str
        Numbers of a load, by their names in the result file. kappa is left out if p* has no meaning
        for one of the surfaces, unless it is the only name.

    Returns
    -------
    Page
        Not drawn yet.

    Raises
    ------
    SceneError
        If the results have different units.
    """
    units = {
        tuple(context.units.of(kind, [1.0]).name for kind in ("pressure", "gap"))
        for context in contexts
    }
    if len(units) > 1:
        raise SceneError(
            "results: found different units, allowed: the same for all, or dimensionless = True"
        )
    if not all(context.units.rough for context in contexts):
        names = [name for name in names if name != "kappa"] or names
    return Page([partial(_panel, contexts=list(contexts), key=name) for name in names])


def _panel(ax: Any, contexts: list[FigureContext], key: str) -> None:
    """Draw one number over the load on axes, and set labels, scales and limits.

    Up to MOST_NAMED results are drawn one by one, more by their mean and scatter; theory, pull-off
    and loads without an open channel are added where they apply.
    """
    quantity = quantity_of(key)
    loads = load_axis(contexts)
    scales = quantity.scales(contexts, key)
    unit = float(np.prod([scale.unit**power for scale, power in scales]))
    if len(contexts) > MOST_NAMED:
        _mean_and_scatter(ax, contexts, key, loads, unit)
    else:
        for k, context in enumerate(contexts):
            bars = " (bars: solver and grid)" if quantity.errors else ""
            name = f"simulation{bars}" if len(contexts) == 1 else context.name
            how = {"color": colour(k), "marker": marker(k), "label": name}
            _points(ax, context, key, quantity, loads, unit, how)
    if key == "kappa" and len(contexts) == 1:
        how = {"color": colour(1), "marker": marker(1), "label": "edge-corrected"}
        corrected = PlottedQuantity("", "")
        _points(ax, contexts[0], "kappa_corrected", corrected, loads, unit, how)
    ax.set_xlabel(loads.label)
    ax.set_ylabel(quantity.label(scales))
    all_loads = [loads.of(step) for context in contexts for step in context.result.steps]
    pushed = min(all_loads) > 0
    if pushed:
        log_axis(ax, "x")
    _limits(ax, all_loads, pushed)  # before theories, which may leave the panel
    for k, context in enumerate(contexts if len(contexts) <= MOST_NAMED else ()):
        _pull_off(ax, context, loads, colour(k))
    with_theory = contexts if len(contexts) <= MOST_NAMED else contexts[:1]
    for k, context in enumerate(with_theory):
        one_line = len(with_theory) == 1
        _theory(ax, context, key, loads, unit, None if one_line else colour(k))
    if key.startswith("critical_gap"):
        _tight(ax, contexts, key, loads)


def _points(
    ax: Any,
    context: FigureContext,
    key: str,
    quantity: PlottedQuantity,
    loads: LoadAxis,
    unit: float,
    how: dict[str, Any],
) -> None:
    """Draw the number `key` of every load of one result over the load, on axes.

    Loads that did not converge get other marks; those without a value that can be shown are left
    out, see `_is_shown`. quantity: its errors, if it has any, give the error bars. unit: values are
    divided by it. how: color, marker and label of errorbar. Points are joined by lines if the
    surfaces attract.
    """
    for is_converged, changes in ((True, {}), (False, DOUBTFUL)):
        steps = [
            step
            for step in context.result.steps
            if converged(step) == is_converged and _is_shown(key, step)
        ]
        if not steps:
            continue
        x = np.array([loads.of(step) for step in steps])
        y = np.array([step[key] / unit for step in steps], dtype=float)
        relative = np.array([relative_error(quantity, step) for step in steps])
        bars = np.abs(y) * np.nan_to_num(relative, posinf=0) if quantity.errors else None
        # on a branch loads follow from each other
        line = {"linestyle": "-" if is_converged and context.attracts else "", "linewidth": 0.8}
        look = line | {"capsize": 1.5, "elinewidth": 0.8} | how | changes
        ax.errorbar(x, y, bars, **look)


def is_tight(key: str, step: Mapping[str, Any]) -> bool:
    """Whether a number of a load is a critical gap of 0: no channel is open.

    Parameters
    ----------
    key : str
        Name of the number in the result file.
    step : mapping
        Attributes of the load step.

    Returns
    -------
    bool
        False for any other number.
    """
    return key.startswith("critical_gap") and bool(step.get(key) == 0)


def _is_shown(key: str, step: Mapping[str, Any]) -> bool:
    """Whether a load is a point of a curve: its number is finite and not a critical gap of 0."""
    return finite(step.get(key)) and not is_tight(key, step)


def _mean_and_scatter(
    ax: Any, contexts: list[FigureContext], key: str, loads: LoadAxis, unit: float
) -> None:
    """Draw the mean of many results on axes, with a band of one standard deviation.

    Loads without a value that can be shown are left out; nothing is drawn if none has one. If the
    results that have any differ in their loads, all are drawn as points of one colour instead.
    """
    rows = [
        [
            (loads.of(step), step[key] / unit)
            for step in context.result.steps
            if _is_shown(key, step)
        ]
        for context in contexts
    ]
    curves_of_results = [np.array(row, dtype=float) for row in rows if row]
    if not curves_of_results:
        return
    x = curves_of_results[0][:, 0]
    alike = all(
        len(curve) == len(x) and np.allclose(curve[:, 0], x, rtol=SAME_LOAD)
        for curve in curves_of_results
    )
    number = len(curves_of_results)
    if not alike:
        ax.plot(
            *np.concatenate(curves_of_results).T, ".", color=colour(0), label=f"{number} results"
        )
        return
    values = np.array([curve[:, 1] for curve in curves_of_results])
    mean = values.mean(axis=0)
    deviation = values.std(axis=0, ddof=1)
    ax.fill_between(
        x,
        mean - deviation,
        mean + deviation,
        color=colour(0),
        alpha=0.25,
        linewidth=0,
        label="standard deviation",
    )
    ax.plot(x, mean, "o-", color=colour(0), label=f"mean of {number} results")


def _tight(ax: Any, contexts: list[FigureContext], key: str, loads: LoadAxis) -> None:
    """Shade the loads from which on no result has an open channel: their critical gap is 0.

    Such gaps would not show on a logarithmic axis. The right limit of the axis stays.
    """
    steps = sorted((step for context in contexts for step in context.result.steps), key=loads.of)
    open_loads = [k for k, step in enumerate(steps) if not is_tight(key, step)]
    tight_loads = steps[open_loads[-1] + 1 if open_loads else 0 :]
    if tight_loads:
        right = ax.get_xlim()[1]
        ax.axvspan(loads.of(tight_loads[0]), right, color="0.9", zorder=0, label="tight")
        ax.set_xlim(right=right)


def _theory(
    ax: Any, context: FigureContext, key: str, loads: LoadAxis, unit: float, line_colour: Any
) -> None:
    """Draw the theory of a result's surface on axes; nothing if there is none or a load is not > 0.

    line_colour: None takes the colour of a single theory.
    """
    if not (context.theory and key in context.theory.curves):
        return
    loads_of_steps = [loads.of(step) for step in context.result.steps]
    if min(loads_of_steps) <= 0:
        return
    x = np.geomspace(min(loads_of_steps) / BEYOND, max(loads_of_steps) * BEYOND, 80)
    values = context.theory.curves[key](loads.pressure_of(x)) / unit
    line = THEORY | ({} if line_colour is None else {"color": line_colour})
    ax.plot(x, values, zorder=1, label=context.theory.name, **line)


def _pull_off(ax: Any, context: FigureContext, loads: LoadAxis, line_colour: Any) -> None:
    """Mark the last load before the surfaces of a result separate; nothing if they do not."""
    if context.pull_off is not None:
        held = loads.of(context.pull_off)
        ax.axvline(held, color=line_colour, linestyle=":", linewidth=0.8, label="pull-off")


def _limits(ax: Any, all_loads: list[float], pushed: bool) -> None:
    """Set the limits of axes around what has been drawn.

    The y axis becomes logarithmic if positive values span more than a decade. all_loads: the x axis
    shows them if nothing has been drawn. pushed: whether all of them are above 0 and the x axis is
    logarithmic.
    """
    left, low, right, high = ax.dataLim.extents
    if left > right:
        left, low, right, high = min(all_loads), 0.0, max(all_loads), 1.0
    if pushed:
        ax.set_xlim(left / BEYOND, right * BEYOND)
    else:
        beyond = 0.05 * (right - left) or 1.0
        ax.set_xlim(left - beyond, right + beyond)
    if low > 0 and high > 10 * low:
        log_axis(ax, "y")
        ax.set_ylim(low / 2, high * 2)
    else:
        low = min(0, low)
        ax.set_ylim(low, high + 0.15 * (high - low) or 1)
