"""The independent check (of the KKT conditions) of a solution: from the displacement alone, by a
fresh application of the operator.

p = p0 + K u is computed anew, in double precision where rounding errors would count; what it
violates of u >= -h, p >= 0, p g = 0, mean(p) = p0 is the certificate. How far that is from the
solution follows from the duality gap, which bounds the error of the energy without any knowledge of
the solution:

    E(u) - E* <= G = <p^, g> + 1/2 <p^ - p, S (p^ - p)>,    S = 1/K,

for every admissible pressure p^ >= 0 of mean p0; p^ is p where it is in contact, rescaled. With a
hardness H p^ is at most that, H where there is a dent, and G has <H - p^, g^-> besides <p^, g^+>.
The norm S of p^ - p is bounded without a transform by sums of squares on the levels of the
multilevel operator (EQUIVALENCE); from G follow bounds of the errors of the mean gap and of the
pressure (certificate/error_estimates.py), and from that of the pressure how many points may be in
the wrong set, in contact or out of it.

In single precision what is smaller than the rounding errors of the heights, which count towards the
errors, cannot be seen.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import DTypeLike

from ..kernels.adhesive_rows import add_attraction
from ..kernels.certify import KktExtremes, KktSums, dual_rows, kkt_residuals
from ..operators.elastic import Elastic
from ..operators.multilevel import Multilevel
from .error_estimates import State, estimate, misclassified_points, relative_error, spread_of

if TYPE_CHECKING:
    from ..operators.problem import Problem
    from .stability import Stability


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """Relative violations. penetration: largest -g (problem's unit); tension: largest -p on closed
    points over p0; complementarity: mean |p| g/(p0 gap_mean); load_balance: |mean of p in contact -
    p0|/p0; duality_gap: G/(p0 gap_mean), None if not asked for; residual: rms of p out of contact
    over p0. errors: relative, estimated, of (area, mean gap, pressure field), nan if not asked for;
    attainable: of the mean gap and the pressure field, what no iteration makes smaller.
    attraction: mean attraction, and energy_of_attraction: its energy per area, in the problem's
    unit; stability: see stability.py, nan without an attraction.
    energy: elastic energy per area, and approach: how far the bodies have come together since they
    touched, without any deformation, both in the problem's unit; a half-space that is periodic
    gives way to a uniform pressure without end: it has no approach (nan), nor, periodic along one
    axis only, an energy (its own part is left out where it is periodic along both); uKu: <u, K u>;
    pressures: L2 norm of the pressure in contact, over points; contact: points; yielded: of
    these; gap_mean: problem's unit; pairs: FFT pairs this took; precision: in which it was
    computed."""

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
        """Return the violations, by name, and the precision in which they were found."""
        names = ("penetration", "tension", "complementarity", "load_balance")
        return {name: getattr(self, name) for name in names} | {
            "certificate_precision": self.precision
        }

    @property
    def finite(self) -> bool:
        """Whether all numbers are finite."""
        return bool(np.isfinite([self.residual, self.gap_mean, self.uKu]).all())


def certify(
    problem: Problem,
    g: np.ndarray,
    p: np.ndarray,
    levels: Multilevel | None = None,
    dtype: DTypeLike = np.float64,
    dual: bool = False,
    stability: Stability | None = None,
) -> Certificate:
    """Certify the gap g (local slab) at the load problem.p0; writes the fresh pressure to p (local
    slab). One pair, half more if dual.

    levels: the Multilevel of the grid, whose fields are overwritten: without it there are no
    errors; stability: of the state, where there is an attraction: errors are those of the contact
    with this attraction frozen, over what is to be reckoned with. Collective.
    """
    grid = problem.grid
    elastic = Elastic(grid, problem.body, dtype)
    p0, N = float(problem.p0), grid.N

    level = problem.level(g)
    elastic.pressure_rows(problem.displacement_rows(g, level))
    uKu = elastic.pressure_columns(problem.adder(elastic.fft))
    limit = problem.limit
    law = problem.law(np.dtype(dtype))
    attracted: list[tuple[float, float]] = []

    def look(i0: int, i1: int, x: np.ndarray) -> tuple[KktSums, KktExtremes]:
        if law is not None:
            attracted.append(add_attraction(law, g, x, i0, i1, grid.inside))
        return kkt_residuals(g, p, x, problem.p_cell, limit, grid.inside, i0, i1)

    parts = elastic.use_rows(look)
    found, largest = zip(*parts) if parts else ([KktSums(*[0.0] * 8)], [KktExtremes(0.0, 0.0)])
    *totals, uKu, mean = grid.comm.sum([*np.sum(found, axis=0), uKu, elastic.mean])
    sums, extremes = KktSums(*totals), KktExtremes(*grid.comm.max(np.max(largest, axis=0)))
    t = phi = 0.0
    if law is not None:
        t, phi = grid.comm.sum(np.sum([(0.0, 0.0), *attracted], axis=0)).tolist()
    wall_load = p0 + t / N
    closed_p, contact, gap = N * wall_load - sums.open_p, sums.contact, sums.gap
    work = wall_load * gap

    duality_gap = None
    if dual:
        duality_gap = np.inf
        scale, shift = _admissible(problem, N * wall_load, closed_p, sums)
        if scale >= 0:
            pg_dual = elastic.pressure_rows(
                lambda i0, i1, x: dual_rows(g, p, x, scale, shift, limit, grid.inside, i0, i1)
            )
            pg_dual, eSe = grid.comm.sum([sum(pg_dual), elastic.compliance_columns()])
            G = max(pg_dual + 0.5 * eSe, 0.0)
            duality_gap = float(G / work) if gap > 0 else (np.inf if G > 0 else 0.0)
    uniform = elastic.multipliers.uniform
    rest = 0.5 * p0 * problem.p_cell / uniform if uniform else 0.0
    with np.errstate(invalid="ignore", over="ignore"):
        errors, attainable = (
            (Certificate.errors, Certificate.attainable)
            if levels is None
            else _errors(problem, levels, g, p, sums, uKu, wall_load, stability)
        )
        return Certificate(
            penetration=float(extremes.penetration),
            tension=float(extremes.tension / wall_load),
            complementarity=float(sums.pg / work) if gap > 0 else 0.0,
            load_balance=float(abs(sums.open_p) / (N * wall_load)),
            duality_gap=duality_gap,
            residual=float(np.sqrt(sums.open_pp / N) / wall_load),
            errors=errors,
            attainable=attainable,
            energy=float(0.5 * uKu / N + rest),
            uKu=float(uKu),
            pressures=float(np.sqrt(sums.closed_pp)),
            approach=float(problem.p_cell / uniform - mean - level) if uniform else np.nan,
            contact=int(contact) if np.isfinite(contact) else 0,
            yielded=int(sums.yielded),
            gap_mean=float(gap / N),
            pairs=elastic.pairs,
            precision=np.dtype(dtype).name,
            attraction=float(t / N),
            energy_of_attraction=float(phi / N),
            stability=stability.value if stability is not None else np.nan,
        )


def _admissible(
    problem: Problem, load: float, closed_p: float, sums: KktSums
) -> tuple[float, float]:
    """Return the scale of p in elastic contact, and what is added to it, that give a pressure of
    the right mean between 0 and the hardness: a scale below 0 where there is none."""
    if problem.hardness is None:
        return (load / closed_p if closed_p > 0 else -1.0), 0.0
    elastic = closed_p - problem.hardness * sums.yielded
    room = problem.hardness * (sums.contact - sums.yielded) - elastic
    if closed_p >= load:
        return (1 + (load - closed_p) / elastic if elastic > 0 else -1.0), 0.0
    share = (load - closed_p) / room if room > 0 else np.inf
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
    smaller of the last two; sums: KktSums of all ranks; wall_load: mean pressure that the wall
    bears."""
    grid, contact = problem.grid, sums.contact
    levels.restrict(g, p, problem.limit)
    level_sums = grid.comm.sum(levels.sweep()[3:]).tolist()
    found = estimate(
        problem,
        levels,
        g,
        State(
            wall_load,
            sums.open_p,
            sums.open_pp,
            sums.closed_pp,
            contact,
            sums.yielded,
            sums.gap,
            uKu,
            level_sums,
        ),
        1.0 if stability is None else stability.lowest,
    )
    if not np.isfinite(found.squares):
        return (np.inf, np.inf, np.inf), (0.0, 0.0)
    spread = spread_of(sums.open_pp, sums.open_p4, contact, grid.N)
    wrong = misclassified_points(problem, g, p, found, spread, contact)
    # the one point that may be open is a gap that is not known
    gap = found.gap if wrong == 0 or contact < grid.N else np.inf
    return (relative_error(wrong, contact), gap, found.pressure), found.attainable
