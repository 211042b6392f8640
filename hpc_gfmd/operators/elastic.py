"""The stiffness K of a body, or S = 1/K, applied to fields in the units of problem.py."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from ..bodies.base import Body
from ..parallel.grid import Grid
from .problem import Columns

RowFunction = Callable[[int, int, np.ndarray], Any]  # makes or uses rows i0..i1


class Elastic:
    """Applies the stiffness K of a body, or its inverse S, to fields, a few rows at a time.

    An application is `pressure_rows`, `columns`, `use_rows`, with functions of the caller for rows.
    `pairs` counts FFT pairs, half a pair for one direction; `mean`: this rank's share of the mean
    of the field multiplied last. `fft` and `multipliers` are missing between `make_room` and
    `plan`.
    """

    def __init__(self, grid: Grid, body: Body, dtype: DTypeLike):
        self.grid = grid
        self.body = body
        self.dtype: np.dtype = np.dtype(dtype)
        self.pairs = 0.0
        self.mean = 0.0
        self.plan()

    def plan(self) -> None:
        """Set `fft` and `multipliers`, which take the memory of the transforms. Collective."""
        self.fft = self.grid.fft(self.dtype)
        self.multipliers = self.body.multipliers(self.grid, self.fft)

    def make_room(self) -> None:
        """Free large transforms; nothing can be applied until `plan` is called again."""
        del self.fft, self.multipliers
        self.grid.forget_fft(self.dtype)

    def columns(
        self,
        inverse: bool = False,
        backward: bool = True,
        add: Columns | None = None,
        spring: float = 0.0,
    ) -> float:
        """Multiply all columns by K, or S with `inverse`, and if `backward` transform them back.

        Sets `mean`. Returns this rank's share of <u, K u> or <p, S p>. add(block, m) completes a
        block of columns before it is multiplied; `spring` stands for K(0). What is not transformed
        back counts half a pair; S p has zero mean. Collective.
        """
        self.pairs += 0.0 if backward else 0.5
        multipliers = self.multipliers
        multipliers.couple(self.fft, inverse)
        if add is None and multipliers.alone and spring == 0:
            energy, self.mean = self.fft.multiply_columns(multipliers.factors, inverse, backward)
            return energy

        def apply(block: np.ndarray, m: int) -> float:
            if add is not None:
                add(block, m)
            if m > 0:
                return multipliers.multiply(block, m, inverse)
            # whoever has q = 0
            total = float(block[0, 0].real)
            self.mean = total * self.fft.scale
            energy = multipliers.multiply(block, m, inverse)
            if spring > 0:
                block[0, 0] = spring * self.mean
                energy += spring * self.mean * total
            return energy

        return float(sum(self.fft.columns(apply, backward=backward)))

    def pressure_rows(self, fill: RowFunction) -> list:
        """Begin an application: transform rows that fill(i0, i1, x) writes, on several threads."""
        return self.fft.forward_rows(fill)

    def use_rows(self, use: RowFunction) -> list:
        """End an application: hand rows of K u or S p to use(i0, i1, x), on several threads."""
        self.pairs += 1
        return self.fft.backward_rows(use)


def reader(field: np.ndarray) -> RowFunction:
    """Return a function fill(i0, i1, x) that copies rows i0 <= i < i1 of a local slab to x."""

    def fill(i0: int, i1: int, x: np.ndarray) -> None:
        x[: i1 - i0] = field[i0:i1]

    return fill
