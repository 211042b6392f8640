"""The surface in one precision, with what its contacts share: transforms and coarser grids.

It converts between the scene's units and the program's: makes the problem at a mean pressure, and
the Contact of its solution.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from ..contact.contact import Contact
from ..laws.base import scaled
from ..operators.problem import Problem
from .height_statistics import HeightStatistics
from .nested import Nested

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..laws.base import Law
    from ..operators.state import State
    from ..scene import SolverTable
    from ..solvers.base import Solver
    from ..surface import Precision, Surface
    from .contact_model import ContactModel

    MakeSurface = Callable[[Any], Surface]  # of a Precision


class WorkingSurface:
    """A surface made by make_surface(precision), its heights in `dtype`. Collective. settings: the
    table [solver]; `saves_memory`: whether the solver is dropped before a load starts, and
    frees its transforms during a certificate in double (low_memory.py).
    """

    saves_memory = False

    def __init__(
        self,
        make_surface: MakeSurface,
        model: ContactModel,
        settings: SolverTable,
        precision: Precision,
    ):
        self.make_surface = make_surface
        self.model = model
        self.settings = settings
        self.surface: Surface = make_surface(precision)
        self.dtype = self.surface.gap.dtype
        self._nested: Nested | None = None
        self._plan()

    def _plan(self) -> None:
        """Plan the transforms of the solver, not those of certificates in double. Collective."""
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
    def hardness(self) -> float:
        """The largest pressure, in the program's unit; infinite for an elastic solid."""
        return (self.model.hardness or inf) / self.pressure_unit

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
        """Statistics of the heights, kept; if not stored they are made again. Collective."""
        made = self.make_surface(self.dtype) if self.surface.h is None else self.surface
        return HeightStatistics.of(self._problem_of(made, 1.0))

    # -- problems

    def problem(self, p0: float) -> Problem:
        """Return the problem at p0, in the program's unit, with stored heights. Collective."""
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

    def problem_to_iterate(self, problem: Problem) -> Problem:
        """Return the problem to iterate on; here the same one, with stored heights."""
        return problem

    def memory_for_gap(self, problem: Problem, solver: Solver | None) -> np.ndarray | None:
        """Return an array that the starting gap may overwrite, the solver's gap, or None."""
        return None if solver is None else solver.state.g

    def nested(self) -> Nested:
        """Return the coarser grids, made at the first call. Collective."""
        if self._nested is None:
            self._nested = Nested(self.surface.grid, self.dtype)
        return self._nested

    # -- the solution

    def contact(
        self,
        p_mean: float,
        state: State,
        status: str,
        certificate: Certificate,
        remark: str | None = None,
        iterations: int = 0,
        pairs: float = 0.0,
    ) -> Contact:
        """Return the Contact of a load, with the arrays of a state; p_mean: unit of E_star."""
        model = self.model
        return Contact(
            self.surface,
            model.E_star,
            p_mean,
            state.g,
            state.p,
            status,
            certificate,
            accuracy=self.settings.tolerance,
            lam_s=model.lam_s,
            body=model.body,
            remark=remark,
            iterations=iterations,
            pairs=float(pairs),
            hardness=model.hardness,
            attraction=model.attraction,
        )
