"""The independent check of a solution, from its displacement alone: equation (7) in docs/method.md.

Violations of the Karush-Kuhn-Tucker conditions p >= 0, p g = 0 and mean(p) = p0 are measured on the
recomputed pressure p = p0 + K u of the nearest feasible displacement, max(u, -h). The duality gap
bounds the distance from the solution: its S norm is estimated without a transform on the levels of
the multilevel operator (EQUIVALENCE), and gives the errors of mean gap, pressure
(error_estimates.py) and area (misclassified.py).

In single precision violations below the rounding errors of the heights cannot be seen; these
rounding errors count towards the errors.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import DTypeLike

from ..kernels.adhesive_rows import add_attraction
from ..kernels.certify import KktSums, dual_rows, kkt_residuals
from ..operators.elastic import Elastic
from ..operators.multilevel import Multilevel
from ..operators.wall import Wall, wall_of
from .error_estimates import StateSums, estimate, relative_error
from .misclassified import misclassified_points, spread_of

if TYPE_CHECKING:
    from ..operators.problem import Problem
    from ..operators.state import State


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """Violations and estimated errors of a state, and sums of its recomputed pressure, in the
    problem's units, the same on all ranks. "The mean pressure" is that of the wall: p0 plus mean
    attraction.
    """

    # largest -g outside of dents, in the gap as the solver left it; it was set to 0 there
    penetration: float = 0.0
    tension: float = 0.0  # largest -p on closed points, over the mean pressure
    complementarity: float = 0.0  # mean of |p| g, over the mean pressure times the mean gap
    load_balance: float = 0.0  # |load of the wall - load of the points in contact|, over the former
    # G over (N times mean pressure times mean gap); None if not computed
    duality_gap: float | None = None
    residual: float = 0.0  # rms of the pressure out of contact, over the mean pressure
    # Estimated relative errors of area, mean gap and pressure field; nan if not estimated. They are
    # the distance from the contact at the same p0 or, where a spring presses the body, at the same
    # end of the spring.
    errors: tuple[float, float, float] = (np.nan, np.nan, np.nan)
    # With a spring the estimated relative error of p0, which changes with the mean gap; None under
    # a dead load, whose p0 is exact.
    p0_error: float | None = None
    # The relative error of mean gap and pressure field that further iterations cannot reduce, of
    # rounding and of the heights, if that is the larger part, else 0.
    attainable: tuple[float, float] = (0.0, 0.0)
    # Elastic energy per area, without that of the uniform pressure for a half-space that is
    # periodic along both axes; nan if it is periodic along one axis.
    energy: float = 0.0
    # How far the bodies have approached since their first contact without deformation; nan for a
    # half-space that is periodic along an axis, which a uniform pressure moves infinitely far.
    approach: float = np.nan
    uKu: float = 0.0  # <u, K u>
    pressures: float = 0.0  # root of the sum of p^2 over points in contact
    contact: int = 0  # number of points in contact, yielded ones included
    yielded: int = 0  # number of points that yield
    gap_mean: float = 0.0  # mean gap over the surface; dents count as 0
    pairs: float = 0.0  # FFT pairs that the certificate took
    precision: str = "float64"  # of its transforms: "float32" or "float64"
    attraction: float = 0.0  # mean attraction, a pressure; 0 without a law
    energy_of_attraction: float = 0.0  # per area
    stability: float = np.nan  # of the equilibrium (stability.py); nan if not computed

    def attributes(self) -> dict[str, Any]:
        """Return the four violations by name, and the precision under "certificate_precision"."""
        names = ("penetration", "tension", "complementarity", "load_balance")
        return {name: getattr(self, name) for name in names} | {
            "certificate_precision": self.precision
        }

    @property
    def finite(self) -> bool:
        """Whether residual, mean gap and <u, K u> are finite."""
        return bool(np.isfinite([self.residual, self.gap_mean, self.uKu]).all())


class Recomputed(NamedTuple):
    """Sums of a state whose pressure was recomputed, over all ranks."""

    sums: KktSums  # of the recomputed pressure and the gap
    tension: float  # largest -p where g = 0, or 0
    mean: float  # of u over the grid
    energy_of_attraction: float = 0.0  # sum of phi over points


def certify(
    problem: Problem,
    state: State,
    levels: Multilevel | None = None,
    dtype: DTypeLike = np.float64,
    dual: bool = False,
) -> Certificate:
    """Make the gap of a state feasible, recompute its pressure, <u, K u> and attraction, and
    measure all violations. Collective. problem: at the state's p0.

    One FFT pair in the precision `dtype`, half of one more with `dual`. `levels`, overwritten, give
    the errors (else nan); the state's stability divides those with attraction. A state that is not
    finite raises nothing: see `Certificate.finite`.
    """
    penetration = wall_of(problem).project(state)
    elastic = Elastic(problem.grid, problem.body, dtype)
    recomputed = _recompute(problem, elastic, state)
    return measured(problem, elastic, state, recomputed, penetration, levels, dual)


def measured(
    problem: Problem,
    elastic: Elastic,
    state: State,
    recomputed: Recomputed,
    penetration: float,
    levels: Multilevel | None,
    dual: bool,
) -> Certificate:
    """Return the certificate of a state with a feasible gap and the pressure of it."""
    N = problem.grid.N
    sums = recomputed.sums
    wall_load = state.wall_load
    work = wall_load * sums.gap
    duality_gap = _duality_gap(wall_of(problem), elastic, state, sums) if dual else None
    uniform = elastic.multipliers.uniform
    energy_of_uniform = 0.5 * float(problem.p0) * problem.p_cell / uniform if uniform else 0.0
    with np.errstate(invalid="ignore", over="ignore"):
        errors = Certificate.errors
        attainable = Certificate.attainable
        if levels is not None:
            errors, attainable = _errors(problem, levels, state, sums)
        return Certificate(
            penetration=penetration,
            tension=float(recomputed.tension / wall_load),
            complementarity=float(sums.pg / work) if sums.gap > 0 else 0.0,
            load_balance=float(abs(sums.open_p) / (N * wall_load)),
            duality_gap=duality_gap,
            residual=float(np.sqrt(sums.open_pp / N) / wall_load),
            errors=errors,
            p0_error=_error_of_load(problem, errors[1] * sums.gap / N),
            attainable=attainable,
            energy=float(0.5 * state.uKu / N + energy_of_uniform),
            uKu=state.uKu,
            pressures=float(np.sqrt(sums.closed_pp)),
            approach=(float(problem.p_cell / uniform - recomputed.mean) if uniform else np.nan),
            contact=int(sums.contact) if np.isfinite(sums.contact) else 0,
            yielded=int(sums.yielded),
            gap_mean=float(sums.gap / N),
            pairs=elastic.pairs,
            precision=elastic.dtype.name,
            attraction=float(state.attracted / N),
            energy_of_attraction=float(recomputed.energy_of_attraction / N),
            stability=state.stability.value if state.stability is not None else np.nan,
        )


def _error_of_load(problem: Problem, error_of_gap: float) -> float | None:
    """Return the relative error of p0 that a spring makes of that of the gap; None without."""
    if problem.spring == 0:
        return None
    grid = problem.grid
    error = problem.spring * (grid.cell_points / grid.N) * error_of_gap
    return float(error / abs(problem.p0)) if problem.p0 else np.inf


def _recompute(problem: Problem, elastic: Elastic, state: State) -> Recomputed:
    """Set all of a state that follows from its gap. Collective, one FFT pair."""
    grid = problem.grid
    g = state.g
    p = state.p
    level = problem.transform_displacement(elastic.fft, g)
    uKu = elastic.columns(add=problem.adder(elastic.fft))
    law = problem.law(elastic.fft.dtype)
    attracted = [(0.0, 0.0)]

    def look(i0: int, i1: int, x: np.ndarray) -> tuple[KktSums, float]:
        if law is not None:
            attracted.append(add_attraction(law, g, x, i0, i1, grid.inside))
        worst = np.zeros(g.shape[1])
        return kkt_residuals(g, p, x, problem.p_cell, problem.limit, grid.inside, i0, i1, worst)

    parts = elastic.use_rows(look)
    sums_of_parts = [sums for sums, _ in parts] or [KktSums(*[0.0] * len(KktSums._fields))]
    *totals, uKu, mean = grid.comm.sum([*np.sum(sums_of_parts, axis=0), uKu, elastic.mean])
    (tension,) = grid.comm.max([max((tension for _, tension in parts), default=0.0)])
    state.uKu = float(uKu)
    energy_of_attraction = 0.0
    if law is not None:
        state.attracted, energy_of_attraction = grid.comm.sum(np.sum(attracted, axis=0)).tolist()
    return Recomputed(KktSums(*totals), float(tension), mean + level, energy_of_attraction)


def _duality_gap(wall: Wall, elastic: Elastic, state: State, sums: KktSums) -> float:
    """Return G over (wall_load times sum of gaps): inf without an admissible pressure (H in dents),
    or if only the gaps are 0. Collective, half an FFT pair.
    """
    grid = wall.grid
    load = grid.N * state.wall_load
    scale, shift = wall.admissible(load, load - sums.open_p, sums.contact, sums.yielded)
    if scale < 0:
        return np.inf
    fields = state.g, state.p
    elastic.pressure_rows(
        lambda i0, i1, x: dual_rows(*fields, x, scale, shift, wall.limit, grid.inside, i0, i1)
    )
    G = 0.5 * float(grid.comm.sum([elastic.columns(inverse=True, backward=False)])[0])
    if sums.gap > 0:
        return float(G / (state.wall_load * sums.gap))
    return np.inf if G > 0 else 0.0


def _errors(
    problem: Problem, levels: Multilevel, state: State, sums: KktSums
) -> tuple[tuple[float, float, float], tuple[float, float]]:
    """Return `errors` and `attainable` of a Certificate; overwrites the levels. Collective."""
    grid, contact = problem.grid, sums.contact
    levels.restrict(state.g, state.p, problem.limit)
    totals = StateSums(
        p0=state.wall_load,
        open_p=sums.open_p,
        open_pp=sums.open_pp,
        closed_pp=sums.closed_pp,
        contact=contact,
        yielded=sums.yielded,
        gap=sums.gap,
        uKu=state.uKu,
        level_sums=grid.comm.sum(levels.sweep()[3:]).tolist(),
    )
    lowest_stability = 1.0 if state.stability is None else state.stability.lowest
    errors = estimate(problem, levels, state.g, totals, lowest_stability)
    if not np.isfinite(errors.squares):
        return (np.inf, np.inf, np.inf), (0.0, 0.0)
    spread = spread_of(sums.open_pp, sums.open_p4, contact, grid.N)
    wrong = misclassified_points(problem, state.g, state.p, errors, spread, contact)
    # the one point that may be open is a gap that is not known
    gap = errors.gap if wrong == 0 or contact < grid.N else np.inf
    return (relative_error(wrong, contact), gap, errors.pressure), errors.attainable
