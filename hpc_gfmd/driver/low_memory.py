"""The working surface for the largest systems: the heights are not kept while iterating, so four
fields and a bit are all there is.

The starting gap takes the memory of the heights; where p = p0 + K u needs the displacement u = g -
h, the transform of h, which is known mode by mode, is added in Fourier space. Every load that does
not start from the one before makes the surface anew. Where the surface ends, its heights take a
quarter or half of a field, and are kept.

Where the first pressure and the certificates are in double precision, on large grids at small
loads, their transforms take the memory of the solver's and of its last step meanwhile.
"""

from __future__ import annotations

import ctypes
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..operators.problem import HeightSpectrum, Problem
from ..util.errors import SceneError
from .nested import Nested
from .working_surface import WorkingSurface

if TYPE_CHECKING:
    from ..certificate.criterion import StoppingCriterion
    from ..solvers.base import Solver


class LowMemorySurface(WorkingSurface):
    """A surface whose heights are given away while iterating.

    Parameters and attributes are those of `WorkingSurface`.

    Raises
    ------
    SceneError
        For a surface that is not known by its spectrum.
    """

    full_contact_is_known = False  # nested iteration finds out
    certifies_in_turn = True
    solver_makes_room = True

    def _plan(self) -> None:
        if self.surface.add_spectrum is None and not self.surface.grid.padded:
            raise SceneError(
                'solver.low_memory: found true, allowed: with surface.kind = "self-affine"'
            )

    def problem_to_start(self, p0: float) -> Problem:
        """Return the problem at p0, with heights that are made anew where there are none."""
        if self.surface.h is None:
            self.surface = self.make_surface(self.dtype)
        problem = self.problem(p0)
        return replace(problem, h_rms=problem.root_mean_square)  # while there are heights

    def problem_to_iterate(self, problem: Problem) -> Problem:
        """Return the same problem with heights that are known by their spectrum alone."""
        if self.surface.add_spectrum is not None:
            spectrum = HeightSpectrum(self.surface.add_spectrum, self.dtype)
            problem = replace(problem, h=spectrum)
            self.surface = replace(self.surface, h=None)
        _give_back()
        return problem

    def memory_for_gap(self, problem: Problem, solver: Solver | None) -> np.ndarray | None:
        """Return the memory of the heights, which are given away.

        Parameters
        ----------
        problem : Problem
            As for `problem_to_start`.
        solver : Solver or None
            None here.

        Returns
        -------
        ndarray or None
            Local slab of the grid; None where the surface ends, whose heights are kept.
        """
        return None if self.surface.grid.padded else problem.heights

    def nested(self) -> Nested | None:
        """Return new coarser grids: their transforms go as soon as they are not used."""
        return Nested(self.surface.grid, self.dtype)

    def rounding_counts(self, problem: Problem, criterion: StoppingCriterion) -> bool:
        """Return whether rounding errors may count, False where double precision takes tables.

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
        return not self.model.body.table_share and self.is_noisy(problem, criterion)


def _give_back() -> None:
    """Let the system have what the C library keeps of the memory of coarser grids: 60 to 100 MB
    at n = 4096."""
    with suppress(AttributeError, OSError):
        ctypes.CDLL(None).malloc_trim(0)
