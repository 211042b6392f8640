"""How stable an equilibrium with attraction is, and in which direction the least.

At fixed contact A a small displacement e of the open points changes the energy by
1/2 <e, (K + phi'') e>, where phi'' <= 0. The stability is

    s = min <e, (K + phi'') e>/<e, K e>    over e = 0 on A:

1 without attraction, 0 where the surfaces are about to jump, and below 0 at a saddle, from which
the energy falls along e. It is 1 - mu, mu being the largest eigenvalue of D = -phi'' with respect
to K. It is found by locally optimal conjugate gradients (Knyazev 2001) in the space of e, the
preconditioned residual and the last change of e: one application of K a step. The first e is
M D 1, which has no change of sign, like the mode that is looked for; with it comes the mode that
was found before, if there is one.

A value that is found so is never too small. How much too large it may be follows from the residual
R = D e - mu K e, as there is an eigenvalue within |R|_S/|e|_K of mu; M stands for S = 1/K on open
points. Before the search has come to rest there may be a larger one, so twice as much counts then.
Where single points are soft there may be modes of few points, which the first e hardly has a part
of: the search goes on for some steps then.

An equilibrium at the distance m/s, m = |u - T(u)|_K, is one to first order. On the way phi''
changes: just beyond a jump there are states with a small m and s > 0, but no equilibrium. So what
counts is s of the secant: 1 + <t(g + x e) - t(g), e>/x on both sides, |e|_K = 1, where x is the
smallest x with x s >= m. Where there is none nothing says that there is an equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..kernels.adhesive_rows import pull_along, softening
from ..kernels.subspace import combine_directions, subspace_products
from ..operators.elastic import Elastic
from ..operators.multilevel import Multilevel

if TYPE_CHECKING:
    from ..operators.problem import Problem

STEPS = 60  # at most
SOFT, FEWEST = 0.5, 4  # softening over stiffness of a point, above which so many steps are made
TOLERANCE = 0.02  # of s, by which the last step may have changed it
DOUBTED = 0.25  # share of an s that counts at least, however badly it is known
LEAST = 0.02  # an s to the accuracy of which smaller ones are found
INDEPENDENT = 1e-10  # of the largest eigenvalue of the Gram matrix: less is no direction
FARTHER = 20  # distances that are tried, each as far as the stability up to the last one says
NEAR_ENOUGH = 0.95  # share of a distance that is the same


@dataclass(frozen=True)
class Stability:
    """What is known of the stability of a state.

    Attributes
    ----------
    value : float
        s, from above.
    lowest : float
        s that is to be reckoned with.
    mode : array or None
        e, local slab, positive where the gap opens; None where no open point attracts.
    pairs : float
        FFT pairs that it took.
    """

    value: float
    lowest: float
    mode: np.ndarray | None
    pairs: float


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
    """Find the stability of a state.

    Collective.

    Parameters
    ----------
    problem : Problem
        With an attraction.
    g, p : array, local slabs
        Gap, and pressure of the wall.
    levels : Multilevel
        Of the grid, in the working precision; its fields are overwritten.
    enough, too_little : float
        Bounds (high, low) of interest: the search ends once `lowest` is above the first, or `value`
        is below the second.
    mode : array, local slab
        Where the search begins; its memory is used.
    tolerance : float
        Relative change of s in the last step.

    Returns
    -------
    Stability
    """
    search = _Search(problem, g, p, levels)
    if not search.attracts:
        return Stability(1.0, 1.0, None, 0.0)
    return search.run(enough, too_little, mode, tolerance)


def stability_up_to_equilibrium(
    problem: Problem, g: np.ndarray, found: Stability, distance: float
) -> float:
    """Return the stability by which errors are to be divided, no more than `found.lowest`: 0 where
    the attraction changes so much on the way that there may be no equilibrium.

    Collective. No FFT.

    Parameters
    ----------
    problem : Problem
        With an attraction.
    g : array, local slab
        Gap.
    found : Stability
        Of this gap.
    distance : float
        |u - T(u)|_K, from the contact under this attraction, frozen.

    Returns
    -------
    float
        The same on all ranks.
    """
    mode, law = found.mode, problem.law(np.dtype(np.float64))
    if mode is None or found.lowest <= 0 or distance == 0:
        return found.lowest
    grid = problem.grid

    def pull(length: float) -> float:
        def pull_of_rows(i0: int, i1: int) -> float:
            return float(pull_along(law, g, mode, length, i0, i1, grid.inside))

        (total,) = grid.comm.sum([sum(grid.by_rows(pull_of_rows))])
        return float(total)

    doubt = found.value - found.lowest
    stability = found.lowest
    for _ in range(FARTHER):
        way = distance / stability
        secant = 1 + min(pull(way), -pull(-way)) / way - doubt
        if secant >= NEAR_ENOUGH * stability:
            return min(secant, stability)
        if not secant > 0:
            break
        stability = secant
    return 0.0


class _Search:
    """The fields of one search."""

    def __init__(self, problem: Problem, g: np.ndarray, p: np.ndarray, levels: Multilevel):
        self.problem, self.levels = problem, levels
        self.grid, self.dtype = problem.grid, problem.dtype
        self.elastic = Elastic(self.grid, problem.body, self.dtype)
        rows, n_y = self.grid.shape
        # with the halo rows that the transfer expects
        self.residual_and_contact = np.zeros((2, rows + 2, n_y), self.dtype)
        self.residual, self.closed = self.residual_and_contact[:, 1:-1]
        self.z = np.zeros((rows + 2, n_y), self.dtype)
        self.D = self.grid.empty(self.dtype)
        inside, law = self.grid.inside, problem.law()

        def soften(i0: int, i1: int) -> tuple[float, float]:
            here = slice(i0, max(min(i1, inside[0]), i0)), slice(0, inside[1])
            self.closed[here] = (g[here] <= 0) & (p[here] > 0)
            return softening(law, g, self.closed, self.D, i0, i1, inside)

        found = [(0.0, 0.0), *self.grid.by_rows(soften)]
        self.attracts = bool(self.grid.comm.sum([sum(total for total, _ in found)])[0] > 0)
        (largest,) = self.grid.comm.max([max(float(x) for _, x in found)])
        self.softness = largest / float(problem.body.near(self.grid)[0])

    def run(
        self, enough: float, too_little: float, mode: np.ndarray | None, tolerance: float
    ) -> Stability:
        """Step until s is known well enough."""
        shape = (3, *self.grid.shape)
        V, KV = np.zeros(shape, self.dtype), np.zeros(shape, self.dtype)
        self.residual[...] = self.D
        self._precondition()
        V[0] = self.z[1:-1]
        self._normalise(V[0])
        self._apply(V[0], KV[0])
        directions = 1
        if mode is not None:
            V[1] = mode
            V[1] *= 1 - self.closed
            self._normalise(V[1])
            self._apply(V[1], KV[1])
            directions = 2
        fewest = FEWEST if self.softness > SOFT else 1
        s, lowest = np.nan, -np.inf
        for step in range(1, STEPS + 1):
            before = s
            mu, weights = self._best(V, KV, directions)
            s = 1 - mu
            self._combine(V, KV, directions, weights)
            self._leave(V[0], KV[0], mu)
            missing = self._precondition()  # <R, M R>; <e, K e> is 1
            doubt = np.sqrt(max(missing, 0.0))
            lowest = s - 2 * doubt
            if (lowest > enough and step >= fewest) or s < too_little or not missing > 0:
                break
            if abs(s - before) < tolerance * max(abs(s), LEAST):
                lowest = max(s - doubt, s / 2)
                break
            V[1] = self.z[1:-1]
            self._normalise(V[1])
            self._apply(V[1], KV[1])
            directions = min(directions + 1, 3)
        if s > 0:  # rather than nothing
            lowest = max(lowest, DOUBTED * s)
        upward = self.grid.comm.sum([V[0].sum(dtype=float)])[0] >= 0
        return Stability(s, min(lowest, s), V[0] if upward else -V[0], self.elastic.pairs)

    def _apply(self, field: np.ndarray, out: np.ndarray) -> None:
        """Set out = K field on open points, 0 in contact."""

        def fill(i0: int, i1: int, x: np.ndarray) -> None:
            x[: i1 - i0] = field[i0:i1]

        def use(i0: int, i1: int, x: np.ndarray) -> None:
            out[i0:i1] = x[: i1 - i0] * (1 - self.closed[i0:i1])

        self.elastic.pressure_rows(fill)
        self.elastic.pressure_columns(spring=self.problem.spring)
        self.elastic.use_rows(use)

    def _precondition(self) -> float:
        """Make z = M residual on open points; returns <residual, z>."""
        self.levels.restrict_from(0, self.residual_and_contact)
        self.levels.sweep()
        rz = self.levels.smooth(0, self.residual_and_contact, self.z)[0]
        compliance = 1 / self.problem.body.scale(self.grid)

        def mask(i0: int, i1: int) -> None:
            self.z[1 + i0 : 1 + i1] *= 1 - self.closed[i0:i1]

        self.grid.by_rows(mask)
        return compliance * float(self.grid.comm.sum([rz])[0])

    def _best(self, V: np.ndarray, KV: np.ndarray, k: int) -> tuple[float, np.ndarray]:
        """Return the largest eigenvalue of D in the first k directions, and the weights of its
        direction, of which <e, K e> = 1."""

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
        """Set V[0] to the best direction, and V[2] to what is new in it."""
        real = weights.astype(self.dtype)

        def combine(i0: int, i1: int) -> None:
            combine_directions(V, KV, k, real, i0, i1)

        self.grid.by_rows(combine)

    def _leave(self, e: np.ndarray, Ke: np.ndarray, mu: float) -> None:
        """Set the residual R = D e - mu K e on open points."""
        real = self.dtype.type(mu)

        def leave(i0: int, i1: int) -> None:
            self.residual[i0:i1] = self.D[i0:i1] * e[i0:i1] - real * Ke[i0:i1]

        self.grid.by_rows(leave)

    def _normalise(self, field: np.ndarray) -> None:
        """Scale a field so that its largest value is about 1: only its direction counts."""
        largest = self.grid.comm.max([float(np.abs(field).max(initial=0.0))])[0]
        if largest > 0:
            field *= self.dtype.type(1 / largest)
