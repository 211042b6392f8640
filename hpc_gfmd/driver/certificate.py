"""The independent judgement of a solution: from the returned displacement alone, by a fresh application of the operator.

p = p0 + K u is computed anew in double precision; what it violates of u >= -h, p >= 0, p g = 0, mean(p) = p0 is the certificate. The
duality gap bounds the energy error from above without any knowledge of the solution:

    E(u) - E* <= G = <p^, g> + 1/2 <p^ - p, S (p^ - p)>,    S = 1/K,

for every admissible pressure p^ >= 0 of mean p0; p^ is p where it is in contact, rescaled.
"""

from dataclasses import asdict, dataclass

import numpy as np

from ..kernels.certify import dual_rows, judge
from ..operators.elastic import Elastic

GAP_FACTOR = 2.03  # error of the mean gap over sqrt(G/(p0 gap_mean)): the largest ratio ever seen

TIE = 4.0  # times the rms of rounding errors: a difference of pressures that means nothing


@dataclass(frozen=True)
class Certificate:
    """Relative violations. penetration: largest -g (problem's unit); tension: largest -p on closed points over p0; complementarity:
    mean |p| g/(p0 gap_mean); load_balance: |mean of p in contact - p0|/p0; duality_gap: G/(p0 gap_mean), None if not asked for;
    residual: rms of p out of contact over p0; pressure: the same over the rms of p in contact; gap_bound: bound of the relative error
    of the mean gap, from the duality gap.
    energy: elastic energy per area, and approach: how far the bodies have come together since they touched, without any deformation,
    both in the problem's unit; a half-space that is periodic gives way to a uniform pressure without end: it has no approach (nan),
    nor, periodic along one axis only, an energy (its own part is left out where it is periodic along both);
    contact: points; near: points that may be on the wrong side; gap_mean: problem's unit; pairs: FFT pairs this took."""

    penetration: float
    tension: float
    complementarity: float
    load_balance: float
    duality_gap: float | None
    residual: float
    pressure: float
    gap_bound: float | None
    energy: float
    approach: float
    contact: int
    near: int
    gap_mean: float
    pairs: float

    def attributes(self):
        """The violations, by name."""
        names = ("penetration", "tension", "complementarity", "load_balance")
        return {name: value for name, value in asdict(self).items() if name in names}

    @property
    def finite(self):
        """Whether all numbers are finite."""
        return bool(np.isfinite([self.residual, self.gap_mean]).all())


def certify(problem, g, p, dtype=np.float64, dual=True, near=0.0):
    """Judge the gap g (local slab) at the load problem.p0; writes the fresh pressure to p (local slab). One pair, half more if dual.

    near: size of the pressure below which a closed point, or of the gap times the stiffness of the shortest
    waves below which an open one, may be on the wrong side.
    """
    grid = problem.grid
    elastic = Elastic(grid, problem.body, dtype)
    p0, N = float(problem.p0), grid.N
    passes = elastic.fft.passes()
    # What is as close as rounding errors are is a tie, and on either side right; but single precision may round differently.
    low = TIE * problem.rounding if near > 0 and problem.dtype == np.float64 else 0.0
    kap = 1.0 / problem.body.scale(grid)

    elastic.pressure_rows(problem.displacement_rows(g), passes)
    uKu = elastic.pressure_columns(problem.adder(elastic.fft))
    parts = elastic.use_rows(lambda i0, i1, x: judge(g, p, x, problem.p_cell, low, float(near), kap, grid.inside, i0, i1), passes)
    parts = np.reshape(parts, (-1, 9)) if parts else np.zeros((1, 9))
    *sums, uKu, mean = grid.comm.sum([*parts[:, :7].sum(axis=0), uKu, elastic.mean])
    uniform = elastic.multipliers.uniform
    penetration, tension = grid.comm.max(parts[:, 7:].max(axis=0))
    open_pp, closed_pp, closed_p, pg, contact, gap, close = sums
    gap_mean = gap / N
    work = p0 * gap_mean

    duality_gap = 0.0 if dual else None
    if dual and closed_p > 0 and gap > 0:
        scale = N * p0 / closed_p
        pg_dual = elastic.pressure_rows(lambda i0, i1, x: dual_rows(g, p, x, scale, grid.inside, i0, i1), passes)
        eSe = elastic.compliance_columns()
        pg_dual, eSe = grid.comm.sum([sum(pg_dual), eSe])
        duality_gap = max(pg_dual + 0.5 * eSe, 0.0) / N / work
    elif dual and gap > 0:
        duality_gap = np.inf
    rest = 0.5 * p0 * problem.p_cell / uniform if uniform else 0.0
    with np.errstate(invalid="ignore", over="ignore"):
        return Certificate(
            penetration=float(penetration), tension=float(tension / p0),
            complementarity=float(pg / N / work) if gap > 0 else 0.0,
            load_balance=float(abs(closed_p / N - p0) / p0),
            duality_gap=duality_gap if duality_gap is None else float(duality_gap), residual=float(np.sqrt(open_pp / N) / p0),
            pressure=float(np.sqrt(open_pp / closed_pp)) if closed_pp > 0 else np.inf,
            gap_bound=None if duality_gap is None else float(GAP_FACTOR * np.sqrt(duality_gap)),
            energy=float(0.5 * uKu / N + rest),
            approach=float(problem.p_cell / uniform - mean) if uniform else np.nan,
            contact=int(contact) if np.isfinite(contact) else 0, near=int(close), gap_mean=float(gap_mean), pairs=elastic.pairs)
