"""The independent check of a solution, from its displacement alone.

The pressure p = p0 + K u is computed anew, in double precision where rounding errors would count.
What it violates of u >= -h, p >= 0, p g = 0 and mean(p) = p0 (the Karush-Kuhn-Tucker conditions) is
the certificate. How far that is from the solution follows from the duality gap, which bounds the
error of the energy without any knowledge of the solution:

    E(u) - E* <= G = <p^, g> + 1/2 <p^ - p, S (p^ - p)>,    S = 1/K,

for every admissible pressure p^ >= 0 of mean p0; p^ is p where it is in contact, rescaled. With a
hardness H p^ is at most that, H where there is a dent, and G has <H - p^, g^-> besides <p^, g^+>.
The norm S of p^ - p is bounded without a transform by sums of squares on the levels of the
multilevel operator (EQUIVALENCE). From G follow bounds of the errors of the mean gap and of the
pressure (error_estimates.py), and from that of the pressure how many points may be in the wrong
set, in contact or out of it (misclassified.py).

In single precision what is smaller than the rounding errors of the heights, which count towards the
errors, cannot be seen.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import DTypeLike

from ..kernels.adhesive_rows import add_attraction
from ..kernels.certify import KktExtremes, KktSums, dual_rows, kkt_residuals
from ..operators.elastic import Elastic
from ..operators.multilevel import Multilevel
from .error_estimates import State, estimate, relative_error
from .misclassified import misclassified_points, spread_of

if TYPE_CHECKING:
    from ..operators.problem import Problem
    from .stability import Stability


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """What a state violates, how far it is from the solution, and what its fresh pressure adds up
    to. Lengths and pressures are in the problem's units.

    Attributes
    ----------
    penetration : float
        Largest -g that is no dent.
    tension : float
        Largest -p on closed points, over the mean pressure of the wall.
    complementarity : float
        Mean of |p| g, over the mean pressure times the mean gap.
    load_balance : float
        Difference between the mean pressure in contact and that asked for, relative.
    duality_gap : float or None
        G over N times the mean pressure times the mean gap; None if it was not asked for.
    residual : float
        rms of the pressure out of contact, over the mean pressure.
    errors : tuple of float
        Estimated relative errors of area, mean gap and pressure field; nan if not asked for.
    attainable : tuple of float
        The part of the errors of mean gap and pressure field that no iteration makes smaller.
    energy : float
        Elastic energy per area. That of a uniform pressure is left out where a half-space is
        periodic along both axes; nan where it is so along one of them.
    approach : float
        How far the bodies have come together since they touched, without any deformation. nan
        where a half-space is periodic: it gives way to a uniform pressure without end.
    uKu : float
        <u, K u>.
    pressures : float
        L2 norm of the pressure in contact, over points.
    contact : int
        Points in contact.
    yielded : int
        Those of them that yield.
    gap_mean : float
        Mean gap; dents count as 0.
    pairs : float
        FFT pairs that this took.
    precision : str
        In which it was computed: "float32" or "float64".
    attraction : float
        Mean attraction, 0 without a law.
    energy_of_attraction : float
        Its energy per area.
    stability : float
        Of the equilibrium (stability.py); nan without an attraction.
    """

    penetration: float = 0.0
    tension: float = 0.0
    complementarity: float = 0.0
    load_balance: float = 0.0
    duality_gap: float | None = None
    residual: float = 0.0
    errors: tuple[float, float, float] = (np.nan, np.nan, np.nan)
    attainable: tuple[float, float] = (0.0, 0.0)
    energy: float = 0.0
    approach: float = np.nan
    uKu: float = 0.0
    pressures: float = 0.0
    contact: int = 0
    yielded: int = 0
    gap_mean: float = 0.0
    pairs: float = 0.0
    precision: str = "float64"
    attraction: float = 0.0
    energy_of_attraction: float = 0.0
    stability: float = np.nan

    def attributes(self) -> dict[str, Any]:
        """Return the violations by name, and the precision in which they were computed."""
        names = ("penetration", "tension", "complementarity", "load_balance")
        return {name: getattr(self, name) for name in names} | {
            "certificate_precision": self.precision
        }

    @property
    def finite(self) -> bool:
        """Whether all numbers are finite."""
        return bool(np.isfinite([self.residual, self.gap_mean, self.uKu]).all())


class _Recomputed(NamedTuple):
    """What follows from the displacement of a state, on all ranks.

    Attributes
    ----------
    sums : KktSums
        Of the fresh pressure and the gap.
    extremes : KktExtremes
        Of both.
    uKu : float
        <u, K u>.
    mean : float
        Mean of u - level on the surface.
    level : float
        What was taken off u before the transform.
    attraction, energy_of_attraction : float
        Sums over points.
    """

    sums: KktSums
    extremes: KktExtremes
    uKu: float
    mean: float
    level: float
    attraction: float
    energy_of_attraction: float


def certify(
    problem: Problem,
    g: np.ndarray,
    p: np.ndarray,
    levels: Multilevel | None = None,
    dtype: DTypeLike = np.float64,
    dual: bool = False,
    stability: Stability | None = None,
) -> Certificate:
    """Certify a gap at the load of a problem: one FFT pair, half of one more if dual. Collective.

    Parameters
    ----------
    problem : Problem
        With the load.
    g : array, local slab
        Gap.
    p : array, local slab
        Is overwritten with the fresh pressure.
    levels : Multilevel, optional
        Of the grid, whose fields are overwritten. Without it there are no errors.
    dtype : dtype
        Precision of the transforms.
    dual : bool
        Whether to compute the duality gap.
    stability : Stability, optional
        Of the state, where there is an attraction. Errors are those of the contact with this
        attraction frozen, over what is to be reckoned with.

    Returns
    -------
    Certificate
    """
    grid, N = problem.grid, problem.grid.N
    elastic = Elastic(grid, problem.body, dtype)
    state = _recompute(problem, elastic, g, p)
    sums = state.sums
    wall_load = float(problem.p0) + state.attraction / N
    work = wall_load * sums.gap
    duality_gap = _duality_gap(problem, elastic, g, p, sums, wall_load) if dual else None
    uniform = elastic.multipliers.uniform
    energy_of_uniform = 0.5 * float(problem.p0) * problem.p_cell / uniform if uniform else 0.0
    with np.errstate(invalid="ignore", over="ignore"):
        errors = Certificate.errors
        attainable = Certificate.attainable
        if levels is not None:
            errors, attainable = _errors(
                problem, levels, g, p, sums, state.uKu, wall_load, stability
            )
        return Certificate(
            penetration=float(state.extremes.penetration),
            tension=float(state.extremes.tension / wall_load),
            complementarity=float(sums.pg / work) if sums.gap > 0 else 0.0,
            load_balance=float(abs(sums.open_p) / (N * wall_load)),
            duality_gap=duality_gap,
            residual=float(np.sqrt(sums.open_pp / N) / wall_load),
            errors=errors,
            attainable=attainable,
            energy=float(0.5 * state.uKu / N + energy_of_uniform),
            uKu=float(state.uKu),
            pressures=float(np.sqrt(sums.closed_pp)),
            approach=(
                float(problem.p_cell / uniform - state.mean - state.level) if uniform else np.nan
            ),
            contact=int(sums.contact) if np.isfinite(sums.contact) else 0,
            yielded=int(sums.yielded),
            gap_mean=float(sums.gap / N),
            pairs=elastic.pairs,
            precision=np.dtype(dtype).name,
            attraction=float(state.attraction / N),
            energy_of_attraction=float(state.energy_of_attraction / N),
            stability=stability.value if stability is not None else np.nan,
        )


def _recompute(problem: Problem, elastic: Elastic, g: np.ndarray, p: np.ndarray) -> _Recomputed:
    """Write the pressure of a gap to p, and return what both add up to."""
    grid = problem.grid
    level = problem.level(g)
    elastic.pressure_rows(problem.displacement_rows(g, level))
    uKu = elastic.pressure_columns(problem.adder(elastic.fft))
    law = problem.law(elastic.fft.dtype)
    attracted = [(0.0, 0.0)]

    def look(i0: int, i1: int, x: np.ndarray) -> tuple[KktSums, KktExtremes]:
        if law is not None:
            attracted.append(add_attraction(law, g, x, i0, i1, grid.inside))
        worst = np.zeros((2, g.shape[1]))
        return kkt_residuals(g, p, x, problem.p_cell, problem.limit, grid.inside, i0, i1, worst)

    parts = elastic.use_rows(look)
    sums_of_parts = [sums for sums, _ in parts] or [KktSums(*[0.0] * len(KktSums._fields))]
    extremes_of_parts = [extremes for _, extremes in parts] or [KktExtremes(0.0, 0.0)]
    *totals, uKu, mean = grid.comm.sum([*np.sum(sums_of_parts, axis=0), uKu, elastic.mean])
    extremes = KktExtremes(*grid.comm.max(np.max(extremes_of_parts, axis=0)))
    attraction = energy_of_attraction = 0.0
    if law is not None:
        attraction, energy_of_attraction = grid.comm.sum(np.sum(attracted, axis=0)).tolist()
    return _Recomputed(
        sums=KktSums(*totals),
        extremes=extremes,
        uKu=uKu,
        mean=mean,
        level=level,
        attraction=attraction,
        energy_of_attraction=energy_of_attraction,
    )


def _duality_gap(
    problem: Problem,
    elastic: Elastic,
    g: np.ndarray,
    p: np.ndarray,
    sums: KktSums,
    wall_load: float,
) -> float:
    """Return G over the load times the sum of gaps; infinite where the contact has no admissible
    pressure."""
    grid = problem.grid
    load = grid.N * wall_load
    scale, shift = _admissible(problem, load, load - sums.open_p, sums)
    if scale < 0:
        return np.inf
    products = elastic.pressure_rows(
        lambda i0, i1, x: dual_rows(g, p, x, scale, shift, problem.limit, grid.inside, i0, i1)
    )
    p_hat_g, norm = grid.comm.sum([sum(products), elastic.compliance_columns()])
    G = max(p_hat_g + 0.5 * norm, 0.0)
    if sums.gap > 0:
        return float(G / (wall_load * sums.gap))
    return np.inf if G > 0 else 0.0


def _admissible(
    problem: Problem, load: float, closed_p: float, sums: KktSums
) -> tuple[float, float]:
    """Return the scale of p in elastic contact, and what is added to it, that give a pressure of
    the right mean between 0 and the hardness: a scale below 0 where there is none."""
    missing = load - closed_p
    if problem.hardness is None:
        return (load / closed_p if closed_p > 0 else -1.0), 0.0
    elastic = closed_p - problem.hardness * sums.yielded
    if missing <= 0:
        return (1 + missing / elastic if elastic > 0 else -1.0), 0.0
    room = problem.hardness * (sums.contact - sums.yielded) - elastic
    share = missing / room if room > 0 else np.inf
    return 1 - share, share * problem.hardness


def _errors(
    problem: Problem,
    levels: Multilevel,
    g: np.ndarray,
    p: np.ndarray,
    sums: KktSums,
    uKu: float,
    wall_load: float,
    stability: Stability | None,
) -> tuple[tuple[float, float, float], tuple[float, float]]:
    """Return the relative errors of area, mean gap and pressure field, and what no iteration makes
    smaller of the last two.

    sums, uKu: of all ranks; wall_load: mean pressure that the wall bears.
    """
    grid, contact = problem.grid, sums.contact
    levels.restrict(g, p, problem.limit)
    state = State(
        p0=wall_load,
        open_p=sums.open_p,
        open_pp=sums.open_pp,
        closed_pp=sums.closed_pp,
        contact=contact,
        yielded=sums.yielded,
        gap=sums.gap,
        uKu=uKu,
        level_sums=grid.comm.sum(levels.sweep()[3:]).tolist(),
    )
    lowest_stability = 1.0 if stability is None else stability.lowest
    errors = estimate(problem, levels, g, state, lowest_stability)
    if not np.isfinite(errors.squares):
        return (np.inf, np.inf, np.inf), (0.0, 0.0)
    spread = spread_of(sums.open_pp, sums.open_p4, contact, grid.N)
    wrong = misclassified_points(problem, g, p, errors, spread, contact)
    # the one point that may be open is a gap that is not known
    gap = errors.gap if wrong == 0 or contact < grid.N else np.inf
    return (relative_error(wrong, contact), gap, errors.pressure), errors.attainable
