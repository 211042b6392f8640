"""Projected conjugate gradients in displacement space, one FFT pair per iteration.

Preconditioned by the locally damped multilevel operator of `multilevel.py`. Each step minimises the energy in the plane of the
preconditioned residual z and the last step d; <z, K z>, which would cost a second FFT, is predicted from the Rayleigh quotients of
the last steps. The step is clipped to the feasible set, and the energy along the (feasible) chord is minimised exactly, so it never
rises. Where clipping spoils the descent the step is replaced by a plain projected gradient step.

One iteration is three passes over memory: `propose` + row transforms, column transforms with K between them, row transforms + `update`.
The displacement itself never appears: with the gap g = u + h and p = p0 + K u, steps change both by the same d and K d.
"""

import numpy as np

from ..elasticity import HalfSpace
from ..kernels.contact import propose
from .base import Progress, Solver
from .multilevel import COUPLING, Multilevel

RHO_MIN, RHO_MAX = 0.4, 1.45  # bounds of the predicted Rayleigh quotient
MEMORY = 3  # steps that the prediction looks back
GRADIENT = 1.42  # bound of kap K's spectrum, sqrt 2: the step of a projected gradient
DESCENT = 0.2  # share of the predicted descent that clipping must leave


class Bpx(Solver):
    """The default solver. options: none. g: memory for the gap, taken over."""

    name = "bpx"
    state_names = ("g", "p", "d")
    scalar_names = ("s", "rayleigh", "plain", "gaps", "contacts", "rz", "rd", "zq", "dq", "rr", "pp", "lifting", "iterations")

    def __init__(self, problem, options=None, g=None):
        super().__init__(problem, options)
        grid, dtype = self.grid, problem.dtype
        self.elastic = HalfSpace(grid, dtype)
        self.fft = self.elastic.fft
        self.levels = Multilevel(grid, dtype, self.fft.R)
        self.passes = self.levels.passes
        self.g = grid.empty(dtype) if g is None else g
        self.p, self.d = grid.empty(dtype), np.zeros(grid.shape, dtype)
        self.kap = 2.0 / grid.q_nyquist
        self._rows = {id(x): np.zeros((6, grid.n[1] + 1), dtype) for x in self.fft.row_scratch}
        self._number = {a: k for k, (a, _) in enumerate(self.passes)}

    # -- starting ------------------------------------------------------------------------------------------------------------

    def start(self, g):
        if g is not self.g:
            self.g[...] = g
        self.p[...] = self.p0
        self.d[...] = 0
        self.elastic.pressure_rows(self.problem.displacement_rows(self.g), self.passes)
        self.elastic.pressure_columns(self.problem.adder(self.fft))
        self._begin(self._update(1.0))

    def continue_at(self, p0):
        self.p += self.problem.dtype.type(p0 - self.p0)
        self.p0 = float(p0)
        self.refresh()

    def refresh(self):
        self.d[...] = 0
        self._begin(self._update_still())

    def _begin(self, sums):
        """A new descent begins: no momentum, no memory of Rayleigh quotients."""
        self.s = 1.0
        self.rayleigh, self.plain = [], True
        self.gaps, self.contacts = [], []
        self._measure(sums)

    def load_state(self, arrays, numbers):
        super().load_state(arrays, numbers)
        self._update_still()
        self.levels.sweep()  # z on the coarse levels follows from g and p
        self._set_numbers(numbers)

    # -- one iteration -------------------------------------------------------------------------------------------------------

    def step(self):
        a, b = self._coefficients()
        if self.plain:
            pd = self._propose_gradient()
        else:
            pd = self._propose(a, b, COUPLING)
            if -pd < DESCENT * (a * self.rz + b * self.rd):
                self.plain = True
                pd = self._propose_gradient()
        dKd = float(self.grid.comm.sum([self.elastic.pressure_columns()])[0])
        optimum = -pd / dKd if dKd > 0 else 1.0
        self.s = optimum if 0 < optimum < 0.8 else 1.0
        sums = self._update(self.s)

        if self.plain:
            self.rayleigh, self.plain = [], False
        else:
            zKz = dKd - 2 * a * b * self.zq - b * b * self.dq
            self.rayleigh = (self.rayleigh + [zKz / (a * a * self.rz)])[-MEMORY:]
        self._measure(sums)
        self.iterations += 1

    def _coefficients(self):
        """a and b of the step -(a z + b d): the minimum of the energy in the plane of z and d."""
        if self.plain:
            return 0.0, 0.0
        rho = np.clip(max(self.rayleigh), RHO_MIN, RHO_MAX) if len(self.rayleigh) >= 2 else RHO_MAX
        rz, rd, zq, dq = self.rz, self.rd, self.zq, self.dq
        zz = rho * rz
        if dq <= 0 or rz <= 0:
            return (rz / zz if rz > 0 else 0.0), 0.0
        if zz * dq - zq * zq < 0.1 * zz * dq:
            zz = zq * zq / (0.9 * dq)
        det = zz * dq - zq * zq
        a = (rz * dq - rd * zq) / det
        b = (zz * rd - zq * rz) / det
        return (a, b) if a > 0 else (1.0 / rho, 0.0)

    def _propose(self, a, b, w):
        """First pass: the next step into d and its row spectra; returns <p, d>."""
        t, real = self.levels.transfers[0], self.problem.dtype.type
        z = self.levels.z
        args = (real(self.kap), real(w), real(a), real(b * self.s))

        def fill(i0, i1, x):
            return propose(self.g, self.p, self.d, x, i0, i1, z, t.k0, t.f_x, t.mode, t.j0, t.f, *args, self._rows[id(x)])

        return float(self.grid.comm.sum([sum(self.elastic.pressure_rows(fill, self.passes))])[0])

    def _propose_gradient(self):
        return self._propose(1.0 / GRADIENT, 0.0, 0.0)

    def _update(self, s):
        """Last pass: x = K d by rows, new g and p; returns this rank's sums (see kernels/contact.py)."""
        sums = self.elastic.use_rows(lambda i0, i1, x: self._update_rows(i0, i1, x, s), self.passes)
        return np.sum(np.reshape(sums, (-1, 8)), axis=0)

    def _update_still(self):
        """The sums of `_update` for the state as it is."""
        zero = np.zeros((self.fft.R, self.grid.n[1]), self.problem.dtype)
        sums = [self._update_rows(a, b, zero, 0.0) for a, b in self.passes]
        return np.sum(np.reshape(sums, (-1, 8)), axis=0)

    def _update_rows(self, i0, i1, x, s):
        rows = self._rows.get(id(x))
        if rows is None:
            rows = next(iter(self._rows.values()))
        return self.levels.update_rows(self._number[i0], self.g, self.p, self.d, x, self.problem.dtype.type(s), rows)

    def _measure(self, sums):
        """Sweep the levels and sum over ranks: all scalars of the next step and of the stopping rule."""
        rz1, xz1 = self.levels.sweep()
        rr, pp, pd, dx, px, contact, gap, lifting, rz1, xz1 = self.grid.comm.sum([*sums, rz1, xz1])
        s, kap = self.s, self.kap
        self.rz = kap * (rr + COUPLING * rz1)  # <p, z> on F
        self.rd = s * pd  # <p, d>
        self.zq = s * kap * (px + COUPLING * xz1)  # <z, K d>
        self.dq = s * s * dx  # <d, K d>
        self.rr, self.pp = rr, pp
        self.lifting = lifting
        self.gaps = (self.gaps + [gap / self.N])[-3:]
        self.contacts = (self.contacts + [contact])[-5:]

    # -- how far -------------------------------------------------------------------------------------------------------------

    def progress(self):
        contact, gap = self.contacts[-1], self.gaps[-1]
        closed = max(self.pp - self.rr, 0.0)
        finite = bool(np.isfinite(self.pp + gap))
        residual = np.sqrt(self.rr / self.N) / self.p0
        if self.rr == 0.0 and contact == self.N:
            estimates = (0.0, 0.0, 0.0)
        elif len(self.gaps) < 3 or contact == 0 or closed == 0 or gap <= 0:
            estimates = (np.inf, np.inf, np.inf)
        else:
            changes = abs(np.diff(self.contacts))
            # The area is a whole number of pixels: one may be wrong until none has changed for a while.
            pixel = 0 if len(changes) == 4 and not changes.any() else 1
            area = (2 * max(changes[-2:]) + self.lifting + pixel) / contact
            mean_gap = max(2 * np.sqrt(self.rz / (self.N * self.p0 * gap)), 1.05 * max(abs(np.diff(self.gaps))) / gap)
            estimates = (area, mean_gap, 2 * np.sqrt(self.rr / closed))
        return Progress(float(residual), contact, gap, tuple(float(e) for e in estimates), finite)
