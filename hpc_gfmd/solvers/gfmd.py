"""Green's function molecular dynamics, the algorithm of the paper's appendix: damped Verlet
dynamics of the displacement.

    u_new = 2 u_now - u_old - dt^2 [p + eta (u_now - u_old)],    p = p0 + K u
    u_new <- max(u_new, -h)

with one scalar mass (1 here) and one scalar damping eta in real space, and zero restitution: u_old
<- u_now where the wall was hit. With d = u_now - u_old and the gap g = u + h this is d <- b d - a
p, g <- max(g + d, 0), a = dt^2, b = 1 - eta dt^2, and p changes by K times the change of g: one FFT
pair per time step, in two passes over memory.

If the slowest free mode has the stiffness mu and the stiffest lambda, then a = 4/(sqrt(lambda) +
sqrt(mu))^2 is at the stability limit and b = [(sqrt(lambda) - sqrt(mu))/(sqrt(lambda) +
sqrt(mu))]^2 damps the slowest mode critically. lambda is known, mu depends on load and roughness:
it is measured in every step. The velocity d soon lives in the slow modes, so that its Rayleigh
quotient <d, K d>/<d, d> falls towards mu; too much damping lowers it further, too little brings
faster modes back. Half of it leaves the slow modes slightly underdamped; whenever the pressure does
negative work on the motion, <p, d> > 0, the velocity is dropped.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..kernels.dynamics import DynamicsSums, update_pressure, verlet_step
from ..operators.problem import Problem
from ..parallel.threads import added, on_threads
from ..util.aligned import zeros_aligned
from .base import Progress, Solver

DT = 0.95  # default time step, relative to the stability limit
UNDERDAMPED = 0.5  # mu over the Rayleigh quotient of the velocity
ESTIMATED_EVERY = 4  # time steps from one estimate of the errors to the next
PATIENCE = 20  # stagnation is judged over that many time scales sqrt(lambda/mu) of the longest wave


class Gfmd(Solver):
    """The paper's damped dynamics, see the file's head: no hardness, no attraction.

    Options: dt, relative to the stability limit; damping, constant, in units of the critical one of
    the longest wave (default: chosen in every step). d: velocity, the last change of the gap;
    longest and stiffest: smallest and largest K; rr, pp, pd, dd, dx, contact, gap: DynamicsSums
    over all ranks, x being K d.
    """

    name = "gfmd"
    allowed = {"dt": (0.01, 1.0), "damping": (0.0, 1e6)}

    def __init__(
        self, problem: Problem, options: dict[str, float] | None = None, g: np.ndarray | None = None
    ):
        super().__init__(problem, options, g)
        self.d = zeros_aligned(self.grid.shape, problem.dtype)
        self.longest, self.stiffest = problem.body.bounds(self.grid)
        self.patience = max(
            4 * self.patience, int(PATIENCE * np.sqrt(self.stiffest / self.longest))
        )

    # -- starting

    def start(self, g: np.ndarray) -> None:
        """Begin at rest at the gap g >= 0 (local slab, copied): compute p with one FFT pair."""
        self._lay(g)
        self.problem.transform_displacement(self.elastic.fft, self.state.g)
        uKu = self.elastic.columns()
        self.state.uKu = float(self.grid.comm.sum([uKu])[0])
        self._measure(self.elastic.use_rows(self._update))
        if self.wall.undeform(self.state):
            self.restart()

    def restart(self) -> None:
        """Set the velocity to 0 and sum up the present g and p again, without an FFT."""
        self.d[...] = 0
        fft = self.elastic.fft
        zero = np.zeros((fft.R, self.grid.n[1]), self.problem.dtype)
        passes = [(i0, i1, zero) for i0, i1 in fft.passes()]
        self._measure(on_threads(self.grid.threads, self._update, passes))

    def after_certificate(self) -> None:
        """Keep the velocity: a certificate changes p by rounding errors only."""

    # -- one time step

    def step(self) -> None:
        """Make one time step, with one FFT pair: change the state, and the velocity d in place."""
        a, b = (self.problem.dtype.type(c) for c in self._coefficients())
        fields = self.state.g, self.state.p, self.d
        self.elastic.pressure_rows(
            lambda i0, i1, x: verlet_step(*fields, x, i0, i1, a, b, self.grid.inside)
        )
        self.elastic.columns()
        self._measure(self.elastic.use_rows(self._update))
        self.iterations += 1

    def _coefficients(self) -> tuple[float, float]:
        """Return a = dt^2, b = 1 - eta dt^2 of the next step; b is 0 if the last went uphill."""
        damping = self.options.get("damping")
        if damping is not None:
            mu = min(damping * damping * self.longest, self.stiffest)
        else:
            mu = (
                UNDERDAMPED * min(max(self.dx / self.dd, 0.0), self.stiffest)
                if self.dd > 0
                else 0.0
            )
        ratio = np.sqrt(mu / self.stiffest)
        a = 4 * self.options.get("dt", DT) ** 2 / (self.stiffest * (1 + ratio) ** 2)
        uphill = self.pd > 0 and damping is None
        return a, 0.0 if uphill else ((1 - ratio) / (1 + ratio)) ** 2

    def _update(self, i0: int, i1: int, x: np.ndarray) -> tuple[float, ...]:
        """Add x, rows of K d, to the pressure on local rows i0 <= i < i1; return their
        DynamicsSums.
        """
        return update_pressure(self.state.g, self.state.p, self.d, x, i0, i1, self.grid.inside)

    def _measure(self, parts: Sequence[tuple[float, ...]]) -> None:
        """Sum the DynamicsSums of this rank's passes over all ranks, and store them in self."""
        sums = self.grid.comm.sum(added(parts, len(DynamicsSums._fields)))
        self.rr, self.pp, self.pd, self.dd, self.dx, self.contact, self.gap = map(
            float, DynamicsSums(*sums)
        )

    # -- how far

    def progress(self, with_errors: bool = True) -> Progress:
        """Return how far the state is from the solution, with estimates after every fourth step."""
        residual = float(np.sqrt(self.rr / self.N)) / self.state.p0
        finite = bool(np.isfinite(self.pp + self.gap))
        errors = None
        if finite and with_errors and self.iterations % ESTIMATED_EVERY == 0:
            errors = self.estimate_errors()
        return Progress(residual, self.contact, self.gap / self.N, errors, finite)
