"""Projected conjugate gradients in displacement space, one FFT pair per iteration.

The energy of equation (1) in docs/method.md is minimised over feasible gaps, preconditioned by the
locally damped multilevel operator (5). Each step minimises it in the plane of the preconditioned
residual z and the last step d; <z, K z>, which would cost a second FFT, is predicted from the last
Rayleigh quotient. The step is clipped to the feasible set and the energy along the chord minimised
exactly, so it never rises. Where clipping spoils the descent a plain projected gradient step is
made.

One iteration is three passes over memory: `search_passes` (projected step, row transforms), columns
with K, `update_passes` (row transforms, new state). With the gap g = u + h and p = p0 + K u a step
d changes them by d and K d: the displacement itself never appears.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from math import isfinite, sqrt

import numpy as np

from ..certificate.error_estimates import Estimate, StateSums, estimate, relative_error
from ..certificate.misclassified import misclassified_points, moments_of_open, spread_of
from ..kernels.bfloat16 import stored_dtype
from ..kernels.bpx import UpdateSums, add_step, search_passes
from ..operators.multilevel import Multilevel
from ..operators.problem import Problem
from ..parallel.threads import Shares
from .base import Progress, Solver

FIRST = 0.75  # Rayleigh quotient of first steps: 0.52 to 0.75 was seen; less makes them too long
# Share of the predicted descent that must remain after clipping. Measured: walls of pressures alike
# from .05 to .6; with an attraction 3 to 4 % fewer pairs below .2, 8 % more at .4
DESCENT = 0.2
# Share of the shift of certificate/error_estimates.py that predicts the mean gap. Chosen: gaps as
# loads take 10.3 to 10.9 pairs from .3 to .75, 12.6 at 0 and 12.1 at 1
SHIFT = 0.62


class Bpx(Solver):
    """The default solver, preconditioned projected conjugate gradients; without options.

    d: last step of the gap, as in kernels/bfloat16.py, of which the share s was made; rr, pp: <r,
    r>, <p, p>, r being p out of elastic contact (less the hardness where points yield), else 0;
    mean: of r over the grid; rz, rd, zKd, dKd: products of r, z = M r and s d; rayleigh: <z, K
    z>/<r, z> of the last step; level_sums: last five sums of Multilevel.sweep. All over all ranks.
    """

    name = "bpx"
    sources = (
        "Bramble, Pasciak, Xu, Math. Comp. 55 (1990) 1, doi:10.1090/S0025-5718-1990-1023042-6",
    )
    dents = attracts = goes_ahead = True

    def __init__(
        self, problem: Problem, options: dict[str, float] | None = None, g: np.ndarray | None = None
    ):
        super().__init__(problem, options, g)
        self.levels = Multilevel(self.grid, problem.body, problem.dtype, self.elastic.fft.R)
        self.d = self.grid.empty(stored_dtype(problem.dtype))
        self.compliance = float(1.0 / problem.body.scale(self.grid))  # of the shortest wave

    @cached_property
    def gradient(self) -> float:
        """Coefficient a of a plain projected gradient step, d = -a z with z = compliance r."""
        return 1.0 / (self.compliance * self.problem.body.bounds(self.grid)[1])

    @contextmanager
    def room(self) -> Iterator[None]:
        del self.d
        self.elastic.make_room()
        yield
        self.elastic.plan()
        self.d = self.grid.empty(stored_dtype(self.problem.dtype))
        self.d[...] = 0
        self.rd = self.zKd = self.dKd = 0.0

    # -- starting

    def start(self, g: np.ndarray) -> None:
        """Begin at the gap g >= 0 (local slab, copied) by one FFT pair, plus those of the gap mode;
        with a hardness the body may move or dent. Collective.
        """
        self._lay(g)
        state = self.state
        self.problem.transform_displacement(self.elastic.fft, state.g)
        uKu = self.elastic.columns(add=self.problem.adder(self.elastic.fft))
        state.uKu = float(self.grid.comm.sum([uKu])[0])
        # the rows are those of K u: no step has changed the attraction
        limit = self.wall.limit
        self.elastic.pairs += 1
        sums = self.levels.update(state.g, state.p, self.d, 1.0, self.elastic.fft.rows, limit)
        if self.wall.add_traction(state):
            sums = self._restrict()
        self._begin(sums)

    def restart(self) -> None:
        """Forget the last step and begin again at the state, without an FFT but for the gap mode.
        Collective.
        """
        self.d[...] = 0
        self._begin(self._restrict())

    def after_stability(self) -> None:
        """Compute z on the coarse levels again, after `stability_of`; keep the last step."""
        self._restrict()
        self.levels.sweep()  # z on the coarse levels follows from g and p

    def _begin(self, sums: UpdateSums) -> None:
        """Begin a new descent without a last step. Collective; the gap mode may take FFT pairs.

        The caller has set self.d to 0 and put the state on the levels (`levels.update` or
        `restrict`), which returned `sums` of this rank. With a hardness and no attraction the body
        may be moved or dented as a whole.
        """
        self.s = 1.0
        self.rayleigh = FIRST
        self._measure(sums, new_contact=True)
        if self.wall.undeform(self.state):
            self.d[...] = 0
            self._measure_again()
        a, b = self._coefficients()
        self._balance(0.5 * (a * self.rz + b * self.rd))

    # -- one iteration

    def step(self) -> None:
        """Make one iteration, with one FFT pair, in place. Collective. A body that touches nowhere
        is lowered first; springs change p0, and a hardness may shift the body.
        """
        if self.contact == 0:
            self._lower()
        state = self.state
        a, b, (pd, deeper, td, gained) = self._choose_step()
        spring = self.problem.spring
        dKd = self.elastic.columns(spring=spring)
        dKd, mean = self.grid.comm.sum([dKd, self.elastic.mean]).tolist()
        self.s = self.wall.step_length(pd, dKd, td, gained)
        before = self.rz, self.zKd, self.dKd
        # with a hardness the elastic contact may have become another one by a plain step
        sums = self._measure(self._update(self.s), new_contact=a == 0 and self.wall.yields)
        state.attracted = sums.attraction
        self.rayleigh = _rayleigh_quotient(a, b, dKd + sums.stiffening, *before)
        # K u = p - t - p_cell, and pd has the work of dents
        Kud = pd - td - self.wall.hardness * deeper - state.p_cell * self.grid.cell_points * mean
        of_spring = spring * self.grid.cell_points * mean**2
        state.uKu += 2 * self.s * Kud + self.s**2 * (dKd - of_spring)
        state.p0 += spring * self.s * mean * (self.grid.cell_points / self.N)
        self._balance(-self.s * (pd + 0.5 * self.s * dKd))
        self.iterations += 1

    def step_ahead(self) -> None:
        self._choose_step(transforms=False)
        g = self.state.g
        self.grid.by_rows(lambda i0, i1: add_step(g[i0:i1], self.d[i0:i1]))
        self.iterations += 1

    def _lower(self) -> None:
        """Lower a body until it touches; a new descent begins if p changes. Collective."""
        by, changes_pressure = self.wall.lower(self.state)
        self.gap_mean -= by
        if changes_pressure:
            self.restart()

    def _choose_step(self, transforms: bool = True) -> tuple[float, float, list[float]]:
        """Write the projected step -(a z + b d) to self.d, transform its rows, return a, b and
        `_search`'s sums; plain projected gradient with a = b = 0 if too little descent is left.
        """
        a, b = self._coefficients()
        work = self._search(a, b, 1.0, transforms)
        descent = a * self.rz + b * self.rd
        gained = -work[0]
        # at full contact there is nothing to descend
        while self.wall.yields and descent > 0 and not gained > DESCENT * descent:
            # a parabola through what was predicted at the start and what came out
            a *= 0.5 * descent / (descent - gained)
            b = 0.0
            if not a * self.rz > self.gradient * self.compliance * self.rr:
                break  # a plain step gains more
            work = self._search(a, b, 1.0, transforms)
            descent = a * self.rz
            gained = -work[0]
        if gained > DESCENT * descent:
            return a, b, work
        return 0.0, 0.0, self._search(self.gradient, 0.0, 0.0, transforms)

    def _balance(self, descent: float) -> None:
        """Let a wall with a hardness shift the body (HardWall.balance), forgetting the last step;
        `descent`: gained by it. Collective.
        """
        if self.wall.balance(self.state, self.contact, self.yielded, descent):
            self._measure_again()

    def _coefficients(self) -> tuple[float, float]:
        """Return a, b of the step -(a z + b d) of least energy, with <z, K z> by the last Rayleigh
        quotient, d being s times self.d; b is 0 without a last step, a if z is 0.
        """
        rho = self.rayleigh if self.rayleigh > 0 else 1.0
        rz, rd, zKd, dKd = self.rz, self.rd, self.zKd, self.dKd
        zKz = rho * rz
        if dKd <= 0 or rz <= 0:
            return (rz / zKz if rz > 0 else 0.0), 0.0
        # zKd^2/(zKz dKd), a squared cosine, is below 1; the predicted zKz may break that
        if zKz * dKd - zKd * zKd < 0.1 * zKz * dKd:
            zKz = zKd * zKd / (0.9 * dKd)
        det = zKz * dKd - zKd * zKd
        a = (rz * dKd - rd * zKd) / det
        b = (zKz * rd - zKd * rz) / det
        return (a, b) if a > 0 else (1.0 / rho, 0.0)

    def _search(self, a: float, b: float, coupling: float, transforms: bool = True) -> list[float]:
        """Overwrite self.d with the projected step -(a z + b d), and transform its rows.
        Collective.

        coupling = 0 leaves the coarse levels out of z, else `_measure` must have swept them.
        Returns sums over all ranks: <p, d> with the work of dents; deepening of dents; <t, d> and
        the change of phi (0 without an attraction, kernels/adhesive_rows.py).
        """
        levels = self.levels
        fft = self.elastic.fft
        ends = levels.ends
        step = tuple(self.problem.dtype.type(x) for x in (a, b * self.s, coupling, self.compliance))
        fields = self.state.g, self.state.p, self.d, levels.z, levels.transfers[0].tables
        limits = self.wall.limit, self.grid.inside, self.wall.law
        sums = np.zeros((len(ends), 2))
        work = np.zeros((len(ends), 2))

        shares = Shares(len(ends), fft.threads)

        def passes(thread: int) -> None:
            scratch = fft.rows[thread], tuple(levels.scratch[thread][0][:2]), sums
            steps = *fields, step, *limits, work, transforms
            search_passes(ends, shares.parts, shares.turns, *scratch, *steps)

        shares.on_threads(passes, range(fft.threads))
        return self.grid.comm.sum([*np.sum(sums, axis=0), *np.sum(work, axis=0)]).tolist()

    def _update(self, s: float) -> UpdateSums:
        """Add s d to g and s K d (with an attraction s y) to p from the spectra of K d; return this
        rank's UpdateSums. Puts r and t on the levels, counts an FFT pair.
        """
        self.elastic.pairs += 1
        fields = self.state.g, self.state.p, self.d, s, self.elastic.fft.rows, self.wall.limit
        return self.levels.update(*fields, law=self.wall.law)

    def _restrict(self) -> UpdateSums:
        """Put r and t of the state on the levels; return this rank's UpdateSums."""
        return self.levels.restrict(self.state.g, self.state.p, self.wall.limit)

    def _measure_again(self) -> None:
        """Put the state on the levels and measure it, with a new contact. Collective."""
        self._measure(self._restrict(), new_contact=True)

    def _measure(self, sums: UpdateSums, new_contact: bool = False) -> UpdateSums:
        """Sweep the levels to z, set what the next step and `progress` need, and return sums over
        all ranks. Collective. new_contact: compute the gap mode first (FFT pairs); `sums`: this
        rank's, of the state on the levels.
        """
        share = None
        if new_contact:
            elastic = self.grid.comm.sum([sums.contact - sums.yielded])[0]
            share = float(elastic / self.grid.cell_points)
        totals = self.grid.comm.sum([*sums, *self.levels.sweep(share)]).tolist()
        rz1, xz1, self.mean, *self.level_sums = totals[len(sums) :]
        sums = UpdateSums(*totals[: len(sums)])
        s = self.s
        self.rz = self.compliance * (sums.rr + rz1)  # <p, z> on F
        self.rd = s * sums.rd  # <p, d>
        self.zKd = s * self.compliance * (sums.rKd + xz1)
        self.dKd = s * s * sums.dKd
        self.rr = sums.rr
        self.pp = sums.pp
        self.contact = sums.contact
        self.gap_mean = sums.gap / self.N
        self.yielded = sums.yielded
        if share is not None and self.levels.gap_mode.wanted(share):
            self.elastic.pairs += self.levels.gap_mode.pairs
        return sums

    # -- how far

    @property
    def is_separated(self) -> bool:
        """Whether nothing touches and the wall does not hold the body any more."""
        return self.contact == 0 and self.wall.has_let_go(self.state.wall_load)

    def progress(self, with_errors: bool = True) -> Progress:
        """Return how far the state is from the solution, with estimates after every step."""
        finite = isfinite(self.pp + self.gap_mean)
        # infinite where the attraction pulls more than it holds
        residual = sqrt(self.rr / self.N) / max(self.state.wall_load, sys.float_info.min)
        if not with_errors:
            return Progress(residual, self.contact, self.gap_mean, None, finite)
        errors = self._estimate() if finite else Estimate()
        predicted = self._predicted(errors) if finite else None
        return Progress(residual, self.contact, self.gap_mean, errors, finite, predicted)

    def _estimate(self) -> Estimate:
        """Estimate a certificate's errors by the last step; blind to accumulated rounding."""
        state = self.state
        sums = StateSums(
            p0=state.wall_load,
            open_p=self.mean * self.grid.cell_points,
            open_pp=self.rr,
            closed_pp=self.pp - self.rr,
            contact=self.contact,
            yielded=self.yielded,
            gap=self.gap_mean * self.N,
            uKu=state.uKu,
            level_sums=self.level_sums,
        )
        stability = 1.0 if state.stability is None else state.stability.lowest
        return estimate(self.problem, self.levels, state.g, sums, stability)

    def _predicted(self, errors: Estimate) -> tuple[float, float] | None:
        """Predict contact points and mean gap of the solution, or None: the contact grows in
        proportion until it carries the load (self.mean is missing), the gap changes by the share
        SHIFT of `errors.shift`/N.
        """
        # the mean pressure of the wall over the whole grid
        carried = self.state.p_cell + self.state.attracted / self.grid.cell_points
        n = self.contact
        load = carried - self.mean
        if n == 0 or load <= 0:
            return None
        if n == self.N:
            return n, self.gap_mean
        gap = self.gap_mean + SHIFT * errors.shift / self.N
        return min(n * carried / load, self.N), gap

    def expected_area(self, estimate: Estimate) -> float:
        """Takes two passes over all points, no FFT."""
        fields = self.state.g, self.state.p
        open_pp, open_p4 = self.grid.comm.sum(moments_of_open(self.problem, *fields))
        spread = spread_of(open_pp, open_p4, self.contact, self.N)
        wrong = misclassified_points(self.problem_now, *fields, estimate, spread, self.contact)
        if self.wall.yields and self.contact == self.N and wrong > 0:
            return np.inf  # a point that may be open is a gap that is not known
        return relative_error(wrong, self.contact)


def _rayleigh_quotient(
    a: float, b: float, dKd: float, rz: float, zKd: float, dKd_before: float
) -> float:
    """Return <z, K z>/<r, z> from the new step's <d, K d> and products before; 1 if unknown."""
    if not a * a * rz > 0:
        return 1.0
    zKz = dKd - 2 * a * b * zKd - b * b * dKd_before
    quotient = zKz / (a * a * rz)
    return quotient if isfinite(quotient) else 1.0  # of the last bits of a closed contact
