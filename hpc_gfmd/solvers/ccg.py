"""Constrained conjugate gradients on the pressure (Polonsky and Keer, Wear 231, 206, 1999).

Minimises 1/2 <q, S q> + <q, h> over pressures q >= 0 of mean p0. In contact, {q > 0}, the gap e = S q + h - shift has to vanish; shift
is its mean there. One iteration: conjugate direction t from e, exact line search (one convolution with S), q <- max(q - tau t, 0),
pressure for points out of contact that penetrate (the direction is then forgotten), rescaling of q to the mean p0 (the load balance), and
the new gap (a second convolution): two FFT pairs. With the option `preconditioned` the direction is made from K e, a third one.

The returned gap is closed, g = 0, wherever q > 0 and max(e, 0) elsewhere.
"""

import numpy as np

from ..elasticity import HalfSpace
from ..kernels.pressure import advance, close, conjugate, direct, gradient, press, respace, respond
from ..options import read_options
from .base import Progress, Solver


class Ccg(Solver):
    """options: preconditioned, 0 or 1 (default 0). Raises SceneError for others."""

    name = "ccg"
    state_names = ("g", "p", "q", "w", "t")
    scalar_names = ("shift", "offset", "size", "previous", "ee", "below", "qq", "contact", "gap", "iterations")
    allowed = {"preconditioned": (0, 1)}

    def __init__(self, problem, options=None):
        super().__init__(problem, options)
        self.options = read_options(self.name, self.options, self.allowed)
        self.preconditioned = self.options.get("preconditioned", 0) > 0
        grid, dtype = self.grid, problem.dtype
        self.elastic = HalfSpace(grid, dtype)
        self.real = dtype.type
        self.g, self.p, self.q, self.w = (grid.empty(dtype) for _ in range(4))
        self.t = np.zeros(grid.shape, dtype)
        self.stiffness = grid.q_nyquist / np.sqrt(2)  # largest eigenvalue of K
        self.patience = 5 * self.patience

    # -- starting ------------------------------------------------------------------------------------------------------------

    def start(self, g):
        self.g[...] = g
        h = self.problem.h

        def fill(i0, i1, x):
            np.subtract(self.g[i0:i1], h[i0:i1], out=x[: i1 - i0])

        self.elastic.pressure_rows(fill)
        self.elastic.pressure_columns()
        p0 = self.real(self.p0)
        load, = self._sum(self.elastic.use_rows(lambda i0, i1, x: press(self.g, self.q, x, p0, i0, i1)), 1)
        if load <= 0:  # nothing is closed yet
            self.q[...] = self.p0
            load = self.N * self.p0
        self.offset = self.shift = 0.0
        self._forget()

        def copy(i0, i1, x):
            x[: i1 - i0] = self.q[i0:i1]

        self._respace(self.elastic.compliance(copy), load)

    def continue_at(self, p0):
        """The pressure in proportion."""
        ...
