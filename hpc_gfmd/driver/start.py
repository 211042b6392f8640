"""The solver of a surface in one precision, and where it starts at a load: the load before, coarser
grids, a flat plane, or a state that was stored."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import DTypeLike

from ..bodies.halfspace import HALF_SPACE
from ..certificate.criterion import StoppingCriterion
from ..operators.problem import Problem
from ..solvers import solver_class
from ..util.errors import SceneError
from .drive import LoopState, certificate_of
from .load import GivenLoad, HeightStatistics
from .nested import Nested, cold_gap
from .precision import CALIBRATION, counting, few_points, first_precision

if TYPE_CHECKING:
    from ..bodies.base import Body
    from ..parallel.grid import Grid
    from ..scene import Solver as Settings
    from ..surface import Surface

    MakeSurface = Callable[[np.dtype], Surface]
    Slabs = Callable[[Grid], dict[str, Any]]  # local slabs of a stored state by name

# a load up to so much larger or smaller starts from the one before, others from coarser grids
# (not round numbers, nor the next one: p* has rounding errors)
WARM_UP, WARM_DOWN = 1.45, 1.26
# a start with about so many times the energy of an undeformed body is worse (rough strips have up
# to 400 times, and start better; flat tops at loads that come to no end have 80,000 times and more)
WORSE = 1e4
OTHER_VERSION = "a state of another version of hpc_gfmd, allowed: of this one"


class Start:
    """What a Sweep solves with. make_surface(dtype) -> surface.Surface; settings: scene.Solver.
    duality: whether the duality gap is wanted; body: see bodies/. Raises SceneError for what cannot
    be asked."""

    surface: Surface
    dtype: np.dtype  # the working precision
    solver: Any  # a solvers.base.Solver; None before the first load, and while its memory is needed
    nested: Nested | None
    loop: LoopState

    def __init__(
        self,
        make_surface: MakeSurface,
        settings: Settings,
        E_star: float = 1.0,
        lam_s: float | None = None,
        duality: bool = False,
        body: Body = HALF_SPACE,
        hardness: float | None = None,
    ):
        self.make_surface, self.settings = make_surface, settings
        self.E_star, self.lam_s, self.body, self.hardness = float(E_star), lam_s, body, hardness
        self.solver_class = solver_class(settings.name)
        self.target = StoppingCriterion(
            settings.accuracy, settings.residual, settings.max_iterations, duality=duality
        )
        self._load = GivenLoad(1.0)
        self._spent = 0.0  # FFT pairs that a load takes beside those of its iterations
        self._set_precision(first_precision(settings))

    def _problem(self, p_star: float) -> Problem:
        return Problem(self.surface.grid, self.surface.gap, p_star, None, self.body, self._limit)

    @property
    def _limit(self) -> float | None:
        """The hardness in the program's unit."""
        return None if self.hardness is None else self._p_star(self.hardness)

    def _p_star(self, load: float) -> float:
        return load / (self.E_star * self.surface.slope)

    def _begin(self, p0: float) -> None:
        """Give the solver a start: the load before, coarser grids, or a flat plane."""
        if self._goes_on_at(p0):
            self._reset_counts()
            self.solver.continue_at(p0)
            self._choose_certificate()
            return
        problem, memory = self._opened(p0)
        g = self._starting_gap(problem, memory)
        self._take(replace(problem, p0=self._load.begin()), g)
        self._start_at(g)
        if self.nested and not self._load.from_full_contact and self._is_worse_than_undeformed():
            self._start_at(self.surface.gap)

    def _start_at(self, g: np.ndarray) -> None:
        """Give the solver a gap."""
        if self.target.certificate_dtype != self.dtype and self.solver.takes_gap:
            # Rounding errors of the first pressure would stay to the end: only its changes are
            # added to it.
            if g is not self.solver.g:
                self.solver.g[...] = g
            fresh = certificate_of(self.solver, replace(self.target, duality=False))
            self._spent += fresh.pairs
            self.solver.refresh(fresh.uKu)
        else:
            self.solver.start(g)

    def _is_worse_than_undeformed(self) -> bool:
        """Tell whether the start has far more energy than a flat body that just touches: at light
        loads on flat tops what coarse grids make of edges is larger than what the load does."""
        solver = self.solver
        if self.surface.grid.padded or not self.solver_class.takes_gap:
            return False
        undeformed = solver.p_cell * solver.N * solver.problem.root_mean_square
        return bool(0.5 * solver.uKu > WORSE * undeformed)

    def _go_back(self, p0: float, arrays: Slabs, numbers: dict[str, Any]) -> None:
        """Give the solver a state that was stored at this load."""
        self._take(*self._opened(p0))
        try:
            self.solver.load_state(arrays(self.surface.grid), numbers["own"])
            self.loop = LoopState(**numbers.get("loop", {}))
        except (KeyError, TypeError):
            raise SceneError(OTHER_VERSION) from None
        self._first_pairs -= numbers.get("pairs", 0.0)

    def _take(self, problem: Problem, memory: np.ndarray | None) -> None:
        """Make the solver for a problem, or use the one that is there."""
        problem = self._kept(problem)
        if self.solver is None:
            self.solver = self._make(problem, memory)
        self._reset_counts()
        self.solver.p0 = problem.p0
        self._choose_certificate()

    def _opened(self, p0: float) -> tuple[Problem, np.ndarray | None]:
        """Give the problem with its heights, and memory for the starting gap, if there is any."""
        return self._problem(p0), None if self.solver is None else self.solver.g

    def _kept(self, problem: Problem) -> Problem:
        """Give the problem as it is while the solver iterates."""
        return problem

    def _starting_gap(self, problem: Problem, into: np.ndarray | None) -> np.ndarray:
        if self._load.from_full_contact:
            g = self.surface.grid.empty(self.dtype) if into is None else into
            g[...] = 0
            return g
        if self.nested is None:
            return cold_gap(problem)
        g, pairs = self.nested.start(problem, self._make, self._load, into)
        self._spent += pairs
        return g

    def _make(self, problem: Problem, g: np.ndarray | None = None) -> Any:
        """Make a solver; g: memory for its gap, which it may take over."""
        taken = {"g": g} if g is not None and self.solver_class.takes_gap else {}
        return self.solver_class(problem, self.settings.options, **taken)

    def _goes_on_at(self, p_star: float) -> bool:
        """Tell whether a load starts from the present state."""
        return self.solver is not None and not self._load.closes and self._near(p_star)

    def _near(self, p_star: float) -> bool:
        ratio = p_star / self.solver.p0
        return 1 / WARM_DOWN < ratio < WARM_UP

    def _reset_counts(self) -> None:
        """Begin the counts of a load."""
        self._first_pairs, self.solver.iterations, self.loop = self.solver.pairs, 0, LoopState()

    def _choose_certificate(self) -> None:
        """Choose the precision of the certificate and of the first pressure: double where rounding
        errors would count."""
        double = self._rounding_counts(self.solver.problem_now)
        dtype = np.float64 if double else self.dtype.type
        self.target = replace(self.target, certificate_dtype=dtype, closes=self._load.closes)

    def _rounding_counts(self, problem: Problem) -> bool:
        """Tell whether rounding errors of the pressure may count, which the certificate cannot tell
        from pressure out of contact: those of single points where few of them touch, or few do
        not."""
        few = (
            few_points(problem.grid.N, problem.p0, self.target.accuracy)
            or problem.p0 >= HALF_SPACE.full_p_star
        )
        return few or self._is_noisy(problem)

    def _is_noisy(self, problem: Problem) -> bool:
        noise = problem.noise(self.surface.h_rms / self.surface.height_unit)
        return noise > CALIBRATION.noise * counting(self.target, problem.p0)

    def _set_precision(self, dtype: DTypeLike) -> None:
        """Make the surface in this precision and plan all transforms that its contacts need."""
        self.solver = self.nested = None
        before = self.__dict__.pop("surface", None)
        known = before and before.checksum
        if before is not None:
            before.grid.forget_fft(self.dtype)
        del before
        self.dtype = np.dtype(dtype)
        self.surface = self.make_surface(self.dtype)
        if known not in (None, self.surface.checksum):
            raise SceneError("surface.path: the heights have changed since this run read them")
        self.__dict__.pop("heights", None)
        self._plan()

    def _plan(self) -> None:
        """Plan the transforms, and the grids of a nested iteration."""
        grid, wanted = self.surface.grid, self.settings.nested
        if not self.is_flat:
            grid.fft(self.dtype)
            grid.fft(np.float64)  # of the certificate
            nests = self.solver_class.nests if wanted == "auto" else wanted
            self.nested = Nested(grid, self.dtype) if nests else None

    @cached_property
    def heights(self) -> HeightStatistics:
        """Where a load has to be found. Collective where it is first asked for."""
        surface = self.surface if self.surface.h is not None else self.make_surface(self.dtype)
        problem = Problem(surface.grid, surface.gap, 1.0, None, self.body, self._limit)
        return HeightStatistics.of(problem)

    @property
    def is_flat(self) -> bool:
        """Whether all points touch at any load: at its end a flat surface is a punch."""
        return self.surface.g_rms == 0 and not self.surface.grid.padded
