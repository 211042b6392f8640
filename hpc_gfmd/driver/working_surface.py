"""The surface in one precision, with all that its contacts share: problems, transforms and coarser
grids."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..bodies.halfspace import HALF_SPACE
from ..laws.base import scaled
from ..operators.problem import Problem
from .height_statistics import HeightStatistics
from .nested import Nested
from .precision import CALIBRATION, few_points, pressure_that_counts

if TYPE_CHECKING:
    from ..certificate.criterion import StoppingCriterion
    from ..laws.base import Law
    from ..solvers.base import Solver
    from ..surface import Surface
    from .contact_model import ContactModel

    MakeSurface = Callable[[np.dtype], Surface]


class WorkingSurface:
    """A surface whose heights are stored in one precision, made by make_surface(dtype) at once.

    nests: whether contacts are solved on coarser grids first; `certifies_in_turn`: whether the
    solver frees its transforms while a certificate in double precision is computed. Collective.
    """

    certifies_in_turn = False

    def __init__(
        self, make_surface: MakeSurface, model: ContactModel, dtype: np.dtype, nests: bool
    ):
        self.make_surface = make_surface
        self.model = model
        self.dtype = dtype
        self.nests = nests
        self.surface: Surface = make_surface(dtype)
        self._plan()

    def _plan(self) -> None:
        """Plan the transforms of the solver, not those of certificates in double. Collective."""
        self._nested: Nested | None = None
        if not self.is_flat:
            self.surface.grid.fft(self.dtype)

    def release(self) -> None:
        """Free the transforms of the surface's grid in this precision."""
        self.surface.grid.forget_fft(self.dtype)

    # -- units

    @property
    def pressure_unit(self) -> float:
        """The program's unit of pressure, E* times the unit of slopes, in the unit of E_star."""
        return self.model.E_star * self.surface.slope

    @property
    def hardness(self) -> float | None:
        """The largest pressure, in the program's unit; None for an elastic solid."""
        hardness = self.model.hardness
        return None if hardness is None else hardness / self.pressure_unit

    @property
    def attraction(self) -> Law | None:
        """The law of attraction in the program's units; None without attraction."""
        law = self.model.attraction
        return None if law is None else scaled(law, self.pressure_unit, self.surface.height_unit)

    # -- the heights

    @property
    def is_flat(self) -> bool:
        """Whether the surface is flat and periodic, so that all points touch at any load."""
        return self.surface.g_rms == 0 and not self.surface.grid.padded

    @cached_property
    def heights(self) -> HeightStatistics:
        """Statistics of the heights for load searches. Collective at first access, then kept.

        If the heights are not stored, the surface is made once more for this.
        """
        surface = self.surface
        if surface.h is None:
            surface = self.make_surface(self.dtype)
        return HeightStatistics.of(self._problem_of(surface, 1.0))

    # -- problems

    def problem(self, p0: float) -> Problem:
        """Return the problem at a mean pressure p0, in the program's unit, with stored heights."""
        return self._problem_of(self.surface, p0)

    def _problem_of(self, surface: Surface, p0: float) -> Problem:
        """Return the problem of the model on a surface at the mean pressure p0."""
        return Problem(
            surface.grid,
            surface.gap,
            p0,
            body=self.model.body,
            hardness=self.hardness,
            attraction=self.attraction,
            height_error=self.model.height_error,
        )

    def problem_to_start(self, p0: float) -> Problem:
        """Return the problem at p0 with stored heights, to make a starting gap from. Collective."""
        return self.problem(p0)

    def problem_to_iterate(self, problem: Problem) -> Problem:
        """Return the problem to iterate on; here the same one, with stored heights."""
        return problem

    def memory_for_gap(self, problem: Problem, solver: Solver | None) -> np.ndarray | None:
        """Return an array that the starting gap of a problem to start from may overwrite: the
        solver's gap; None if new memory has to be allocated.
        """
        return None if solver is None else solver.g

    def nested(self) -> Nested | None:
        """Return the coarser grids, made at the first call; None without nesting or on a flat
        surface. Collective.
        """
        if self._nested is None and self.nests and not self.is_flat:
            self._nested = Nested(self.surface.grid, self.dtype)
        return self._nested

    @property
    def solver_makes_room(self) -> bool:
        """Whether the solver is dropped before each start, because its memory is needed."""
        return False

    # -- rounding errors

    def rounding_counts(self, problem: Problem, criterion: StoppingCriterion) -> bool:
        """Return whether the certificate must be computed in double precision.

        A certificate cannot distinguish rounding errors from pressure out of contact. They matter
        if few points touch (or an unknown number, at p0 <= 0), if few are open, or if the
        transforms are too noisy for the criterion.
        """
        if problem.p0 <= 0:  # only with an attraction: how many touch is unknown
            return True
        few_touch = few_points(problem.grid.N, problem.p0, criterion.accuracy)
        few_are_open = problem.p0 >= HALF_SPACE.full_p_star
        return few_touch or few_are_open or self.is_noisy(problem, criterion)

    def is_noisy(self, problem: Problem, criterion: StoppingCriterion) -> bool:
        """Return whether rounding errors of transforms are too large for the criterion: above a
        share of the pressure error that it allows.
        """
        noise = problem.noise(self.surface.h_rms / self.surface.height_unit)
        return noise > CALIBRATION.noise * pressure_that_counts(criterion, problem.p0)
