"""The sweep for the largest systems: the heights are not kept while iterating, so four fields and a
bit are all there is.

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

import numpy as np

from ..operators.problem import HeightSpectrum, Problem
from ..util.errors import SceneError
from .nested import Nested
from .sweep import Sweep


class LowMemorySweep(Sweep):
    """As Sweep. Raises SceneError for surfaces that are not known by their spectrum and for other
    solvers than bpx."""

    closed_form = False  # nested iteration finds out

    def _plan(self) -> None:
        known = self.surface.add_spectrum is not None or self.surface.grid.padded
        if not known or self.solver_class.name != "bpx":
            raise SceneError(
                'solver.low_memory: found true, allowed: with surface.kind = "self-affine" and'
                ' solver.name = "bpx"'
            )

    def _opened(self, p0: float) -> tuple[Problem, np.ndarray | None]:
        self.solver = None  # its memory is needed now
        h = self.surface.gap if self.surface.h is not None else self.make_surface(self.dtype).gap
        problem = Problem(self.surface.grid, h, p0, body=self.body, hardness=self._limit)
        problem = replace(problem, h_rms=problem.root_mean_square)  # as long as they are there
        return problem, None if self.surface.grid.padded else h

    def _kept(self, problem: Problem) -> Problem:
        if self.surface.add_spectrum is not None:
            spectrum = HeightSpectrum(self.surface.add_spectrum, self.dtype)
            problem = replace(problem, h=spectrum)
            self.surface = replace(self.surface, h=None)
        _give_back()
        return problem

    def _starting_gap(self, problem: Problem, into: np.ndarray | None) -> np.ndarray:
        self.nested = Nested(self.surface.grid, self.dtype)
        g = super()._starting_gap(problem, into)
        self.nested = None  # the transforms of coarser grids go with it
        return g

    def _choose_certificate(self) -> None:
        super()._choose_certificate()
        self.target = replace(self.target, in_turn=self.target.certificate_dtype != self.dtype)

    def _rounding_counts(self, problem: Problem) -> bool:
        """Not where double precision would take tables, too."""
        return not self.body.table_share and self._is_noisy(problem)


def _give_back() -> None:
    """Let the system have what the C library keeps of the memory of coarser grids: 60 to 100 MB
    at n = 4096."""
    with suppress(AttributeError, OSError):
        ctypes.CDLL(None).malloc_trim(0)
