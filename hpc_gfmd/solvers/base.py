"""What a solver is.

A solver allocates everything in __init__(problem, options), is given a start by `start(g)` or `continue_at(p0)`, and then does one
step at a time. It owns the gap g and the pressure p (local slabs). After every step `progress()` tells how far it is. It knows
nothing of stopping, files or clocks: that is `drive.py`.
"""

from dataclasses import dataclass, replace
from functools import cached_property


@dataclass(frozen=True)
class Progress:
    """How far a solver is, the same numbers on every rank.

    residual: sqrt(mean p^2 where the gap is open)/p0; contact: points with g <= 0 and p > 0; gap_mean: in the problem's units.
    estimates: what the certificate is expected to give as relative errors of (mean gap, pressure), or None where the solver does not
    know and it has to be asked now and then.
    """

    residual: float
    contact: float
    gap_mean: float
    estimates: tuple[float, float] | None
    finite: bool = True


class Solver:
    """Common parts: `state`, `load_state`, and the count of FFT pairs."""

    name = ""
    state_names: tuple[str, ...] = ("g", "p")
    scalar_names: tuple[str, ...] = ()
    stored_as: dict[str, str] = {}  # names in a checkpoint that are not those here
    nests = True  # whether a nested start pays
    takes_gap = False  # whether __init__ has an argument g: memory for the gap
    patience = 60  # iterations without progress after which the solver counts as stagnated

    def __init__(self, problem, options=None):
        self.problem = problem
        self.grid = problem.grid
        self.p0 = float(problem.p0)
        self.N = problem.grid.N
        self.iterations = 0
        self.options = dict(options or {})

    @property
    def pairs(self):
        """FFT pairs done on this grid so far."""
        return self.elastic.pairs

    @cached_property
    def levels(self):
        """The multilevel operator on this grid, made when the certificate first asks for it."""
        from ..operators.multilevel import Multilevel

        return Multilevel(self.grid, self.problem.body, self.problem.dtype, self.elastic.fft.R)

    @property
    def problem_now(self):
        """The problem at the present load."""
        return replace(self.problem, p0=self.p0)

    @property
    def p_cell(self):
        """The mean pressure over the whole grid at the present load."""
        return self.problem_now.p_cell

    def start(self, g):
        """Begin at the gap g >= 0 (local slab, taken over)."""
        raise NotImplementedError

    def continue_at(self, p0):
        """Begin from the present state at another mean pressure, without an FFT: p changes by a constant."""
        before, self.p0 = self.p_cell, float(p0)
        self.p += self.problem.dtype.type(self.p_cell - before)
        self.refresh()

    def refresh(self, uKu=None):
        """self.p has just been computed anew from self.g, or shifted: go on from there. uKu: <u, K u>, None if that has not changed."""
        raise NotImplementedError

    def resume(self):
        """self.p has just been computed anew from self.g, and self.levels used by somebody else: go on as if nothing had happened."""

    def step(self):
        """One iteration."""
        raise NotImplementedError

    def progress(self):
        """How far the solver is."""
        raise NotImplementedError

    def expected_area(self, pressure):
        """What the certificate is expected to give as relative error of the area if that of the pressure is `pressure`."""
        return 0.0

    def state(self):
        """Everything that a bit-identical continuation needs: local slabs by name, and a dict of numbers."""
        return tuple({self.stored_as.get(name, name): getattr(self, name) for name in names}
                     for names in (self.state_names, self.scalar_names))

    def load_state(self, arrays, numbers):
        """The inverse of `state`."""
        for name in self.state_names:
            getattr(self, name)[...] = arrays[self.stored_as.get(name, name)]
        self._set_numbers(numbers)

    def _set_numbers(self, numbers):
        for name in self.scalar_names:
            setattr(self, name, numbers[self.stored_as.get(name, name)])

