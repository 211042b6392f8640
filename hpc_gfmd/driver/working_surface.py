"""The surface in one precision, with all that the contacts on it share: problems, transforms and
coarser grids."""

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
    """A surface whose heights are stored in one precision.

    Parameters
    ----------
    make_surface : callable
        Makes the surface.Surface in a precision: ``make_surface(dtype)``. Collective.
    model : ContactModel
        What is pressed against it.
    dtype : dtype
        The working precision.
    nests : bool
        Whether contacts are solved on coarser grids first.

    Attributes
    ----------
    surface : Surface
        The surface in this precision.
    full_contact_is_known : bool
        Whether the solution of full contact, u = -h, can be written down without iterations.
    certifies_in_turn : bool
        Whether the transforms of a certificate in double precision take the memory of the solver's.
    """

    full_contact_is_known = True
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
        """Plan the transforms of the solver, the certificate and the coarser grids."""
        self._nested: Nested | None = None
        if self.is_flat:
            return
        grid = self.surface.grid
        grid.fft(self.dtype)
        grid.fft(np.float64)  # of the certificate
        if self.nests:
            self._nested = Nested(grid, self.dtype)

    def release(self) -> None:
        """Forget the transforms in this precision."""
        self.surface.grid.forget_fft(self.dtype)

    # -- units

    @property
    def pressure_unit(self) -> float:
        """What one unit of pressure in the program is in the unit of E_star."""
        return self.model.E_star * self.surface.slope

    @property
    def hardness(self) -> float | None:
        """The largest pressure, in the program's unit."""
        hardness = self.model.hardness
        return None if hardness is None else hardness / self.pressure_unit

    @property
    def attraction(self) -> Law | None:
        """The law of attraction, in the program's units."""
        law = self.model.attraction
        return None if law is None else scaled(law, self.pressure_unit, self.surface.height_unit)

    # -- the heights

    @property
    def is_flat(self) -> bool:
        """Whether all points touch at any load; a flat surface that ends is a punch."""
        return self.surface.g_rms == 0 and not self.surface.grid.padded

    @cached_property
    def heights(self) -> HeightStatistics:
        """What a search for a load knows of the heights. Collective where it is first asked for."""
        surface = self.surface
        if surface.h is None:
            surface = self.make_surface(self.dtype)
        return HeightStatistics.of(self._problem_of(surface, 1.0))

    # -- problems

    def problem(self, p0: float) -> Problem:
        """Return the problem at a mean pressure, in the program's unit, with stored heights."""
        return self._problem_of(self.surface, p0)

    def _problem_of(self, surface: Surface, p0: float) -> Problem:
        return Problem(
            surface.grid,
            surface.gap,
            p0,
            body=self.model.body,
            hardness=self.hardness,
            attraction=self.attraction,
        )

    def problem_to_start(self, p0: float) -> Problem:
        """Return the problem at p0 with stored heights, from which a starting gap is made."""
        return self.problem(p0)

    def problem_to_iterate(self, problem: Problem) -> Problem:
        """Return the same problem as the iterations need it."""
        return problem

    def memory_for_gap(self, problem: Problem, solver: Solver | None) -> np.ndarray | None:
        """Return memory for the starting gap of a problem.

        Parameters
        ----------
        problem : Problem
            As for `problem_to_start`.
        solver : Solver or None
            The solver that there is.

        Returns
        -------
        ndarray or None
            Local slab of the grid; None where new memory has to be taken.
        """
        return None if solver is None else solver.g

    def nested(self) -> Nested | None:
        """Return the coarser grids, None without nested iteration. Collective."""
        return self._nested

    @property
    def solver_makes_room(self) -> bool:
        """Whether a new start needs the memory of the solver."""
        return False

    # -- rounding errors

    def rounding_counts(self, problem: Problem, criterion: StoppingCriterion) -> bool:
        """Return whether rounding errors are large enough that the certificate needs double
        precision.

        It cannot tell them from pressure out of contact. They matter where few points touch,
        where few are open, or where the transforms are too noisy for the criterion.

        Parameters
        ----------
        problem : Problem
            At its mean pressure.
        criterion : StoppingCriterion
            What the solution has to reach.

        Returns
        -------
        bool
            The same on all ranks.
        """
        if problem.p0 <= 0:  # only with an attraction: how many touch is unknown
            return True
        few_touch = few_points(problem.grid.N, problem.p0, criterion.accuracy)
        few_are_open = problem.p0 >= HALF_SPACE.full_p_star
        return few_touch or few_are_open or self.is_noisy(problem, criterion)

    def is_noisy(self, problem: Problem, criterion: StoppingCriterion) -> bool:
        """Return whether rounding errors of the transforms may count.

        Parameters
        ----------
        problem : Problem
            At its mean pressure.
        criterion : StoppingCriterion
            What the solution has to reach.

        Returns
        -------
        bool
            The same on all ranks.
        """
        noise = problem.noise(self.surface.h_rms / self.surface.height_unit)
        return noise > CALIBRATION.noise * pressure_that_counts(criterion, problem.p0)
