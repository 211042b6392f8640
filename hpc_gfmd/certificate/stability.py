"""How stable an equilibrium with attraction is, and along which displacement it is least stable:
equation (4) in docs/method.md.

At fixed contact A the stability is

    s = min <e, (K + phi'') e>/<e, K e>    over e = 0 on A,

1 without attraction, 0 where the surfaces are about to jump, below 0 at a saddle. It is 1 - mu, mu
being the largest eigenvalue of D = -phi'' on open points with respect to K, found by locally
optimal conjugate gradients (Knyazev 2001) in the space of e, the preconditioned residual and the
last change of e. The first e is M D 1, which does not change sign, like the mode that is sought; M
is the preconditioner of operators/multilevel.py.

This s is never too small. How much too large it may be follows from the residual R = D e - mu K e:
there is an eigenvalue within |R|_S/|e|_K of mu; before convergence twice this uncertainty counts.
If single points are soft there may be modes of few points, of which the first e hardly has a part:
then the search makes some steps more. That of the softest point alone, s <= 1 - D/K of a point, is
tried if the search ends above it. Under a dead load the least stable mode moves the body as a
whole. A spring holds that mode, and one that breaks the symmetry of the wall may be less stable: in
a search that is not to end early the first e is then made of scattered numbers, or all steps would
keep the symmetry.

To first order there is an equilibrium at the distance m/s, m = |u - T(u)|_K. But just beyond a jump
there are states with a small m and s > 0 without an equilibrium. So s of the secant counts: 1 +
<t(g + x e) - t(g), e>/x, the smaller of both directions, |e|_K = 1, where x is the smallest x with
x s >= m. If there is no such x, there may be no equilibrium.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..kernels.adhesive_rows import pull_along, softening
from ..kernels.subspace import combine_directions, subspace_products
from ..operators.elastic import Elastic, reader
from ..operators.multilevel import Multilevel
from ..operators.state import Stability

if TYPE_CHECKING:
    from ..operators.problem import Problem
    from ..parallel.grid import Grid

STEPS = 60  # largest number of steps of a search
SOFT, FEWEST = 0.5, 4  # softening over stiffness of a point, above which at least 4 steps are made
TOLERANCE = 0.02  # relative change of s in a step below which the search has converged
DOUBTED = 0.25  # `lowest` is at least this share of a positive s, however uncertain s is
LEAST = 0.02  # smaller values of s are computed with the absolute accuracy of this one
# Smallest number of steps of an accurate search if a spring holds the body. Measured: up to 16 it
# took the second mode of a groove for the first, at 24 it did not, for an eighth more pairs.
FEWEST_HELD = 24
SCATTER = 0.9  # of the first direction then, so that it has a part outside of any symmetry
INDEPENDENT = 1e-10  # smallest eigenvalue of the Gram matrix that is kept, over the largest
FARTHER = 20  # largest number of distances that `stability_up_to_equilibrium` tries
NEAR_ENOUGH = 0.95  # ratio of two successive stabilities from which on they count as equal


def stability_of(
    problem: Problem,
    g: np.ndarray,
    p: np.ndarray,
    levels: Multilevel,
    enough: float = np.inf,
    too_little: float = -LEAST,
    mode: np.ndarray | None = None,
    tolerance: float = TOLERANCE,
) -> Stability:
    """Compute the stability of a state (gap g, pressure p of the wall) by an iterative search.
    Collective.

    Ends once `lowest` is above `enough`, `value` below `too_little`, or s changes by less than
    `tolerance`; `mode`: of an earlier search. Overwrites the levels. One or two FFT pairs and one a
    step; none if no open point is attracted.
    """
    search = _Search(problem, g, p, levels)
    if not search.attracts:
        return Stability(1.0, 1.0, None, 0.0)
    return search.run(enough, too_little, mode, tolerance)


def stability_up_to_equilibrium(
    problem: Problem, g: np.ndarray, stability: Stability, distance: float
) -> float:
    """Return the stability of the secant up to the equilibrium at |u - T(u)|_K = `distance`, at
    most `stability.lowest`; 0 if there may be none. Collective, no FFT.
    """
    mode = stability.mode
    law = problem.law(np.dtype(np.float64))
    if mode is None or stability.lowest <= 0 or distance == 0:
        return stability.lowest
    grid = problem.grid

    def pull(length: float) -> float:
        def pull_of_rows(i0: int, i1: int) -> float:
            return float(pull_along(law, g, mode, length, i0, i1, grid.inside))

        (total,) = grid.comm.sum([sum(grid.by_rows(pull_of_rows))])
        return float(total)

    doubt = stability.value - stability.lowest
    s = stability.lowest
    for _ in range(FARTHER):
        way = distance / s
        secant = 1 + min(pull(way), -pull(-way)) / way - doubt
        if secant >= NEAR_ENOUGH * s:
            return min(secant, s)
        if not secant > 0:
            break
        s = secant
    return 0.0


def scattered(grid: Grid, dtype: np.dtype) -> np.ndarray:
    """Return numbers from 1 - SCATTER to 1 + SCATTER, the same at a point on any ranks."""
    start, stop = grid.rows
    i = np.arange(start, stop, dtype=np.uint64)[:, None]
    j = np.arange(1, grid.n[1] + 1, dtype=np.uint64)
    # the upper bits of products of odd numbers are as good as random
    bits = i * np.uint64(0x9E3779B97F4A7C15) + j * np.uint64(0xC2B2AE3D27D4EB4F)
    bits = (bits ^ (bits >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9) >> np.uint64(40)
    return (1 + SCATTER * (bits.astype(dtype) * dtype.type(2.0**-23) - 1)).astype(dtype)


class _Search:
    """The search of `stability_of`; `run` overwrites the fields of `levels`. Collective."""

    def __init__(self, problem: Problem, g: np.ndarray, p: np.ndarray, levels: Multilevel):
        self.problem, self.levels = problem, levels
        self.grid, self.dtype = problem.grid, problem.dtype
        self.elastic = Elastic(self.grid, problem.body, self.dtype)
        rows, n_y = self.grid.shape
        # with the halo rows that the transfer expects
        # memory of `residual` and `closed`, with halo rows for the levels
        self.residual_and_contact = np.zeros((2, rows + 2, n_y), self.dtype)
        self.residual, self.closed = self.residual_and_contact[:, 1:-1]
        self.z = np.zeros((rows + 2, n_y), self.dtype)  # M residual on open points, 0 in contact
        # -phi''(g) >= 0 on open points; 0 in contact and beyond the surface
        self.D = self.grid.empty(self.dtype)
        inside, law = self.grid.inside, problem.law()

        def soften(i0: int, i1: int) -> tuple[float, float]:
            here = slice(i0, max(min(i1, inside[0]), i0)), slice(0, inside[1])
            self.closed[here] = (g[here] <= 0) & (p[here] > 0)
            return softening(law, g, self.closed, self.D, i0, i1, inside)

        parts = [(0.0, 0.0), *self.grid.by_rows(soften)]
        # whether any open point on any rank is attracted
        self.attracts = bool(self.grid.comm.sum([sum(total for total, _ in parts)])[0] > 0)
        (largest,) = self.grid.comm.max([max(float(x) for _, x in parts)])
        # the largest D of a point over the stiffness K of a point alone
        self.softness = largest / float(problem.body.near(self.grid)[0])

    def run(
        self, enough: float, too_little: float, mode: np.ndarray | None, tolerance: float
    ) -> Stability:
        """Step until s is known. Collective. V: e, the preconditioned residual (first: the given
        mode), the last change of e; KV: K V on open points.
        """
        shape = (3, *self.grid.shape)
        V, KV = np.zeros(shape, self.dtype), np.zeros(shape, self.dtype)
        self.residual[...] = self.D
        is_held = self.problem.spring > 0 and np.isinf(enough)
        if is_held:
            self.residual *= scattered(self.grid, self.dtype)
        self._precondition()
        V[0] = self.z[1:-1]
        self._normalise(V[0])
        self._apply(V[0], KV[0])
        directions = 1
        if mode is not None and not is_held:
            V[1] = mode
            V[1] *= 1 - self.closed
            self._normalise(V[1])
            self._apply(V[1], KV[1])
            directions = 2
        fewest = FEWEST if self.softness > SOFT else 1
        fewest_held = FEWEST_HELD if is_held else 1
        rounding = float(np.finfo(self.dtype).eps)
        of_a_point = 1 - self.softness + LEAST
        s, lowest = np.nan, -np.inf
        for step in range(1, STEPS + 1):
            before = s
            mu, weights = self._best(V, KV, directions)
            s = 1 - mu
            self._combine(V, KV, directions, weights)
            self._set_residual(V[0], KV[0], mu)
            missing = self._precondition()  # <R, M R>; <e, K e> is 1
            doubt = np.sqrt(max(missing, 0.0))
            lowest = s - 2 * doubt
            ends = s < too_little or not doubt > rounding
            if not ends and step >= fewest_held:
                ends = lowest > enough and step >= fewest
                if not ends and abs(s - before) < tolerance * max(abs(s), LEAST):
                    lowest = max(s - doubt, s / 2)
                    ends = True
            if ends and s <= of_a_point:
                break
            V[1] = self._softest() if ends else self.z[1:-1]
            of_a_point = np.inf if ends else of_a_point  # it is tried once
            self._normalise(V[1])
            self._apply(V[1], KV[1])
            directions = min(directions + 1, 3)
        if s > 0:  # safeguard: keep at least a quarter of s
            lowest = max(lowest, DOUBTED * s)
        upward = self.grid.comm.sum([V[0].sum(dtype=float)])[0] >= 0
        return Stability(s, min(lowest, s), V[0] if upward else -V[0], self.elastic.pairs)

    def _softest(self) -> np.ndarray:
        """Return 1 at one point of the largest D on any rank, else 0. Collective."""
        comm = self.grid.comm
        here = float(self.D.max(initial=0.0))
        (largest,) = comm.max([here])
        (first,) = comm.max([-comm.rank if here == largest else -np.inf])
        field = np.zeros_like(self.D)
        if -comm.rank == first:
            field.flat[self.D.argmax()] = 1
        return field

    def _apply(self, field: np.ndarray, out: np.ndarray) -> None:
        """Set out = K field on open points, 0 in contact, by one FFT pair. Collective."""

        def use(i0: int, i1: int, x: np.ndarray) -> None:
            out[i0:i1] = x[: i1 - i0] * (1 - self.closed[i0:i1])

        self.elastic.pressure_rows(reader(field))
        self.elastic.columns(spring=self.problem.spring)
        self.elastic.use_rows(use)

    def _precondition(self) -> float:
        """Set z = M residual on open points; return <residual, z> of all ranks. Collective."""
        rz = self.levels.precondition(self.residual_and_contact, self.z)
        compliance = 1 / self.problem.body.scale(self.grid)

        def mask(i0: int, i1: int) -> None:
            self.z[1 + i0 : 1 + i1] *= 1 - self.closed[i0:i1]

        self.grid.by_rows(mask)
        return compliance * rz

    def _best(self, V: np.ndarray, KV: np.ndarray, k: int) -> tuple[float, np.ndarray]:
        """Return mu of D in the span of V[:k], and the weights (3,) of its mode. Collective."""

        def products(i0: int, i1: int) -> np.ndarray:
            sums = np.zeros((2, 3, 3))
            subspace_products(V, KV, self.D, k, i0, i1, sums)
            return sums

        total = np.sum([np.zeros((2, 3, 3)), *self.grid.by_rows(products)], axis=0)
        total = np.reshape(self.grid.comm.sum(total.ravel()), (2, 3, 3))[:, :k, :k]
        stiff, soft = (np.tril(a) + np.tril(a, -1).T for a in total)
        scale = 1 / np.sqrt(np.maximum(np.diag(stiff), np.finfo(float).tiny))
        values, Q = np.linalg.eigh(stiff * np.outer(scale, scale))
        keep = values > INDEPENDENT * values[-1]
        Q = scale[:, None] * Q[:, keep] / np.sqrt(values[keep])
        mu, X = np.linalg.eigh(Q.T @ soft @ Q)
        weights = np.zeros(3)
        weights[:k] = Q @ X[:, -1]
        return float(mu[-1]), weights

    def _combine(self, V: np.ndarray, KV: np.ndarray, k: int, weights: np.ndarray) -> None:
        """Set V[0] to the sum of weights[i] V[i], V[2] to the same without i = 0; KV likewise."""
        real = weights.astype(self.dtype)

        def combine(i0: int, i1: int) -> None:
            combine_directions(V, KV, k, real, i0, i1)

        self.grid.by_rows(combine)

    def _set_residual(self, e: np.ndarray, Ke: np.ndarray, mu: float) -> None:
        """Set self.residual to R = D e - mu K e. Local."""
        real = self.dtype.type(mu)

        def subtract(i0: int, i1: int) -> None:
            self.residual[i0:i1] = self.D[i0:i1] * e[i0:i1] - real * Ke[i0:i1]

        self.grid.by_rows(subtract)

    def _normalise(self, field: np.ndarray) -> None:
        """Scale a field in place so that its largest absolute value is about 1. Collective."""
        largest = self.grid.comm.max([float(np.abs(field).max(initial=0.0))])[0]
        if largest > 0:
            field *= self.dtype.type(1 / largest)
