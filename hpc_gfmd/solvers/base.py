"""What a solver is.

A solver allocates everything in __init__(problem, options), begins with `start(g)`, later perhaps
with `continue_at(p0)`, and then does one step at a time, which improves its `state`
(operators/state.py). After every step `progress()` measures how far it is from the solution. When
to stop, files and clocks are not its business: that is `drive.py`.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..operators.elastic import Elastic
from ..operators.state import State
from ..operators.wall import wall_of
from .options import read_options

if TYPE_CHECKING:
    from ..certificate.error_estimates import Estimate
    from ..operators.multilevel import Multilevel
    from ..operators.problem import Problem


@dataclass(frozen=True)
class Progress:
    """How far the state of a solver is from the solution. The same on every rank; immutable.

    Attributes
    ----------
    residual : float
        Root mean square of the pressure out of contact (0 at points in contact), over the mean
        pressure that the wall bears.
    contact : float
        Number of points in contact on all ranks: g <= 0 and p > 0.
    gap_mean : float
        Mean gap over the surface, in the problem's units; dents count as 0.
    estimate : Estimate, or None
        The errors that a certificate of this state would probably find; None if the solver has
        not estimated them in this step.
    finite : bool
        Whether gap and pressure are finite everywhere.
    predicted : pair of float, or None
        Number of points in contact and mean gap that the converged solution at this load will
        probably have; None if the solver cannot predict them.
    """

    residual: float
    contact: float
    gap_mean: float
    estimate: Estimate | None
    finite: bool = True
    predicted: tuple[float, float] | None = None

    @property
    def estimates(self) -> tuple[float, float] | None:
        """Estimated relative errors of (mean gap, pressure field); None without an `estimate`."""
        return self.estimate and self.estimate[:2]

    def reduced(self, factor: float) -> Progress:
        """Return the progress with errors so many times smaller, as after steps still to come."""
        return replace(self, estimate=self.estimate and self.estimate.reduced(factor))


class Solver:
    """Base class of all solvers: a state and the steps that improve it.

    To add a solver, put a file into solvers/ with a subclass whose `name` is that of the file. It
    implements `start`, `restart`, `step` and `progress`. Creating a solver and calling its methods
    is collective; all of them return the same on all ranks, unless stated otherwise.

    Parameters
    ----------
    problem : Problem
        The contact to solve.
    options : dict, optional
        Values of options by name, within the limits of `allowed`.
    g : ndarray, optional
        Array to use as the memory of the gap, local slab of the grid; its values are not read.
        New memory is allocated without it.

    Raises
    ------
    SceneError
        If an option is unknown or its value is not allowed.

    Attributes
    ----------
    state : State
        Gap, pressure and load, in the problem's units and precision.
    iterations : int
        Number of steps since the load began.
    N : int
        Number of points of the surface.
    wall : Wall
        What the wall allows and bears.
    elastic : Elastic
        Applies K; has the transforms, and counts their pairs.
    patience : int
        Iterations without progress after which the loop counts the solver as stagnated.
    dents, attracts : bool
        Whether it can solve contacts with a hardness, and with an attraction.
    goes_ahead : bool
        Whether it has `step_ahead`.
    d : array, local slab
        The last step, in solvers that store one.
    allowed : dict
        The smallest and largest value of each option, by name.
    sources : tuple of str
        Papers that introduced the algorithm, with DOI.
    """

    d: np.ndarray
    name = ""
    sources: tuple[str, ...] = ()
    allowed: Mapping[str, tuple[float, float]] = {}
    dents = False
    attracts = False
    goes_ahead = False
    patience = 60

    def __init__(
        self, problem: Problem, options: dict[str, float] | None = None, g: np.ndarray | None = None
    ):
        self.options = read_options(self.name, options or {}, self.allowed)
        self.problem = problem
        self.wall = wall_of(problem)
        self.grid = problem.grid
        self.N = problem.grid.N
        self.iterations = 0
        self.elastic = Elastic(self.grid, problem.body, problem.dtype)
        g = self.grid.empty(problem.dtype) if g is None else g
        p = self.grid.empty(problem.dtype)
        self.state = State(self.grid, g, p, float(problem.p0))

    @property
    def pairs(self) -> float:
        """FFT pairs of the starts and steps since `reset_counts`, without those of certificates."""
        return self.elastic.pairs

    def reset_counts(self) -> None:
        """Set `iterations` and `pairs` to 0, at the beginning of a load."""
        self.iterations = 0
        self.elastic.pairs = 0.0

    @cached_property
    def levels(self) -> Multilevel:
        """The multilevel operator on this grid, made at first access (then collective) and kept."""
        from ..operators.multilevel import Multilevel

        return Multilevel(self.grid, self.problem.body, self.problem.dtype, self.elastic.fft.R)

    @property
    def problem_now(self) -> Problem:
        """A copy of the problem at the present p0 with the same heights. Collective at first."""
        return replace(self.problem, p0=self.state.p0, h_rms=self.problem.root_mean_square)

    def start(self, g: np.ndarray) -> None:
        """Begin at a gap and the present p0: set gap, pressure, <u, K u> and attraction. Takes
        one FFT pair.

        Parameters
        ----------
        g : array, local slab
            The gap, >= 0. It is copied into that of the state, unless it is the same array.
        """
        raise NotImplementedError

    def continue_at(self, p0: float) -> None:
        """Set the mean pressure to p0 and go on from the present gap, without an FFT. Collective.

        The pressure changes by a constant; then `restart` forgets the last step. With a hardness
        bpx may also move or dent the body as a whole.
        """
        state = self.state
        before = state.p_cell
        state.p0 = float(p0)
        change = self.problem.dtype.type(state.p_cell - before)

        def shift(i0: int, i1: int) -> None:
            state.p[i0:i1] += change

        self.grid.by_rows(shift)
        self.restart()

    def hold(self, spring: float) -> None:
        """Press the body by a spring of another stiffness from now on; p0 stays. Collective."""
        self.problem = replace(self.problem_now, spring=spring)
        self.wall = wall_of(self.problem)

    def _lay(self, g: np.ndarray) -> None:
        """Copy g into the state, set its pressure to the constant `p_cell`, and self.d to 0."""
        state = self.state

        def lay(i0: int, i1: int) -> None:
            if g is not state.g:
                state.g[i0:i1] = g[i0:i1]
            state.p[i0:i1] = state.p_cell
            self.d[i0:i1] = 0

        self.grid.by_rows(lay)

    def restart(self) -> None:
        """Begin again at the state, and forget the last step.

        Call it after other code has changed the state or the fields of self.levels. Takes no FFT,
        apart from the gap mode of bpx; with a hardness bpx may change the state, too.
        """
        raise NotImplementedError

    def after_certificate(self) -> None:
        """Prepare the next step after a certificate was refused; by default restart."""
        self.restart()

    @property
    def is_separated(self) -> bool:
        """Whether the bodies have come apart for good: no contact, pulled beyond the attraction."""
        return False

    def after_stability(self) -> None:
        """Prepare the next step after `stability_of` has overwritten the fields of the levels."""
        self.restart()

    def room(self) -> AbstractContextManager[None]:
        """Free the memory of the transforms and of the last step within a block, after which
        `restart` has to be called. The state stays. Only bpx implements it.
        """
        raise NotImplementedError

    def step(self) -> None:
        """Make one iteration: change the state, and add 1 to `iterations`."""
        raise NotImplementedError

    def step_ahead(self) -> None:
        """Make the next step of the gap alone, counted; only for solvers with `goes_ahead`.

        A certificate then computes the pressure there, so that both take one FFT pair; call
        `restart` or `after_certificate` before the next step.
        """
        raise NotImplementedError

    def progress(self, with_errors: bool = True) -> Progress:
        """Return how far the state is from the solution; the state stays.

        Parameters
        ----------
        with_errors : bool
            Whether to estimate errors and predict the solution; takes longer.

        Returns
        -------
        Progress
            Without errors `estimate` and `predicted` are None.
        """
        raise NotImplementedError

    def estimate_errors(self) -> Estimate:
        """Estimate what a certificate would find, by a sweep of the levels alone.

        For solvers whose steps do not compute these sums; without an attraction, with stored
        heights. Overwrites the fields of self.levels.
        """
        from ..certificate.error_estimates import StateSums, estimate

        state = self.state
        sums = self.levels.restrict(state.g, state.p, self.wall.limit)
        level_sums = self.levels.sweep()
        uKu = sum(self.grid.by_rows(self._work_of_pressure))
        count = len(sums)
        totals = self.grid.comm.sum([*sums, *level_sums, uKu]).tolist()
        totals_of_points = type(sums)(*totals[:count])
        _, _, mean, *products, uKu = totals[count:]
        of_state = StateSums(
            state.p0,
            mean * self.grid.cell_points,
            totals_of_points.rr,
            totals_of_points.pp - totals_of_points.rr,
            totals_of_points.contact,
            totals_of_points.yielded,
            totals_of_points.gap,
            uKu,
            products,
        )
        return estimate(self.problem, self.levels, state.g, of_state)

    def _work_of_pressure(self, i0: int, i1: int) -> float:
        """Return the share of local rows i0 <= i < i1 in <u, K u>, without an attraction."""
        state = self.state
        rows, points = self.grid.inside
        u = state.g[i0:i1].astype(np.float64)
        inner = max(min(rows, i1) - i0, 0)
        u[:inner, :points] -= self.problem.heights[i0 : i0 + inner]
        return float(np.vdot(u, state.p[i0:i1].astype(np.float64) - state.p_cell))

    def expected_area(self, estimate: Estimate) -> float:
        """Return the relative error of the area that a certificate would probably find, or 0."""
        return 0.0
