"""Constrained conjugate gradients on the pressure (Polonsky and Keer, Wear 231, 206, 1999).

Minimises 1/2 <p, S p> + <p, h> over pressures p >= 0 of mean p0, S the inverse of K. In contact,
p > 0, the gap e = S p + h - constant has to vanish; the constant is such that its mean there does.
One iteration: conjugate direction t from e, exact line search (one convolution with S),
p <- max(p - tau t, 0), pressure for points out of contact that penetrate (the direction is then
forgotten), rescaling of p to the mean p0 (the load balance), and the new gap (a second
convolution): two FFT pairs. With the option `preconditioned` the direction is made from K e instead
of e, which takes a third.

The gap that is returned is closed, g = 0, wherever p > 0, and max(e, 0) elsewhere.
"""

from collections.abc import Sequence

import numpy as np

from ..kernels import ccg as kernels
from ..operators.elastic import reader
from ..operators.problem import Problem
from ..parallel.threads import added
from ..util.aligned import zeros_aligned
from .base import Progress, Solver

Parts = Sequence[tuple[float, ...]]  # what passes returned

# stiffness of a point that is taken into contact, preconditioned, relative to the largest
# eigenvalue of K
TAKEN = 0.05
# of the same, at which gaps left in contact count as pressure: up to 2 times more than what the
# certificate finds
RESIDUAL = 0.25


class Ccg(Solver):
    """options: preconditioned, 0 or 1 (default 0). Raises SceneError for others."""

    name = "ccg"
    sources = ("Polonsky, Keer, Wear 231 (1999) 206, doi:10.1016/S0043-1648(99)00113-1",)
    nests = False  # a pressure from a coarser grid is a bad start
    state_names = ("g", "p", "iterate", "gap0", "t")
    scalar_names = (
        "offset",
        "shift",
        "ee",
        "below",
        "contact",
        "gap",
        "previous",
        "fresh",
        "iterations",
    )
    holds_tension = False
    allowed = {"preconditioned": (0, 1)}

    def __init__(self, problem: Problem, options: dict[str, float] | None = None):
        super().__init__(problem, options)
        self.preconditioned = self.options.get("preconditioned", 0) > 0
        grid, dtype = self.grid, problem.dtype
        self.real = dtype.type
        self.iterate, self.gap0 = grid.empty(dtype), grid.empty(dtype)
        self.t = zeros_aligned(grid.shape, dtype)
        self.stiffest = problem.body.bounds(grid)[1]  # the largest eigenvalue of K
        self.patience = 5 * self.patience

    # -- starting

    def start(self, g: np.ndarray) -> None:
        p0, inside = self.real(self.p_cell), self.grid.inside
        self.g[...] = g
        self.elastic.pressure_rows(
            self.problem.displacement_rows(self.g, self.problem.level(self.g))
        )
        self.elastic.pressure_columns()
        (load,) = self._sum(
            self.elastic.use_rows(
                lambda i0, i1, x: kernels.start_pressure(
                    self.g, self.iterate, x, p0, inside, i0, i1
                )
            ),
            1,
        )
        if load <= 0:  # nothing is closed yet
            self.iterate[: inside[0], : inside[1]] = self.p0
            load = self.N * self.p0
        self.offset = self.shift = 0.0
        self._begin(load)

    def continue_at(self, p0: float) -> None:
        load, self.p0 = self.N * self.p0, float(p0)
        self._begin(load)

    def _begin(self, load: float) -> None:
        """Begin with the iterate, which carries that load."""
        self.elastic.pressure_rows(reader(self.iterate))
        self._new_gap(load)
        self.refresh()

    def refresh(self, uKu: float | None = None) -> None:
        """Forget the direction: only that is carried on from one iteration to the next."""
        self.fresh, self.previous = True, 1.0

    # -- one iteration

    def step(self) -> None:
        tau = self._search()
        kick = tau * (TAKEN * self.stiffest if self.preconditioned else 1.0)
        args = self.real(self.shift), self.real(tau), self.real(kick)
        load, taken = self._sum(
            self.elastic.pressure_rows(
                lambda i0, i1, x: kernels.pressure_step(
                    self.iterate, self.t, self.gap0, x, i0, i1, *args, self.grid.inside
                )
            ),
            2,
        )
        self._new_gap(load)
        self.fresh = bool(taken > 0)
        self.iterations += 1

    def _search(self) -> float:
        """Make a new direction t and return the step tau along it, which minimises the energy at
        constant mean pressure."""
        shift = self.real(self.shift)
        size, a, c = self.ee, 1.0, 0.0
        if self.preconditioned:
            self.elastic.pressure_rows(
                lambda i0, i1, x: kernels.gap_in_contact(self.gap0, self.iterate, x, i0, i1, shift)
            )
            size = float(self.grid.comm.sum([self.elastic.pressure_columns()])[0])
        b = 0.0 if self.fresh or self.previous <= 0 else size / self.previous
        self.previous = size
        if self.preconditioned:
            b_ = self.real(b)
            (z,) = self._sum(
                self.elastic.use_rows(
                    lambda i0, i1, x: kernels.conjugate_direction(
                        self.t, self.iterate, x, i0, i1, b_
                    )
                ),
                1,
            )
            a, b, c = 0.0, 1.0, z / self.contact
        args = shift, self.real(a), self.real(b), self.real(c)
        et = self.elastic.pressure_rows(
            lambda i0, i1, x: kernels.search_direction(
                self.t, self.gap0, self.iterate, x, i0, i1, *args
            )
        )
        tSt = self.elastic.displacement_columns()
        r = self.elastic.use_rows(lambda i0, i1, x: kernels.response_sum(self.iterate, x, i0, i1))
        et, t, r, tSt = self.grid.comm.sum([*added(et, 2), *added(r, 1), tSt])
        curvature = tSt - r * t / self.contact
        # S_CC >= 1/(largest eigenvalue of K), S_CC K_CC >= 1; where nothing is left to do in
        # contact the quotient is noise
        largest = 1.0 if self.preconditioned else self.stiffest
        return float(np.clip(et / curvature, 0.0, largest)) if curvature > 0 else largest

    def _new_gap(self, load: float) -> None:
        """Scale the iterate, the rows of which are transformed, to the mean p0, and compute its
        gap, the mean of that in contact, and the state that is returned."""
        scale = self.real(self.N * self.p0 / load)
        self.offset += self.shift
        offset = self.real(self.offset)
        self.elastic.displacement_columns()
        total, contact = self._sum(
            self.elastic.use_rows(
                lambda i0, i1, x: kernels.new_gap(
                    self.iterate, self.gap0, self.problem.heights, x, i0, i1, scale, offset
                )
            ),
            2,
        )
        self.shift, self.contact = float(total / contact), float(contact)
        fields, shift = (self.iterate, self.gap0, self.g, self.p), self.real(self.shift)
        sums = self.grid.by_rows(
            lambda i0, i1: kernels.feasible_state(*fields, shift, self.grid.inside, i0, i1)
        )
        self.ee, self.below, self.gap = self._sum(sums, 3).tolist()

    def _sum(self, parts: Parts, count: int) -> np.ndarray:
        return self.grid.comm.sum(added(parts, count))

    # -- how far

    def progress(self) -> Progress:
        """Tell how far the solver is. residual: an estimate of K applied to what is left of the
        gap: e in contact, and e < 0 elsewhere."""
        residual = (
            RESIDUAL * self.stiffest * float(np.sqrt((self.ee + self.below) / self.N)) / self.p0
        )
        return Progress(
            residual, self.contact, self.gap / self.N, None, bool(np.isfinite(residual + self.gap))
        )
