"""What a solver is.

A solver allocates everything in __init__(problem, options), is given a start by `start(g)` or
`continue_at(p0)`, and then does one step at a time. It owns the gap g and the pressure p (local
slabs). After every step `progress()` tells how far it is. It knows nothing of stopping, files or
clocks: that is `drive.py`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..operators.elastic import Elastic
from .options import read_options

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..certificate.error_estimates import Estimate
    from ..certificate.stability import Stability
    from ..operators.multilevel import Multilevel
    from ..operators.problem import Problem


@dataclass(frozen=True)
class Progress:
    """How far a solver is, the same numbers on every rank.

    Attributes
    ----------
    residual : float
        sqrt(mean p^2 where the gap is open), over the mean pressure that the wall bears.
    contact : float
        Points that touch: g <= 0 and p > 0.
    gap_mean : float
        In the problem's units.
    estimate : Estimate, or None
        What the certificate is expected to find; None after a step in which that was not
        estimated.
    finite : bool
        Whether all numbers are.
    predicted : pair of float, or None
        The points in contact and the mean gap that the solution at this load is expected to have;
        None where the solver does not know.
    """

    residual: float
    contact: float
    gap_mean: float
    estimate: Estimate | None
    finite: bool = True
    predicted: tuple[float, float] | None = None

    @property
    def estimates(self) -> tuple[float, float] | None:
        """The relative errors of (mean gap, pressure) of `estimate`."""
        return self.estimate and self.estimate[:2]


class Solver:
    """What all solvers share.

    To add one, put a file into solvers/ with a subclass whose `name` is the file's; it implements
    `start`, `refresh`, `step` and `progress`. Its methods are collective.

    Parameters
    ----------
    problem : Problem
        What is solved.
    options : dict, optional
        Numbers by their names, see `allowed`.
    g : ndarray, optional
        Memory for the gap, local slab of the grid, which is taken over.

    Raises
    ------
    SceneError
        For options that are not allowed.

    Attributes
    ----------
    g, p : array, local slabs
        Gap >= 0, but where there is a dent, and pressure, in the problem's units and precision.
    p0 : float
        The present mean pressure.
    iterations : int
        Steps since the load began.
    uKu : float
        <u, K u> where the solver was started; of one that keeps it up to date at any time.
    allowed : dict
        The smallest and largest value of each option.
    sources : tuple of str
        Papers that the algorithm is from, with DOI.
    """

    d: np.ndarray  # the last step, of those that have one
    name = ""
    sources: tuple[str, ...] = ()
    uKu: float
    allowed: Mapping[str, tuple[float, float]] = {}
    dents = False  # whether it can do with a hardness
    attracts = False  # whether it can do with an attraction
    stability: Stability | None = None  # of the state with an attraction, as found last
    patience = 60  # iterations without progress after which the solver counts as stagnated

    def __init__(
        self, problem: Problem, options: dict[str, float] | None = None, g: np.ndarray | None = None
    ):
        self.options = read_options(self.name, options or {}, self.allowed)
        self.problem = problem
        self.grid = problem.grid
        self.p0 = float(problem.p0)
        self.N = problem.grid.N
        self.iterations = 0
        self.elastic = Elastic(self.grid, problem.body, problem.dtype)
        self.g = self.grid.empty(problem.dtype) if g is None else g
        self.p = self.grid.empty(problem.dtype)

    @property
    def pairs(self) -> float:
        """FFT pairs done on this grid so far."""
        return self.elastic.pairs

    def reset_counts(self) -> None:
        """Count iterations and FFT pairs from 0: a load begins."""
        self.iterations = 0
        self.elastic.pairs = 0.0

    @cached_property
    def levels(self) -> Multilevel:
        """The multilevel operator on this grid, made when the certificate first asks for it."""
        from ..operators.multilevel import Multilevel

        return Multilevel(self.grid, self.problem.body, self.problem.dtype, self.elastic.fft.R)

    @property
    def problem_now(self) -> Problem:
        """The problem at the present load."""
        return replace(self.problem, p0=self.p0, h_rms=self.problem.root_mean_square)

    @property
    def wall_load(self) -> float:
        """The mean pressure that the wall bears: p0, and what an attraction adds."""
        return self.p0

    @property
    def p_cell(self) -> float:
        """The mean pressure over the whole grid at the present load."""
        return self.p0 * (self.grid.N / self.grid.cell_points)

    def start(self, g: np.ndarray) -> None:
        """Begin at the gap g >= 0 (local slab, taken over)."""
        raise NotImplementedError

    def continue_at(self, p0: float) -> None:
        """Begin from the present state at another mean pressure, without an FFT: p changes by a
        constant."""
        before = self.p_cell
        self.p0 = float(p0)
        change = self.problem.dtype.type(self.p_cell - before)

        def shift(i0: int, i1: int) -> None:
            self.p[i0:i1] += change

        self.grid.by_rows(shift)
        self.refresh()

    def _lay(self, g: np.ndarray) -> None:
        """Set the gap to g, the last step to 0 and the pressure to its mean over the cell."""

        def lay(i0: int, i1: int) -> None:
            if g is not self.g:
                self.g[i0:i1] = g[i0:i1]
            self.p[i0:i1] = self.p_cell
            self.d[i0:i1] = 0

        self.grid.by_rows(lay)

    def refresh(self, uKu: float | None = None) -> None:
        """Go on without a last step, after self.p has been computed anew from self.g, or shifted,
        and self.levels used by somebody else. uKu: <u, K u>, None if that has not changed."""
        raise NotImplementedError

    @property
    def is_separated(self) -> bool:
        """Whether the bodies have come apart, for good: nothing touches, and the load pulls more
        than the attraction."""
        return False

    def begin_at(self, certificate: Certificate) -> None:
        """Begin where a certificate has computed self.p from self.g."""
        self.refresh(certificate.uKu)

    def after_certificate(self, certificate: Certificate) -> None:
        """Go on after the certificate has computed self.p anew from self.g, and used
        self.levels."""
        self.begin_at(certificate)

    def after_stability(self) -> None:
        """Go on after the search for the stability has used self.levels."""
        self.refresh()

    def make_room(self) -> None:
        """Give the memory of the transforms and of the last step, which is lost, to somebody else
        until `take_room`."""
        raise NotImplementedError

    def take_room(self) -> None:
        """Go on without a last step."""
        raise NotImplementedError

    def step(self) -> None:
        """Make one iteration: new g and p."""
        raise NotImplementedError

    def progress(self) -> Progress:
        """Return how far the solver is."""
        raise NotImplementedError

    def estimate_errors(self) -> Estimate:
        """Estimate what the certificate would find, from g and p without an FFT: one pass over
        memory and a sweep over the levels. Collective.

        For solvers that do not have these sums from their steps anyway.
        """
        from ..certificate.error_estimates import State, estimate

        sums = self.levels.restrict(self.g, self.p, self.problem.limit)
        level_sums = self.levels.sweep()
        uKu = sum(self.grid.by_rows(self._work_of_pressure))
        count = len(sums)
        totals = self.grid.comm.sum([*sums, *level_sums, uKu]).tolist()
        totals_of_points = type(sums)(*totals[:count])
        _, _, mean, *products, uKu = totals[count:]
        state = State(
            self.p0,
            mean * self.grid.cell_points,
            totals_of_points.rr,
            totals_of_points.pp - totals_of_points.rr,
            totals_of_points.contact,
            totals_of_points.yielded,
            totals_of_points.gap,
            uKu,
            products,
        )
        return estimate(self.problem, self.levels, self.g, state)

    def _work_of_pressure(self, i0: int, i1: int) -> float:
        """Return <u, p - p_cell> = <u, K u> on rows i0..i1; heights have to be stored."""
        rows, points = self.grid.inside
        u = self.g[i0:i1].astype(np.float64)
        inner = max(min(rows, i1) - i0, 0)
        u[:inner, :points] -= self.problem.heights[i0 : i0 + inner]
        return float(np.vdot(u, self.p[i0:i1].astype(np.float64) - self.p_cell))

    def expected_area(self, estimate: Estimate) -> float:
        """Return the relative error of the area that the certificate is expected to find beside an
        Estimate."""
        return 0.0
