"""Projected conjugate gradients in displacement space, one FFT pair per iteration.

Preconditioned by the locally damped multilevel operator of `multilevel.py`. Each step minimises the energy in the plane of the
preconditioned residual z and the last step d; <z, K z>, which would cost a second FFT, is predicted from the Rayleigh quotient of
the last step. The step is clipped to the feasible set, and the energy along the (feasible) chord is minimised exactly, so it never
rises. Where clipping spoils the descent the step is replaced by a plain projected gradient step.

One iteration is three passes over memory: `propose` + row transforms, column transforms with K between them, row transforms + `update`.
The displacement itself never appears: with the gap g = u + h and p = p0 + K u, steps change both by the same d and K d.
"""

from dataclasses import replace

import numpy as np

from ..aligned import LINE, zeros_aligned
from ..kernels.contact import propose
from ..operators.elastic import Elastic
from ..operators.multilevel import COUPLING, Multilevel
from ..options import read_options
from .base import Progress, Solver

RHO_MIN, RHO_MAX = 0.4, 1.0  # bounds of the predicted Rayleigh quotient
GRADIENT = 1.0041  # times the largest K, over kap: a projected gradient step is a little shorter than what K allows
DESCENT = 0.2  # share of the predicted descent that clipping must leave
CLIPPED = 0.02  # share of it up to which a step counts as not clipped
SHORT = 0.8  # a clipped step is made shorter only below this: clipped points stay a little open then

# The error estimates (see Bpx._estimates); the factors cover the largest ratios ever seen of error to estimate
SAFETY = 1.25
FEW = 40  # contact points below which the mean displacement is an error that the preconditioner underrates
CREEP, EARLY = 0.25, 4.0  # of the mean gap
EDGE = 3  # points whose side is a matter of chance while errors are of the order of one point
SURE = 0.01  # expected number of points on the wrong side below which there is none


class Bpx(Solver):
    """The default solver. options: none. g: memory for the gap, taken over."""

    name = "bpx"
    takes_gap = True
    state_names = ("g", "p", "d")
    scalar_names = ("s", "rayleigh", "nearly", "contact", "gap_mean", "rz", "rd", "zq", "dq", "rr", "pp", "iterations")

    def __init__(self, problem, options=None, g=None):
        super().__init__(problem, options)
        self.options = read_options(self.name, self.options, {})
        grid, body, dtype = self.grid, problem.body, problem.dtype
        self.elastic = Elastic(grid, body, dtype)
        self.fft = self.elastic.fft
        self.levels = Multilevel(grid, body.weights(grid), dtype, self.fft.R)
        self.passes = self.levels.passes
        self.g = grid.empty(dtype) if g is None else g
        self.p, self.d = grid.empty(dtype), grid.empty(dtype)
        self.kap = 1.0 / body.scale(grid)
        self.gradient = 1.0 / (GRADIENT * self.kap * body.bounds(grid)[1])
        self._rows = {id(x): zeros_aligned((7, grid.n[1] + LINE // dtype.itemsize), dtype) for x in self.fft.row_scratch}
        self._number = {a: k for k, (a, _) in enumerate(self.passes)}
        self.problem = replace(problem, h_rms=problem.root_mean_square())  # once

    # -- starting ------------------------------------------------------------------------------------------------------------

    def start(self, g):
        if g is not self.g:
            self.g[...] = g
        self.p[...] = self.p_cell
        self.d[...] = 0
        self.elastic.pressure_rows(self.problem.displacement_rows(self.g), self.passes)
        self.elastic.pressure_columns(self.problem.adder(self.fft))
        self._begin(self._update(1.0))

    def refresh(self):
        self.d[...] = 0
        self._begin(self._update_still())

    def _begin(self, sums):
        """A new descent begins: no momentum, no memory of the Rayleigh quotient."""
        self.s = 1.0
        self.rayleigh, self.nearly = RHO_MAX, 0.0
        self._measure(sums)

    def load_state(self, arrays, numbers):
        super().load_state(arrays, numbers)
        self._update_still()
        self.levels.sweep()  # z on the coarse levels follows from g and p
        self._set_numbers(numbers)

    # -- one iteration -------------------------------------------------------------------------------------------------------

    def _touch(self):
        """Nothing is in contact: come down until something is. A rigid shift costs no elastic energy, but would take many steps.

        The descent goes on as it is: the pressure does not change.
        """
        rows, points = self.grid.inside
        lowest = self.grid.comm.min([self.g[:rows, :points].min(initial=np.inf)])[0]
        if 0 < lowest < np.inf:
            self.g -= self.problem.dtype.type(lowest)
            self.gap_mean -= lowest

    def step(self):
        if self.contact == 0:
            self._touch()
        a, b = self._coefficients()
        pd, clipped = self._propose(a, b, COUPLING)
        descent = a * self.rz + b * self.rd
        plain = not -pd > DESCENT * descent
        if plain:
            a, b = 0.0, 0.0
            pd, clipped = self._propose(self.gradient, 0.0, 0.0)
        free = not plain and abs(pd + descent) < CLIPPED * descent
        dKd = float(self.grid.comm.sum([self.elastic.pressure_columns()])[0])
        optimum = -pd / dKd if dKd > 0 else 1.0
        self.s = optimum if 0 < optimum < (1.0 if free else SHORT) else 1.0
        self.nearly = clipped if self.s < 1 else 0.0
        sums = self._update(self.s)

        if plain or not a * a * self.rz > 0:
            self.rayleigh = RHO_MAX
        else:
            zKz = dKd - 2 * a * b * self.zq - b * b * self.dq
            self.rayleigh = zKz / (a * a * self.rz)
        self._measure(sums)
        self.iterations += 1

    def _coefficients(self):
        """a and b of the step -(a z + b d): the minimum of the energy in the plane of z and d.

        It had better be too long than too short: where nothing is clipped the line search, which can only shorten it, then makes it
        the step of conjugate gradients.
        """
        rho = min(max(self.rayleigh, RHO_MIN), RHO_MAX)
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
        """First pass: the next step into d and its row spectra; returns <p, d> and clipped points."""
        t, real = self.levels.transfers[0], self.problem.dtype.type
        z = self.levels.z
        args = (real(self.kap), real(w), real(a), real(b * self.s))
        inside = self.grid.inside

        def fill(i0, i1, x):
            return propose(self.g, self.p, self.d, x, i0, i1, z, t.k0, t.f_x, t.mode, t.j0, t.f, *args, inside, self._rows[id(x)])

        return self.grid.comm.sum(np.sum(np.reshape(self.elastic.pressure_rows(fill, self.passes), (-1, 2)), axis=0)).tolist()

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
        rr, pp, pd, dx, px, contact, gap, _, rz1, xz1 = self.grid.comm.sum([*sums, rz1, xz1])
        s, kap = self.s, self.kap
        self.rz = kap * (rr + COUPLING * rz1)  # <p, z> on F
        self.rd = s * pd  # <p, d>
        self.zq = s * kap * (px + COUPLING * xz1)  # <z, K d>
        self.dq = s * s * dx  # <d, K d>
        self.rr, self.pp = rr, pp
        self.contact, self.gap_mean = contact, gap / self.N

    # -- how far -------------------------------------------------------------------------------------------------------------

    def progress(self):
        finite = bool(np.isfinite(self.pp + self.gap_mean))
        residual = np.sqrt(self.rr / self.N) / self.p0
        estimates = self._estimates() if finite else (np.inf, np.inf, np.inf)
        return Progress(float(residual), self.contact, self.gap_mean, estimates, finite)

    @property
    def rounding(self):
        """The rms error of the pressure that rounding makes."""
        return self.problem_now.rounding

    @property
    def pressure_rms(self):
        """What a relative error of the pressure field times this is at one point: errors are spread over the free points."""
        return float(np.sqrt(max(self.pp - self.rr, 0.0) / max(self.N - self.contact, 1)))

    def _estimates(self):
        """Relative errors of area, mean gap and pressure field, from the residual in the norm of the preconditioner.

        M is close to the inverse of K on the free points, so <p, M p> is the squared energy norm of the error and, over kap, nearly the
        squared L2 norm of the error of p. With e = sqrt(<p, M p>/(kap <p, p>_A)):

        pressure: e, times 1 + FEW/n_c where only a few points n_c are in contact, when all error is in the mean displacement;
        area: the share e of the contact is on the wrong side of its edge, and EDGE points, unless e n_c < SURE, and those that the last
        step would have closed had it not been made shorter;
        mean gap: sqrt(<p, M p>/(p0 <g>)), times (open area)^-1/4, because close to full contact it is not p0 that opens the gaps but
        less, times (1 + CREEP (open area))(1 + EARLY e): the first steps leave much of the slowest modes.

        Each is scaled by SAFETY. Rounding of the heights adds its share to e.
        """
        n_c, gap, closed = self.contact, self.gap_mean, self.pp - self.rr
        if n_c == 0 or closed <= 0:
            return np.inf, np.inf, np.inf
        e = np.sqrt(max(self.rz, 0.0) / (self.kap * closed))
        edge = EDGE / n_c if e * n_c > SURE else 0.0
        e = np.hypot(e, self.rounding * np.sqrt(n_c / closed))
        few = SAFETY * (1 + FEW / n_c)
        area = few * e + edge + self.nearly / n_c
        opened = 1 - n_c / self.N
        mean_gap = 0.0 if self.rr == 0 else np.inf
        if gap > 0:
            slow = opened**-0.25 * (1 + CREEP * opened) * (1 + EARLY * e)
            mean_gap = few * (np.sqrt(max(self.rz, 0.0) / (self.N * self.p0 * gap)) * slow + self.rounding * opened / gap)
        return float(area), float(mean_gap), float(few * e)
