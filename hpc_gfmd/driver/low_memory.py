"""The working surface for the largest systems: the heights are not kept while iterating, so that
little more than four fields are in memory.

The starting gap overwrites the heights. The displacement u = g - h is completed in Fourier space,
where the transform of h is known mode by mode; every load that does not start from the one before
makes the surface again. With free edges the heights take a quarter or half of a field, and are
kept.

On large grids at small loads the first pressure and the certificates are in double precision; the
solver then frees its transforms and its last step while they are computed.
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
    """A surface whose heights are not stored during the iterations; `surface` changes from load to
    load.

    Raises SceneError if the periodic surface is not known by its modes, see surface/modes.py.
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
        of `self.surface`.

        With free edges both keep them. Memory that the C library holds goes back to the system.
        """
        if self.surface.add_spectrum is not None:
            spectrum = HeightSpectrum(self.surface.add_spectrum, self.dtype)
            problem = replace(problem, h=spectrum)
            self.surface = replace(self.surface, h=None)
        _give_back()
        return problem

    def memory_for_gap(self, problem: Problem, solver: Solver | None) -> np.ndarray | None:
        """Return the array of the heights, which the starting gap then overwrites; None with free
        edges, where the heights are kept.
        """
        return None if self.surface.grid.padded else problem.heights

    def nested(self) -> Nested:
        """Make coarser grids, whose transforms are freed when the caller drops them. Collective."""
        return Nested(self.surface.grid, self.dtype)

    def rounding_counts(self, problem: Problem) -> bool:
        """Return whether transforms are too noisy, so that the certificate must be computed in
        double precision; never for bodies whose stiffness takes a table in memory.
        """
        return not self.model.body.table_share and self.is_noisy(problem)


def _give_back() -> None:
    """Return free memory of the C library (glibc) to the system: 60 to 100 MB at n = 4096."""
    with suppress(AttributeError, OSError):
        ctypes.CDLL(None).malloc_trim(0)
