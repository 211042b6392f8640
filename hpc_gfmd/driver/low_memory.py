"""The working surface for the largest systems: little more than four fields, no heights kept.

The starting gap overwrites the heights; u = g - h is completed in Fourier space, where the
transform of h is known by modes, and loads that do not start from the one before make the surface
again. With free edges the heights, a quarter or half of a field, are kept. On large grids at small
loads the first pressure and certificates are in double precision; meanwhile the solver frees its
transforms and last step.
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
    from ..solvers.base import Solver


class LowMemorySurface(WorkingSurface):
    """A surface without stored heights; `surface` changes from load to load. SceneError unless a
    periodic surface is known by modes (surface/modes.py).
    """

    saves_memory = True

    def _plan(self) -> None:
        """Raise SceneError for a periodic surface without modes; plan no transforms yet."""
        if self.surface.add_spectrum is None and not self.surface.grid.padded:
            raise SceneError(
                'solver.low_memory: found true, allowed: with surface.kind = "self-affine",'
                ' "spectrum" (without a distribution of heights) or "fourier"'
            )

    def problem(self, p0: float) -> Problem:
        """Return the problem with stored heights, making the surface again if need be."""
        if self.surface.h is None:
            self.surface = self.make_surface(self.dtype)
        problem = super().problem(p0)
        return replace(problem, h_rms=problem.root_mean_square)  # while there are heights

    def problem_to_iterate(self, problem: Problem) -> Problem:
        """Return the problem with the spectrum in place of the heights, which are freed, also those
        of `self.surface` (not with free edges).
        """
        if self.surface.add_spectrum is not None:
            spectrum = HeightSpectrum(self.surface.add_spectrum, self.dtype)
            problem = replace(problem, h=spectrum)
            self.surface = replace(self.surface, h=None)
        _give_back()
        return problem

    def memory_for_gap(self, problem: Problem, solver: Solver | None) -> np.ndarray | None:
        """Return the array of the heights, for the starting gap; None with free edges."""
        return None if self.surface.grid.padded else problem.heights

    def nested(self) -> Nested:
        """Make coarser grids, whose transforms are freed when the caller drops them. Collective."""
        return Nested(self.surface.grid, self.dtype)


def _give_back() -> None:
    """Return free memory of the C library (glibc) to the system: 60 to 100 MB at n = 4096."""
    with suppress(AttributeError, OSError):
        ctypes.CDLL(None).malloc_trim(0)
