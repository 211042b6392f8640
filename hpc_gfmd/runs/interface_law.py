"""Interface law from as few loads as its interpolation needs.

Each interval of pressures is checked by a load in its middle, and halved if that deviates or if few
points touch: they come into contact one by one, so that a load between may deviate by chance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ..contact import all_numbers, all_observables
from ..output.interface_law import LOAD_AT, QUANTITIES, InterfaceLaw, interpolate
from ..output.numbers import unit_of
from ..output.summary import critical_gap_error, error_bars
from ..util.errors import SceneError
from ..util.quantities import Quantity, finite_number, parse
from .law_sampler import Sampler, Steps

# Beginnings of the names of numbers that are no smooth functions of the load: they depend on single
# points, or count patches or sides of points.
UNEVEN = (
    *("contact_pressure_max", "perimeter", "patch"),
    *("contact_percolates", "gap_percolates", "gap_spans"),
)
# Errors contain so many standard deviations by chance. Chosen: of 5,100 loads between those of laws
# of 120 walls with 20 to 5,000 points in contact 0.2 % have an area or stiffness beyond them, 14 to
# 25 % without; with 2 it would be 0.5 %.
BY_CHANCE = 3.0
# Relative error of a stiffness over that of a_r divided by 1 - a_r. Measured on 398 walls: 4 errors
# were larger, by half at most; half of them are below 0.04.
OF_STIFFNESS = 0.5
OF_GRID = ("a_r_discretisation", "gap_discretisation", "a_r_corrected")  # tell errors by the grid
Sample = Callable[[list[float]], list[Steps]]  # takes pressures, returns the loads of each surface


def interface_law(
    surfaces: Any,
    start: float | str,
    stop: float | str,
    error: float = 0.05,
    *,
    quantities: Sequence[str] = QUANTITIES,
    realisations: int = 1,
    progress: bool = False,
    comm: Any = None,
    **keys: Any,
) -> InterfaceLaw:
    """Compute contact area, gap, stiffness, conductance and critical gap against the mean pressure.

    Parameters
    ----------
    surfaces : array, PreparedSurface, Topography, path of a scene, Scene, or a list of them
        What `solve` takes, or scenes, whose [load] and [output] are ignored. The law of several
        surfaces is their mean, with its scatter.
    start, stop : float or str
        Range of mean pressures, in the unit of E_star, or with a unit as "1 MPa".
    error : float
        Relative deviation, of the load amid an interval from the law without it, up to which no
        more are solved, from 1e-4 to 0.5. Loads between deviate by up to the `errors` of the law.
    quantities : sequence of str
        Numbers of a load, by the names of the result file, such as critical_gap_x for the load at
        which a seal is tight; not those that jump from load to load,
        such as contact_pressure_max. The conductance is stiffness/E_star, also with free edges:
        without the spreading resistance of a lone body, which the finite-element model has itself.
    realisations : int
        Number of surfaces of each scene with a self-affine surface: with seeds `seed`, `seed` + 1,
        ...
    progress : bool
        Whether to show the progress of each load.
    comm : communicator of mpi4py, optional
        For scripts under mpirun, as in `solve`: every rank calls this with the same surfaces.
        Default: this process alone, even under mpirun.
    **keys
        For surfaces that are no scenes: other arguments of `solve`, such as E_star and accuracy
        (default: a tenth of `error`, unless `residual` is given). A scene has its own accuracy,
        which becomes a tenth of `error` if it is coarser, or its residual.

    Returns
    -------
    InterfaceLaw
        `write_law(law, "law.csv")`, `write_law(law, "law.inp")` write it for other programs, in
        other units as `write_law(law.in_units("mm-N-MPa"), ...)`.

    Raises
    ------
    SceneError
        For invalid input, in one line, on all ranks.

    Notes
    -----
    Values are interpolated monotonically (PCHIP) in log-log. An interval is accepted if the load in
    its middle deviates by less than `error`, or by less than that load's own estimated error, and
    so does, in its halves, the standard deviation that follows from the number of points in
    contact, as they touch one by one; or if the interval itself is shorter than `error`, as at the
    load that closes a seal. With few points in contact a law of a small `error` takes many loads.

    Examples
    --------
    >>> law = hpc_gfmd.interface_law(scan, "1 MPa", "1 GPa", E_star="110 GPa")
    >>> law("conductance", 20e6)
    """
    low = _positive_pressure(start, "start")
    high = _positive_pressure(stop, "stop")
    if not low < high or isinstance(low, Quantity) != isinstance(high, Quantity):
        raise SceneError(
            f"start, stop: found {start} and {stop}, allowed: the first below the second, both with"
            " units or both plain"
        )
    if not 1e-4 <= finite_number(error) <= 0.5:
        raise SceneError(f"error: found {error!r}, allowed: a number from 1e-4 to 0.5")
    names = [quantities] if isinstance(quantities, str) else list(quantities)
    unknown = sorted(set(names) - set(all_observables()))
    if isinstance(quantities, str) or not names or unknown:
        raise SceneError(
            f"quantities: found {unknown or quantities!r}, allowed: a list out of"
            f" {', '.join(QUANTITIES)}, or of other observables"
        )
    uneven = sorted(name for name in names if name.startswith(UNEVEN))
    if uneven:
        raise SceneError(
            f"quantities: found {', '.join(uneven)}, which jump from load to load, so that no"
            " error of an interpolation is known; solve the pressures that are needed instead"
        )
    sampler = Sampler(surfaces, names, error, realisations, keys, comm, progress, low)
    curves = _Curves(quantities, error)
    curves.refine(sampler, float(low), float(high))
    return curves.law(sampler.surface, sampler.gap_at_touch, sampler.about)


class _Curves:
    """Solved loads of all surfaces by pressure, and how well the law predicted them."""

    def __init__(self, quantities: Sequence[str], error: float) -> None:
        self.quantities = quantities  # numbers of a load that the law is of
        self.error = error  # largest deviation that is accepted, relative
        self.steps: dict[float, Steps] = {}  # attributes of the load of each surface, by pressure
        # By interval, one between neighbouring pressures or one that was halved later: relative
        # deviation of quantities, from the law without it, of the load that was the last to test
        # the interval: the one in the middle of the interval of which it is a half.
        self.deviations: dict[tuple[float, float], dict[str, float]] = {}

    def refine(self, sample: Sample, low: float, high: float) -> None:
        """Solve loads, by sample(pressures), from low to high until each interval is accepted."""
        middle = math.sqrt(low * high)
        self._add([low, middle, high], sample)
        pending = [(low, middle), (middle, high)]
        while pending:
            middles = [math.sqrt(a * b) for a, b in pending]
            predicted = {
                name: interpolate(*self.curve(name), np.array(middles)) for name in self.quantities
            }
            self._add(middles, sample)
            halves = []
            for k, (interval, middle) in enumerate(zip(pending, middles, strict=True)):
                at_middle = {name: values[k] for name, values in predicted.items()}
                if not self._accepts(interval, middle, at_middle):
                    halves += [(interval[0], middle), (middle, interval[1])]
            pending = halves

    def _add(self, pressures: list[float], sample: Sample) -> None:
        """Solve all surfaces at some pressures and store the results in `steps`."""
        of_surfaces = sample(sorted(pressures))
        for k, pressure in enumerate(sorted(pressures)):
            self.steps[pressure] = [steps[k] for steps in of_surfaces]

    def _accepts(
        self, interval: tuple[float, float], middle: float, predicted: Mapping[str, float]
    ) -> bool:
        """Whether all quantities of the load in the middle of an interval are near `predicted`, the
        law without it, and none falls from positive to 0. Intervals shorter than `error` are
        accepted. Sets `deviations`: inf where only the load has a value.
        """
        deviations = {}
        accepted = True
        for name in self.quantities:
            solved_value = _mean(name, self.steps[middle])
            if not math.isfinite(solved_value):
                continue
            scale = max(abs(solved_value), abs(predicted[name]))
            deviation = abs(solved_value - predicted[name]) / scale if scale > 0 else 0.0
            if math.isnan(deviation):  # the law begins or ends within the interval
                deviation = math.inf
            deviations[name] = deviation
            ends = [_mean(name, self.steps[pressure]) for pressure in interval]
            closes = min(ends) == 0 < max(ends)  # somewhere within the interval
            of_load = _estimated_error(name, self.steps[middle])
            halves = ((interval[0], middle), (middle, interval[1]))
            by_chance = max(self._by_chance(name, *half) for half in halves)
            accurate = max(deviation, by_chance) <= max(self.error, of_load)
            accepted = accepted and accurate and not closes
        low, high = interval
        self.deviations[low, middle] = self.deviations[middle, high] = deviations
        return accepted or math.log(interval[1] / interval[0]) <= self.error

    def _by_chance(self, name: str, low: float, high: float) -> float:
        """Return the relative standard deviation of a quantity from the law between two pressures,
        because points touch one by one: as if the load were wrong by that of the n points that
        touch, sqrt(log(high/low)/4 n) in the middle.
        """
        n = sum(step["contact_points"] for step in self.steps[low])
        ends = _mean(name, self.steps[low]), _mean(name, self.steps[high])
        if n == 0 or not (min(ends) > 0 and math.isfinite(max(ends))):
            return 0.0
        change = abs(math.log(ends[1] / ends[0]))
        return change / math.sqrt(4 * n * math.log(high / low))

    def curve(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Return (pressures, values) of a quantity, means over surfaces, nan if one has none."""
        pressures = sorted(self.steps)
        return np.array(pressures), np.array([_mean(name, self.steps[p]) for p in pressures])

    def law(
        self, surface: Mapping[str, Any], gap_at_touch: float, remarks: Sequence[str]
    ) -> InterfaceLaw:
        """Return the law from all solved loads, without quantities that have no value. surface: its
        attributes; remarks: lines on the surfaces.
        """
        pressures = sorted(self.steps)
        pressure_unit = surface.get("pressure_unit", "")
        about = [*remarks]
        names = []
        for name in self.quantities:
            if np.isfinite(self.curve(name)[1]).any():
                names.append(name)
            else:
                about.append(f"{name}: has no value on this body or surface")
        for p in pressures:
            status = {step["status"] for step in self.steps[p]} - {"converged"}
            load = f"{LOAD_AT}{p:g} {pressure_unit}".rstrip()
            about += [f"{load} is {name}" for name in sorted(status)]
        values = {name: self.curve(name)[1] for name in names}
        return InterfaceLaw(
            np.array(pressures),
            values,
            {name: self._errors(name, pressures, surface) for name in names},
            {name: np.array([_scatter(name, self.steps[p]) for p in pressures]) for name in names},
            gap_at_touch,
            {
                "pressure": pressure_unit,
                "gap_at_touch": surface.get("unit", ""),
                **{name: unit_of(name, surface, all_numbers()) for name in names},
            },
            len(self.steps[pressures[0]]),
            tuple(about),
        )

    def _errors(
        self, name: str, pressures: Sequence[float], surface: Mapping[str, Any]
    ) -> np.ndarray:
        """Return the relative error of a quantity at each pressure: the load's own plus the largest
        of the `deviations`, and those by chance, of two intervals on either side, as one alone may
        be small by chance.
        """
        between = [
            self.deviations[interval].get(name, 0.0) + BY_CHANCE * self._by_chance(name, *interval)
            for interval in pairwise(pressures)
        ]
        return np.array(
            [
                _estimated_error(name, self.steps[pressure], surface)
                + min(max(between[max(k - 2, 0) : k + 2]), 1.0)
                for k, pressure in enumerate(pressures)
            ]
        )


def _mean(name: str, steps: Steps) -> float:
    values = [step.get(name) for step in steps]
    return math.nan if None in values else float(np.mean(values))  # type: ignore[arg-type]


def _scatter(name: str, steps: Steps) -> float:
    """Return the standard deviation over the surfaces at a load; 0 for one, nan if one lacks it."""
    values = [step.get(name) for step in steps]
    if None in values:
        return math.nan
    return float(np.std(values, ddof=1)) if len(values) > 1 else 0.0  # type: ignore[arg-type]


def _estimated_error(name: str, steps: Steps, surface: Mapping[str, Any] | None = None) -> float:
    """Return the largest relative error of a quantity over the surfaces at one load, without the
    error by the grid if there is no `surface` (attributes): it is nearly the same at near loads.
    """
    not_closed = [step for step in steps if step.get(name) != 0] or steps
    return max(_relative_error(name, step, surface) for step in not_closed)


def _relative_error(name: str, step: Mapping[str, Any], surface: Mapping[str, Any] | None) -> float:
    """Return the relative error of a number by solver and grid: that of a table, or the solver's
    alone. A stiffness scales with the radii of the spots, half the error of a_r, and next to full
    contact with those of the last openings.
    """
    if surface is None:
        step = {key: value for key, value in step.items() if key not in OF_GRID}
    of_solver = float(max(step["gap_error"], step["pressure_error"]))
    if name in ("stiffness", "conductance"):
        of_area = float(step.get("a_r_discretisation") or 0.0)
        is_open = 1 - float(step["a_r"])
        return of_solver + (OF_STIFFNESS * of_area / is_open if is_open > 0 else 0.0)
    if name.startswith("critical_gap"):
        value = step.get(name)
        of_the_gap = float(step["gap_error"]) + float(step.get("gap_discretisation") or 0.0)
        if not value:  # closed: no error is relative to that
            return 0.0 if surface is None else math.inf
        return float(critical_gap_error(value, step["gap_mean"], of_the_gap, surface))
    bars = error_bars(name, dict(step))
    return of_solver if bars is None else float(max(bars))


def _positive_pressure(value: float | str, where: str) -> float:
    """Return a positive pressure from a number or a text with a unit, which is a Quantity."""
    try:
        number = _plain_number(value)
        if number is None:
            number = parse(str(value), "pressure")
    except (TypeError, ValueError) as error:
        raise SceneError(
            f'{where}: found {value!r}, {error}, allowed: a number, or as "20 MPa"'
        ) from None
    if not 0 < number < math.inf:
        raise SceneError(f"{where}: found {value!r}, allowed: a positive mean pressure")
    return number


def _plain_number(value: float | str) -> float | None:
    """Return a number that has no unit; None for any text that is no plain number."""
    try:
        return float(value)
    except ValueError:
        return None
