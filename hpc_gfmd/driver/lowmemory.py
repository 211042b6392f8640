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
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import DTypeLike

from ..util.errors import SceneError
from .drive import certificate_of
from .nested import Nested
from .precision import NOISE_IN_TURN, counting
from .sweep import Sweep

if TYPE_CHECKING:
    from ..operators.problem import Problem
    from .sweep import Slabs


class LowMemorySweep(Sweep):
    """As Sweep. Raises SceneError for surfaces that are not known by their spectrum and for other
    solvers than bpx."""

    def _set_precision(self, dtype: DTypeLike) -> None:
        self.dtype = np.dtype(dtype)
        self.solver = None
        self.surface = self.make_surface(self.dtype)
        self.__dict__.pop("_heights", None)
        if (
            self.surface.add_spectrum is None and not self.surface.grid.padded
        ) or self.solver_class.name != "bpx":
            raise SceneError(
                'solver.low_memory: found true, allowed: with surface.kind = "self-affine" and'
                ' solver.name = "bpx"'
            )

    closes = False

    def _full_contact(self, problem: Problem) -> tuple[None, float]:
        return None, 0.0  # the nested start finds out

    def _begin(
        self, problem: Problem, arrays: Slabs | None = None, numbers: dict[str, Any] | None = None
    ) -> None:
        if arrays is None and self._goes_on_at(problem.p0):
            self._reset_counts()
            self.solver.continue_at(problem.p0)
            self._choose_certificate()
            return
        self.solver = None  # its memory is needed now
        h = self.surface.h if self.surface.h is not None else self.make_surface(self.dtype).h
        problem = replace(problem, h=h)
        memory = None if self.surface.grid.padded else h
        g, h_rms = memory, problem.root_mean_square
        if arrays is None:
            g = self._starting_gap(problem, memory)
            problem = replace(problem, p0=self._load.on_finest_grid())
        if memory is not None:
            self.surface = replace(self.surface, h=None)
            problem = replace(
                problem,
                h=None,
                add_spectrum=self.surface.add_spectrum,
                working=self.dtype,
                h_rms=h_rms,
            )
        _give_back()
        self.solver = self._make(problem, g)
        self._reset_counts()
        self._choose_certificate()
        if arrays is not None:
            self._load_state(arrays, numbers or {})
        elif self.target.in_turn:
            fresh = certificate_of(self.solver, self.target)
            self._spent += fresh.pairs
            self.solver.refresh(fresh.uKu)
        else:
            self.solver.start(g)

    def _starting_gap(self, problem: Problem, into: np.ndarray | None) -> np.ndarray:
        self.nested = Nested(self.surface.grid, self.dtype, self.settings.accuracy)
        g = super()._starting_gap(problem, into)
        self.nested = None  # the transforms of coarser grids go with it
        return g

    def _choose_certificate(self) -> None:
        super()._choose_certificate()
        self.target = replace(self.target, in_turn=self.target.certificate_dtype != self.dtype)

    def _rounding_counts(self, problem: Problem) -> bool:
        """Not where double precision would take tables, too."""
        return not self.body.table_share and self._noise(problem) > NOISE_IN_TURN * counting(
            self.target, problem.p0
        )


def _give_back() -> None:
    """Let the system have what the C library keeps of the memory of coarser grids: that was 60 to
    100 MB at n = 4096."""
    with suppress(AttributeError, OSError):
        ctypes.CDLL(None).malloc_trim(0)
