"""Partial slip under normal and tangential loads that change, from solutions for normal loads.

With Coulomb friction and elasticities of both directions that do not couple, the traction is a sum
of differences of normal pressures (Ciavarella 1998, Jaeger 1998),

    tau = sum s_j [p(P_j+1) - p(P_j)],    T = sum s_j (P_j+1 - P_j),    |s_j| <= mu.

A change of T turns s of the outermost parts, those of the largest normal loads, to +-mu; the rest
sticks. Contact that is new gets s = dT/dP, at most mu; contact that opens takes its traction along.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..util.errors import SceneError
from ..util.quantities import SI, finite_number, parse

if TYPE_CHECKING:
    from .solution import Solution
    from .solutions import Solutions

ROUNDING = 1e-12  # of tangential loads, over the friction of the normal load
DIGITS = 12  # to which two normal loads have to agree to be one
# Error of a loss over that of the normal load's work in the compressions; measured on 144 cycles of
# walls and rough balls at .003 to .8 of sliding: 1.8 at most.
OF_LOSS = 3.0
Number = float | str


class LoadInterval(NamedTuple):
    """Contact between two normal loads, and the share of its pressure that is traction."""

    low: float
    high: float
    share: float


class SlipState(NamedTuple):
    """Parts from the largest normal load down; contact that needs a load beyond `edge` slips."""

    normal: float
    parts: list[LoadInterval]
    edge: float


def states_of(path: Sequence[tuple[float, float]], friction: float) -> Iterator[SlipState]:
    """Yield the state at each pair of normal and tangential load; the first follows no other."""
    parts: list[LoadInterval] = []
    tangential = 0.0
    normal = 0.0
    for P, T in path:
        if P > normal:
            share = float(np.clip((T - tangential) / (P - normal), -friction, friction))
            parts.insert(0, LoadInterval(normal, P, share))
            tangential += share * (P - normal)
        while parts and parts[0].high > P:
            low, high, share = parts.pop(0)
            tangential -= share * (high - max(low, P))
            if low < P:
                parts.insert(0, LoadInterval(low, P, share))
        missing = T - tangential
        sign = friction * np.sign(missing)
        edge = P
        while parts and abs(missing) > ROUNDING * friction * P:
            low, high, share = parts.pop(0)
            possible = (sign - share) * (high - low)
            turned = min(1.0, missing / possible) if possible else 1.0
            edge = low if turned == 1 else high - turned * (high - low)
            missing -= turned * possible
            if turned < 1:
                parts.insert(0, LoadInterval(low, edge, share))
        if edge < P:
            parts.insert(0, LoadInterval(edge, P, sign))
        normal = P
        tangential = T
        yield SlipState(P, list(parts), edge)


class SlipPath:
    """A path of normal and tangential loads; made by `hpc_gfmd.slip`.

    Attributes
    ----------
    friction : float
        Coefficient of friction.
    normal, tangential : ndarray, shape (steps,)
        The loads, in one unit.
    loads : list of float or str
        Normal loads that have to be solved, in rising order; with their unit if they were given
        with one.
    states : list of SlipState
        The state at each step.
    """

    def __init__(
        self, friction: float, normal: np.ndarray, tangential: np.ndarray, nu: float, unit: str
    ):
        self.friction = friction
        self.normal = normal
        self.tangential = tangential
        self.ratio = (2 - nu) / (2 * (1 - nu))  # of tangential over normal compliance
        self._unit = unit
        start = (float(normal[0]), 0.0)  # its state is not a step
        steps = zip(normal.tolist(), tangential.tolist(), strict=True)
        _, *self.states = states_of([start, *steps], friction)
        ends = {float(end) for state in self.states for part in state.parts for end in part[:2]}
        ends |= {float(state.edge) for state in self.states}
        largest = max(ends)
        distinct: list[float] = []
        for end in sorted(ends):
            if end > largest * 10**-DIGITS and (
                not distinct or end - distinct[-1] > largest * 10**-DIGITS
            ):
                distinct.append(end)
        self._loads = np.array(distinct)
        self.loads = [f"{load!r} {unit}" if unit else load for load in distinct]

    def of(self, solutions: Solutions) -> PartialSlip:
        """Return shift, slip area, traction and loss of the path.

        Parameters
        ----------
        solutions : Solutions
            What `hpc_gfmd.solve` or `hpc_gfmd.run` return for `loads`, in this order, as mean
            pressures or forces. The pressure is needed for `PartialSlip.traction` only, the heights
            only where all of a contact without an approach slips.

        Returns
        -------
        PartialSlip

        Raises
        ------
        SceneError
            For other loads, and for a body that is not an elastic half-space.
        """
        material = solutions.result.scene.material
        for key in ("thickness", "hardness", "adhesion", "relaxation"):
            if getattr(material, key) is not None:
                raise SceneError(f"slip: found material.{key}, allowed: an elastic half-space")
        p = np.array([solution.p for solution in solutions])
        ratios = p / self._loads if len(p) == len(self._loads) else np.zeros(1)
        if not np.allclose(ratios, ratios[0], rtol=1e-9, atol=0) or ratios[0] <= 0:
            raise SceneError(
                "slip: found solutions of other loads, allowed: those of path.loads, in this order"
            )
        return PartialSlip(self, solutions)

    def place(self, load: float) -> int:
        """Return the position of a normal load in `loads`; -1 for no load."""
        if load <= self._loads[-1] * 10**-DIGITS:
            return -1
        return int(np.abs(self._loads - load).argmin())


class PartialSlip:
    """A contact that slips partially, at each step of a path; made by `SlipPath.of`. Collective.

    Attributes
    ----------
    path : SlipPath
        The loads.
    shift : ndarray, shape (steps,)
        Tangential displacement of the bodies, a length.
    shift_error : ndarray, shape (steps,)
        Estimated error of `shift` by the solver, a length: small loads need a small accuracy.
    slip_area : ndarray, shape (steps,)
        Share of the surface that slips in the last step.
    """

    def __init__(self, path: SlipPath, solutions: Solutions):
        self.path = path
        self._solutions = solutions
        self._compressions = [self._compression(solution) for solution in solutions]
        self.shift, self.shift_error = np.array([self._shift(state) for state in path.states]).T
        self.slip_area = np.array([self._slip_area(state) for state in path.states])

    @staticmethod
    def _compression(solution: Solution) -> tuple[float, float]:
        """Return the approach of a solution, or minus its mean gap where that is unbounded, and the
        error by the solver, that of the mean gap.
        """
        approach = solution.value("approach")
        error = float(solution.gap_error * solution.gap_mean)
        return float(-solution.gap_mean if approach is None else approach), error

    def _compression_at(self, load: float) -> tuple[float, float]:
        """Return `_compression` at a normal load, also at the first touch."""
        place = self.path.place(load)
        if place >= 0:
            return self._compressions[place]
        lightest = self._solutions[0]
        has_approach = lightest.value("approach") is not None
        return (0.0 if has_approach else self._mean_height(lightest)), 0.0

    @staticmethod
    def _mean_height(solution: Solution) -> float:
        """Return the mean of the heights of all ranks, measured from the highest."""
        total = solution.comm.sum([float(solution.heights.sum(dtype=float))])[0]
        n_x, n_y = solution.result.surface["n"]
        return float(total) / (n_x * n_y)

    def _shift(self, state: SlipState) -> tuple[float, float]:
        """Return the shift of a state, and its error."""
        shift = error = 0.0
        for low, high, share in state.parts:
            if share:
                (above, of_above), (below, of_below) = map(self._compression_at, (high, low))
                shift += share * (above - below)
                error += abs(share) * (of_above + of_below)
        return self.path.ratio * shift, self.path.ratio * error

    def _slip_area(self, state: SlipState) -> float:
        areas = [
            0.0 if place < 0 else float(self._solutions[place].a_r)
            for place in map(self.path.place, (state.normal, state.edge))
        ]
        return areas[0] - areas[1]

    def traction(self, step: int) -> np.ndarray:
        """Return the tangential traction along the load at a step.

        Parameters
        ----------
        step : int
            Its position in the path.

        Returns
        -------
        ndarray, shape (n_x, n_y)
            In the unit of pressures; with a communicator the rows of this rank.
        """
        traction = np.zeros(self._solutions[0].pressure.shape)
        for low, high, share in self.path.states[step].parts:
            for load, sign in ((high, 1), (low, -1)):
                place = self.path.place(load)
                if place >= 0:
                    traction += sign * share * self._solutions[place].pressure
        return traction

    def loss(self, amplitude: Number) -> float:
        """Return the work that friction takes in a cycle of T between +-amplitude.

        It is that of a constant normal load, the largest of the path, from the elastic energies of
        two solved loads. T has to have reached the amplitude first from 0.

        Parameters
        ----------
        amplitude : float or str
            Of the tangential load, as those of the path.

        Returns
        -------
        float
            Work per nominal area, in the unit of pressures times lengths.

        Raises
        ------
        SceneError
            If the load that it needs is not among those that were solved.
        """
        path = self.path
        inner = self._inner(amplitude)
        P = float(path.normal.max())
        place = path.place(inner)
        heaviest = self._solutions[path.place(P)]
        scale = heaviest.p / P  # mean pressure over the loads of the path
        compressed = self._compression_at(P)[0] - self._compression_at(inner)[0]
        stored = heaviest.value("energy")
        stored -= self._solutions[place].value("energy") if place >= 0 else 0.0
        share = 8 * (heaviest.p * compressed - stored) - 4 * (P - inner) * scale * compressed
        return float(path.friction**2 * path.ratio * share)

    def loss_error(self, amplitude: Number) -> float:
        """Return the relative error of `loss` by the solver, which goes with the accuracy over the
        cube of the amplitude.

        Parameters
        ----------
        amplitude : float or str
            As for `loss`.

        Returns
        -------
        float
        """
        path = self.path
        P = float(path.normal.max())
        loads = P, self._inner(amplitude)
        error = sum(self._compression_at(load)[1] for load in loads)
        work = self._solutions[path.place(P)].p * error
        loss = abs(self.loss(amplitude))
        return OF_LOSS * path.friction**2 * path.ratio * work / loss if loss else np.inf

    def _inner(self, amplitude: Number) -> float:
        """Return the normal load that a cycle between +-amplitude needs beside the largest one."""
        path = self.path
        T, unit = _load("amplitude", amplitude)
        P = float(path.normal.max())
        inner = P - abs(T) / path.friction
        place = path.place(inner)
        solved = 0.0 if place < 0 else float(path._loads[place])
        if unit != path._unit or abs(solved - inner) > 1e-9 * P:
            raise SceneError(
                f"amplitude: found {amplitude}, allowed: one that the path reaches from T = 0 at"
                " its largest normal load"
            )
        return inner


def slip(
    friction: float,
    normal: Number | Sequence[Number],
    tangential: Sequence[Number],
    nu: float = 0.0,
) -> SlipPath:
    """Prepare partial slip of a contact under a path of normal and tangential loads.

    Solve the normal loads that it names, and give the solutions back to it.

    Parameters
    ----------
    friction : float
        Coefficient of friction.
    normal : number, text or list
        Normal load at each step, a mean pressure or a force; one for all steps, or a list. The path
        begins with the first one, reached without a tangential load.
    tangential : list of number or text
        Tangential load at each step, in the same unit; at most the friction of the normal load.
    nu : float, default 0
        Poisson's ratio, which makes the body softer tangentially by (2 - nu)/(2 (1 - nu)).

    Returns
    -------
    SlipPath
        Its `loads` have to be solved, its `of(solutions)` has the results.

    Raises
    ------
    SceneError
        For loads that are not positive, in other units or beyond sliding.

    Examples
    --------
    >>> path = hpc_gfmd.slip(0.5, 0.1, [0.02, 0.04, 0.0, -0.04])
    >>> result = path.of(hpc_gfmd.solve(wall, path.loads))
    >>> result.shift, result.slip_area, result.traction(1)
    """
    if not finite_number(friction) > 0:
        raise SceneError(f"friction: found {friction!s}, allowed: a number greater than 0")
    if not -1 < finite_number(nu) <= 0.5:
        raise SceneError(f"nu: found {nu!s}, allowed: a number above -1 up to 0.5")
    steps = np.atleast_1d(np.asarray(tangential, dtype=object)).tolist()
    normals = np.atleast_1d(np.asarray(normal, dtype=object)).tolist()
    if not steps:
        raise SceneError("tangential: found no loads, allowed: at least one")
    normals = normals * len(steps) if len(normals) == 1 else normals
    if len(normals) != len(steps):
        raise SceneError(
            f"normal: found {len(normals)} loads for {len(steps)} tangential ones, allowed: as many"
        )
    P, units_of_P = zip(*(_load("normal", load) for load in normals))
    T, units_of_T = zip(*(_load("tangential", load) for load in steps))
    units = {
        unit
        for load, unit in zip([*P, *T], [*units_of_P, *units_of_T], strict=True)
        if load != 0 or unit
    }
    if len(units) != 1:
        raise SceneError("tangential: found other units than in normal, allowed: the same")
    for of_normal, of_tangential in zip(P, T):
        if not of_normal > 0:
            raise SceneError(f"normal: found {of_normal:g}, allowed: greater than 0")
        if abs(of_tangential) > friction * of_normal * (1 + ROUNDING):
            raise SceneError(
                f"tangential: found {of_tangential:g}, which slides, allowed: up to"
                f" {friction * of_normal:g}"
            )
    return SlipPath(float(friction), np.array(P), np.array(T), float(nu), units.pop())


def _load(name: str, value: Any) -> tuple[float, str]:
    """Return a load in SI units and its unit; "" for a plain number."""
    number = finite_number(value)
    if isfinite(number):
        return number, ""
    for dimension in ("pressure", "force"):
        try:
            number = float(parse(str(value), dimension))
        except ValueError:
            continue
        if isfinite(number):
            return number, SI[dimension]
    raise SceneError(f"{name}: found {value!r}, allowed: a number, a pressure or a force")
