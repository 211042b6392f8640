"""Numbers against the load, with the theory of the surface; many results by mean and scatter."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..output.result import Result
from ..output.summary import converged, error_bars, is_finite, is_positive, last_held
from ..util.errors import SceneError
from .style import THEORY, WARNING, Page, Scale, Units, colour, label, log_axis, marker
from .theory import Theory

DOUBTFUL = {"color": WARNING, "marker": "x", "label": "not converged"}
BEYOND = 2  # factor by which the axis of loads goes on beyond the loads
MOST_NAMED = 6  # more results than this are shown by their mean and scatter
SAME_LOAD = 1e-6  # relative


class PlottedQuantity(NamedTuple):
    """A number of a load: in words, in TeX, and its unit of "pressure", "gap" and "length"."""

    name: str
    symbol: str = ""
    unit: tuple[tuple[str, int], ...] = ()


QUANTITIES = {  # by the names of the result file; the first ones are drawn by default
    "a_r": PlottedQuantity("contact area", "a_r"),
    "kappa": PlottedQuantity("", r"\kappa = a_r/p^*"),
    "gap_mean": PlottedQuantity("mean gap", r"\langle g \rangle", (("gap", 1),)),
    "approach": PlottedQuantity("approach", r"\delta", (("gap", 1),)),
    "p": PlottedQuantity("pressure", "p_0", (("pressure", 1),)),
    "stiffness": PlottedQuantity("stiffness", "k", (("pressure", 1), ("gap", -1))),
    "conductance": PlottedQuantity("conductance", "c", (("gap", -1),)),
    "critical_gap_x": PlottedQuantity("critical gap along x", "g_c", (("gap", 1),)),
    "critical_gap_y": PlottedQuantity("critical gap along y", "g_c", (("gap", 1),)),
    "contact_area": PlottedQuantity("contact area", "A", (("length", 2),)),
    "contact_pressure_mean": PlottedQuantity(
        "mean pressure in contact", r"\langle p \rangle_c", (("pressure", 1),)
    ),
    "contact_pressure_max": PlottedQuantity(
        "largest pressure", r"p_\mathrm{max}", (("pressure", 1),)
    ),
    "a_plastic": PlottedQuantity("area that yields", r"a_\mathrm{pl}"),
    "a_r_corrected": PlottedQuantity("contact area, edge-corrected", "a_r"),
    "patches": PlottedQuantity("number of patches"),
    "patch_largest": PlottedQuantity("largest patch", "A_1", (("length", 2),)),
    "patch_mean": PlottedQuantity("mean patch", r"\langle A \rangle", (("length", 2),)),
    "perimeter": PlottedQuantity("length of the edges of contact", "P", (("length", 1),)),
    "energy": PlottedQuantity("elastic energy per area", "U/A", (("pressure", 1), ("gap", 1))),
    "gap_over_h_rms": PlottedQuantity("mean gap", r"\langle g \rangle/h_\mathrm{rms}"),
}
CORRECTED = {"a_r": "a_r_corrected", "kappa": "kappa_corrected"}
OVERVIEW = ("a_r", "kappa", "gap_mean", "approach")


class DrawnSweep(NamedTuple):
    """The loads of a result that curves show; `pull_off`: the last one, of all, before the bodies
    separate, or None; `joined`: by lines, since loads follow from each other.
    """

    name: str
    result: Result
    units: Units
    theory: Theory | None
    pull_off: Mapping[str, Any] | None
    joined: bool


def drawn_sweep(
    name: str, whole: Result, chosen: list[int], units: Units, theory: Theory | None
) -> DrawnSweep:
    """Return the chosen loads of a result for `curves`."""
    scene = whole.readable_scene
    joined = scene is not None and (scene.material.adhesion is not None or scene.remembers)
    return DrawnSweep(name, whole.some(chosen), units, theory, last_held(whole.steps), joined)


def curves(sweeps: Sequence[DrawnSweep], names: list[str]) -> Page:
    """Return a page with a panel for each number; kappa is left out where it has no meaning."""
    units = {
        tuple(sweep.units.of(kind, [1.0]).name for kind in ("pressure", "gap")) for sweep in sweeps
    }
    if len(units) > 1:
        raise SceneError("results: have different units; dimensionless = True draws them together")
    against_time = all("time" in step for sweep in sweeps for step in sweep.result.steps)
    if against_time or not all(sweep.units.rough for sweep in sweeps):
        names = [name for name in names if name != "kappa"] or names
    steps = [step for sweep in sweeps for step in sweep.result.steps]
    has_bars = any(error_bars(name, step) for name in names for step in steps)
    label = f"simulation{' (bars: solver and grid)' * has_bars}"
    return Page([partial(_curve, sweeps=sweeps, key=name, label=label) for name in names])


def quantity_of(key: str) -> PlottedQuantity:
    """Return how a number of a load is shown; an unknown one has its key as name, and no unit."""
    return QUANTITIES.get(key) or PlottedQuantity(key.replace("_", " "))


def _scales(
    quantity: PlottedQuantity, sweep: DrawnSweep, sweeps: Sequence[DrawnSweep], key: str
) -> list[tuple[Scale, int]]:
    """Return (scale, power) of each factor of a unit of one of several results: prefixes suit all,
    what a relative unit divides by is its own.
    """
    values = [step.get(key) for sweep in sweeps for step in sweep.result.steps]
    positive = [float(value) for value in values if value is not None and is_positive(value)]
    surface = sweeps[0].result.surface
    typical = {
        "pressure": max(float(step["p"]) for sweep in sweeps for step in sweep.result.steps),
        "length": float(surface.get("physical_sizes", (1.0,))[0]),
        "gap": float(surface.get("h_rms") or 0.0),
    }
    alone = len(quantity.unit) == 1
    scales = []
    for kind, power in quantity.unit:
        sizes = [value ** (1 / power) for value in positive] if alone else [typical[kind]]
        scales.append((sweep.units.of(kind, sizes), power))
    return scales


def _axis_label(quantity: PlottedQuantity, scales: list[tuple[Scale, int]]) -> str:
    if not quantity.symbol:  # which has no unit either
        return quantity.name
    return f"{quantity.name} {label(quantity.symbol, *scales)}"


class LoadAxis(NamedTuple):
    """The axis of the loads, `key` over `unit`; `pressure`: the mean pressure at 1, or nan."""

    key: str
    unit: float
    pressure: float
    label: str

    @property
    def is_time(self) -> bool:
        """Whether it is an axis of times."""
        return self.key == "time"

    def of(self, step: Mapping[str, Any]) -> float:
        """Return the position of a load step on the axis."""
        return float(step[self.key]) / self.unit


class OnAxes(NamedTuple):
    """A result whose loads are drawn over `loads`, and one of whose numbers over `unit`."""

    sweep: DrawnSweep
    loads: LoadAxis
    unit: float

    def shown(self, key: str) -> list[tuple[float, float]]:
        """Return the points of a curve."""
        steps = self.sweep.result.steps
        return [
            (self.loads.of(step), step[key] / self.unit) for step in steps if _is_shown(key, step)
        ]


def _load_axis(sweep: DrawnSweep, sweeps: Sequence[DrawnSweep]) -> LoadAxis:
    """Return the axis of times, or forces in N, if every load of several results has one, else mean
    pressures; of one of them, as `_scales`.
    """
    steps = [step for each in sweeps for step in each.result.steps]
    units = sweep.units
    if all("time" in step for step in steps):
        name = sweep.result.surface.get("time_unit")
        return LoadAxis("time", 1.0, np.nan, f"time $t$ ({name})" if name else "time $t$")
    forces = [step.get("target_force") for step in steps]
    scale = units.of("force", forces)
    if all(isinstance(force, float) for force in forces) and scale.name:
        p, force = (sweep.result.steps[0][name] for name in ("p", "target_force"))
        pressure = scale.unit * p / force
        return LoadAxis("target_force", scale.unit, pressure, f"force {scale.label('F')}")
    scale = units.of("pressure", [step["p"] for step in steps])
    name = f"pressure {scale.label('p_0')}"
    if scale.relative and units.rough:
        name = r"pressure $p^* = p_0/(E^* g_\mathrm{rms})$"
    return LoadAxis("p", scale.unit, scale.unit, name)


def _curve(ax: Any, sweeps: Sequence[DrawnSweep], key: str, label: str) -> None:
    """Draw a number over the load with theory, pull-off and closed channels; above MOST_NAMED
    results by mean and scatter.
    """
    quantity = quantity_of(key)
    drawn = []
    for sweep in sweeps:
        scales = _scales(quantity, sweep, sweeps, key)
        unit = float(np.prod([scale.unit**power for scale, power in scales]))
        drawn.append(OnAxes(sweep, _load_axis(sweep, sweeps), unit))
    loads = drawn[0].loads
    if len(drawn) > MOST_NAMED:
        _mean_and_scatter(ax, drawn, key)
    else:
        for k, curve in enumerate(drawn):
            name = label if len(drawn) == 1 else curve.sweep.name
            how = {"color": colour(k), "marker": marker(k), "label": name}
            _points(ax, curve, key, how)
    if key in CORRECTED and len(drawn) == 1:
        how = {"color": colour(1), "marker": marker(1), "label": "edge-corrected"}
        _points(ax, drawn[0], CORRECTED[key], how)
    ax.set_xlabel(loads.label)
    ax.set_ylabel(_axis_label(quantity, scales))
    all_loads = [curve.loads.of(step) for curve in drawn for step in curve.sweep.result.steps]
    pushed = min(all_loads) > 0
    if pushed and not loads.is_time:
        log_axis(ax, "x")
    _limits(ax, all_loads, pushed)  # before theories, which may leave the panel
    if loads.is_time:
        _time_axis(ax, all_loads)
        return
    for k, curve in enumerate(drawn if len(drawn) <= MOST_NAMED else ()):
        _pull_off(ax, curve, colour(k))
    if len(drawn) > MOST_NAMED:
        _theory(ax, drawn[0], key, None, ", first result")
    else:
        for k, curve in enumerate(drawn):
            _theory(ax, curve, key, colour(k) if len(drawn) > 1 else None)
    if key.startswith("critical_gap"):
        _tight(ax, drawn, key)


def _time_axis(ax: Any, times: list[float]) -> None:
    """Make the axis of times logarithmic from the first time after 0 on, and linear before it."""
    later = [time for time in times if time > 0]
    if later and max(later) > min(later):
        ax.set_xscale("symlog", linthresh=min(later))
        ax.set_xlim(min(0.0, *times) - 0.2 * min(later), max(later) * BEYOND)


def _points(ax: Any, drawn: OnAxes, key: str, how: dict[str, Any]) -> None:
    """Draw a number of each load with error bars, joined by lines if loads have a memory."""
    sweep, loads, unit = drawn
    for is_converged, changes in ((True, {}), (False, DOUBTFUL)):
        steps = [
            step
            for step in sweep.result.steps
            if converged(step) == is_converged and _is_shown(key, step)
        ]
        if not steps:
            continue
        x = np.array([loads.of(step) for step in steps])
        y = np.array([step[key] / unit for step in steps], dtype=float)
        relative = [error_bars(key, step) for step in steps]
        bars = None
        if any(relative):
            below_and_above = np.array([error or (0.0, 0.0) for error in relative]).T
            bars = np.abs(y) * np.nan_to_num(below_and_above, posinf=0)
        joined = sweep.joined or loads.is_time
        line = {"linestyle": "-" if is_converged and joined else "", "linewidth": 0.8}
        look = line | {"capsize": 1.5, "elinewidth": 0.8} | how | changes
        ax.errorbar(x, y, bars, **look)


def is_tight(key: str, step: Mapping[str, Any]) -> bool:
    """Whether a number of a load is a critical gap of 0: no channel is open."""
    return key.startswith("critical_gap") and bool(step.get(key) == 0)


def _is_shown(key: str, step: Mapping[str, Any]) -> bool:
    """Whether a load is a point of a curve: its number is finite and not a critical gap of 0."""
    return is_finite(step.get(key)) and not is_tight(key, step)


def _mean_and_scatter(ax: Any, drawn: Sequence[OnAxes], key: str) -> None:
    """Draw mean and standard deviation of results; as points of one colour if loads differ."""
    rows = [curve.shown(key) for curve in drawn]
    curves_of_results = [np.array(row, dtype=float) for row in rows if row]
    if not curves_of_results:
        return
    x = curves_of_results[0][:, 0]
    alike = all(
        len(curve) == len(x) and np.allclose(curve[:, 0], x, rtol=SAME_LOAD)
        for curve in curves_of_results
    )
    steps = [step for curve in drawn for step in curve.sweep.result.steps]
    failed = sum(not converged(step) for step in steps)
    number = f"{len(curves_of_results)} results" + f" ({failed} loads NOT CONVERGED)" * (failed > 0)
    if not alike:
        ax.plot(*np.concatenate(curves_of_results).T, ".", color=colour(0), label=number)
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
    ax.plot(x, mean, "o-", color=colour(0), label=f"mean of {number}")


def _tight(ax: Any, drawn: Sequence[OnAxes], key: str) -> None:
    """Shade loads without an open channel in any result: 0 would not show on a logarithmic axis."""
    steps = sorted(
        (curve.loads.of(step), is_tight(key, step))
        for curve in drawn
        for step in curve.sweep.result.steps
    )
    largest_open = max((load for load, tight in steps if not tight), default=-np.inf)
    tight_loads = [load for load, tight in steps if tight and load > largest_open]
    if tight_loads:
        right = max(ax.get_xlim()[1], tight_loads[-1] * BEYOND)
        ax.axvspan(tight_loads[0], right, color="0.9", zorder=0, label="tight")
        ax.set_xlim(right=right)


def _theory(ax: Any, drawn: OnAxes, key: str, line_colour: Any, whose: str = "") -> None:
    """Draw the theory of a result's surface, if there is one and all loads are > 0."""
    sweep, loads, unit = drawn
    if not (sweep.theory and key in sweep.theory.curves):
        return
    loads_of_steps = [loads.of(step) for step in sweep.result.steps]
    if min(loads_of_steps) <= 0:
        return
    x = np.geomspace(min(loads_of_steps) / BEYOND, max(loads_of_steps) * BEYOND, 80)
    values = sweep.theory.curves[key](loads.pressure * x) / unit
    line = THEORY | ({} if line_colour is None else {"color": line_colour})
    ax.plot(x, values, zorder=1, label=f"{sweep.theory.name}{whose}", **line)


def _pull_off(ax: Any, drawn: OnAxes, line_colour: Any) -> None:
    """Mark the last load before the surfaces of a result separate; nothing if they do not."""
    if drawn.sweep.pull_off is not None:
        held = drawn.loads.of(drawn.sweep.pull_off)
        ax.axvline(held, color=line_colour, linestyle=":", linewidth=0.8, label="pull-off")


def _limits(ax: Any, all_loads: list[float], pushed: bool) -> None:
    """Set the limits around what is drawn, else all_loads; y is logarithmic beyond a decade."""
    left, low, right, high = ax.dataLim.extents
    if left > right:  # nothing is drawn
        left = min(all_loads)
        low = 0.0
        right = max(all_loads)
        high = 1.0
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
