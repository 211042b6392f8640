"""Projected conjugate gradients in displacement space, one FFT pair per iteration.

Preconditioned by the locally damped multilevel operator of `multilevel.py`. Each step minimises the
energy in the plane of the preconditioned residual z and the last step d; <z, K z>, which would cost
a second FFT, is predicted from the Rayleigh quotient of the last step. The step is clipped to the
feasible set, and the energy along the (feasible) chord is minimised exactly, so it never rises.
Where clipping spoils the descent the step is replaced by a plain projected gradient step.

One iteration is three passes over memory: `search_passes` (projected step, row transforms), column
transforms with K between them, `update_passes` (row transforms, new state). The displacement itself
never appears: with the gap g = u + h and p = p0 + K u, a step d changes them by d and by K d.
"""

from functools import cached_property

import numpy as np

from ..certificate.error_estimates import (
    Estimate,
    State,
    estimate,
    misclassified_points,
    moments_of_open,
    relative_error,
    spread_of,
)
from ..kernels.bfloat16 import stored_dtype
from ..kernels.bpx import UpdateSums, search_passes
from ..operators.multilevel import Multilevel
from ..operators.problem import Problem
from ..parallel.threads import on_threads, shares
from .base import Progress, Solver

FIRST = 0.75  # Rayleigh quotient of first steps: 0.52 to 0.75 was seen; less makes them too long
DESCENT = 0.2  # share of the predicted descent that clipping must leave
SHORT = 0.9  # a step is made shorter only below this: clipped points stay a little open then
# of what certificate/error_estimates.py says that the mean gap is wrong by
SHIFT = 0.62


class Bpx(Solver):
    """The default solver. options: none. g: memory for the gap, taken over."""

    name = "bpx"
    sources = (
        "Bramble, Pasciak, Xu, Math. Comp. 55 (1990) 1, doi:10.1090/S0025-5718-1990-1023042-6",
    )
    dents = True

    def __init__(
        self, problem: Problem, options: dict[str, float] | None = None, g: np.ndarray | None = None
    ):
        super().__init__(problem, options, g)
        grid, body, dtype = self.grid, problem.body, problem.dtype
        self.levels = Multilevel(grid, body, dtype, self.elastic.fft.R)
        self.d = grid.empty(stored_dtype(dtype))
        self.compliance = 1.0 / body.scale(grid)  # of the shortest wave

    @cached_property
    def gradient(self) -> float:
        """The length of a projected gradient step."""
        return 1.0 / (self.compliance * self.problem.body.bounds(self.grid)[1])

    def make_room(self) -> None:
        del self.d
        self.elastic.make_room()

    def take_room(self) -> None:
        self.elastic.plan()
        self.d = self.grid.empty(stored_dtype(self.problem.dtype))
        self.d[...] = 0
        self.rd = self.zKd = self.dKd = 0.0

    # -- starting

    def start(self, g: np.ndarray) -> None:
        self._lay(g)
        self.elastic.pressure_rows(
            self.problem.displacement_rows(self.g, self.problem.level(self.g))
        )
        self.uKu = float(
            self.grid.comm.sum(
                [self.elastic.pressure_columns(self.problem.adder(self.elastic.fft))]
            )[0]
        )
        self._begin(self._update(1.0))

    def refresh(self, uKu: float | None = None) -> None:
        self.uKu = self.uKu if uKu is None else uKu
        self.d[...] = 0
        self._begin(self.levels.restrict(self.g, self.p, self.problem.limit))

    def _begin(self, sums: UpdateSums) -> None:
        """Begin a new descent: no momentum, a Rayleigh quotient as first steps have."""
        self.s = 1.0
        self.rayleigh = FIRST
        self._measure(sums, anew=True)
        if self.levels.gap_mode.wanted((self.contact - self.yielded) / self.grid.cell_points):
            self.elastic.pairs += self.levels.gap_mode.pairs

    # -- one iteration

    def _descend_to_contact(self) -> None:
        """Come down until something is in contact, where nothing is. A rigid shift costs no elastic
        energy, but would take many steps.

        The descent goes on as it is: the pressure does not change.
        """
        rows, points = self.grid.inside
        lowest = self.grid.comm.min([self.g[:rows, :points].min(initial=np.inf)])[0]
        if 0 < lowest < np.inf:
            self.g -= self.problem.dtype.type(lowest)
            self.gap_mean -= lowest

    def step(self) -> None:
        if self.contact == 0:
            self._descend_to_contact()
        a, b = self._coefficients()
        pd, deeper = self._search(a, b, 1.0)
        descent = a * self.rz + b * self.rd
        plain = not -pd > DESCENT * descent
        if plain:
            a, b = 0.0, 0.0
            pd, deeper = self._search(self.gradient, 0.0, 0.0)
        dKd = self.elastic.pressure_columns()
        dKd, mean = self.grid.comm.sum([dKd, self.elastic.mean]).tolist()
        optimum = -pd / dKd if dKd > 0 else 1.0
        self.s = optimum if 0 < optimum < SHORT else 1.0
        sums = self._update(self.s)

        if plain or not a * a * self.rz > 0:
            self.rayleigh = 1.0
        else:
            zKz = dKd - 2 * a * b * self.zKd - b * b * self.dKd
            self.rayleigh = zKz / (a * a * self.rz)
        self._measure(sums)
        # K u = p - p_cell
        self.uKu += 2 * self.s * (pd - self.p_cell * self.grid.cell_points * mean) + self.s**2 * dKd
        if self.problem.hardness is not None:  # pd has the work of dents
            self.uKu -= 2 * self.s * self.problem.hardness * deeper
        self.iterations += 1

    def _coefficients(self) -> tuple[float, float]:
        """Return a and b of the step -(a z + b d): the minimum of the energy in the plane of z and
        d, if z has the Rayleigh quotient of the last one."""
        rho = self.rayleigh if self.rayleigh > 0 else 1.0
        rz, rd, zKd, dKd = self.rz, self.rd, self.zKd, self.dKd
        zKz = rho * rz
        if dKd <= 0 or rz <= 0:
            return (rz / zKz if rz > 0 else 0.0), 0.0
        if zKz * dKd - zKd * zKd < 0.1 * zKz * dKd:
            zKz = zKd * zKd / (0.9 * dKd)
        det = zKz * dKd - zKd * zKd
        a = (rz * dKd - rd * zKd) / det
        b = (zKz * rd - zKd * rz) / det
        return (a, b) if a > 0 else (1.0 / rho, 0.0)

    def _search(self, a: float, b: float, coupling: float) -> list[float]:
        """Make the first pass: the next step into d, and its row spectra; returns <p, d>, and by
        how much dents become deeper."""
        levels, fft, ends = self.levels, self.elastic.fft, self.levels.ends
        step = tuple(self.problem.dtype.type(x) for x in (a, b * self.s, coupling, self.compliance))
        tables, last = levels.transfers[0].tables, (self.problem.limit, self.grid.inside)
        args = self.g, self.p, self.d, levels.z, tables, step, *last
        found = np.zeros((len(ends), 2))

        def some(k0: int, k1: int, thread: int) -> None:
            own = fft.rows[thread], levels.scratch[thread][0], found
            search_passes(ends, k0, k1, *own, *args)

        parts = shares(len(ends), fft.threads)
        on_threads(fft.threads, some, parts, range(fft.threads))
        return self.grid.comm.sum(np.sum(found, axis=0)).tolist()

    def _update(self, s: float) -> UpdateSums:
        """Make the last pass: x = K d by rows, new g and p; returns this rank's UpdateSums."""
        self.elastic.pairs += 1
        rows = self.elastic.fft.rows
        return self.levels.update(self.g, self.p, self.d, s, rows, self.problem.limit)

    def _measure(self, sums: UpdateSums, anew: bool = False) -> None:
        """Sweep the levels and sum over ranks: all scalars of the next step and of the stopping
        rule. anew: a descent begins."""
        totals = self.grid.comm.sum([*sums, *self.levels.sweep(anew)]).tolist()
        rz1, xz1, self.mean, *self.level_sums = totals[len(sums) :]
        sums = UpdateSums(*totals[: len(sums)])
        s, compliance = self.s, self.compliance
        self.rz = compliance * (sums.rr + rz1)  # <p, z> on F
        self.rd = s * sums.rd  # <p, d>
        self.zKd = s * compliance * (sums.rKd + xz1)
        self.dKd = s * s * sums.dKd
        self.rr, self.pp = sums.rr, sums.pp
        self.contact, self.gap_mean = sums.contact, sums.gap / self.N
        self.changing = max(sums.opening, sums.closing)
        self.yielded = sums.yielded

    # -- how far

    def progress(self) -> Progress:
        finite = bool(np.isfinite(self.pp + self.gap_mean))
        residual = np.sqrt(self.rr / self.N) / self.p0
        found = self._estimate() if finite else Estimate()
        predicted = self._predicted(found) if finite else None
        return Progress(float(residual), self.contact, self.gap_mean, found, finite, predicted)

    def _estimate(self) -> Estimate:
        """Estimate what the certificate will say, but for rounding errors that p has gathered."""
        state = State(
            self.p0,
            self.mean * self.grid.cell_points,
            self.rr,
            self.pp - self.rr,
            self.contact,
            self.yielded,
            self.gap_mean * self.N,
            self.uKu,
            self.level_sums,
        )
        return estimate(self.problem, self.levels, state)

    def _predicted(self, found: Estimate) -> tuple[float, float] | None:
        """Predict the converged area and gap: the area goes with the load that the contact
        carries."""
        load, n = self.p_cell - self.mean, self.contact
        if n == 0 or load <= 0:
            return None
        if n == self.N:
            return n, self.gap_mean
        gap = self.gap_mean + SHIFT * found.shift / self.N
        return min(n * self.p_cell / load, self.N), gap

    def expected_area(self, squares: float) -> float:
        open_pp, open_p4 = self.grid.comm.sum(moments_of_open(self.problem, self.g, self.p))
        spread = spread_of(open_pp, open_p4, self.contact, self.N)
        wrong = misclassified_points(self.problem, self.g, self.p, squares, spread)
        return relative_error(max(wrong, self.changing), self.contact)
