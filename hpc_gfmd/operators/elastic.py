"""Applying the stiffness K of an elastic body, or its compliance S = 1/K, to fields: p = p0 + K u
in the units of operators/problem.py."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from ..bodies.base import Body
from ..parallel.grid import Grid
from .problem import Columns, Rows

RowFunction = Callable[[int, int, np.ndarray], Any]  # makes or uses rows i0..i1


class Elastic:
    """Applies K, or its inverse S, to fields that the caller makes and uses a few rows at a time.

    Parameters
    ----------
    grid : Grid
        Of the fields.
    body : Body
        Whose K it is.
    dtype : dtype
        Precision of the transforms.

    Attributes
    ----------
    pairs : float
        FFT pairs done so far on this grid; a transform in one direction is half a pair.
    mean : float
        This rank's share of the mean of the field that was multiplied last.
    """

    def __init__(self, grid: Grid, body: Body, dtype: DTypeLike):
        self.grid = grid
        self.body = body
        self.dtype: np.dtype = np.dtype(dtype)
        self.pairs = 0.0
        self.mean = 0.0
        self.plan()

    def plan(self) -> None:
        """Take the memory of the transforms. Collective."""
        self.fft = self.grid.fft(self.dtype)
        self.multipliers = self.body.multipliers(self.grid, self.fft)

    def make_room(self) -> None:
        """Give the memory of the transforms back, until `plan`."""
        del self.fft, self.multipliers
        self.grid.forget_fft(self.dtype)

    def _columns(
        self,
        inverse: bool = False,
        backward: bool = True,
        add: Columns | None = None,
        spring: float = 0.0,
    ) -> float:
        """Multiply all columns by K or S and transform them back; returns this rank's share of the
        product.

        Sets `mean`. add: completes a block of columns before it is multiplied. Collective.
        """
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
        """Begin an application of K: rows of u are made by fill; returns what it returned."""
        return self.fft.forward_rows(fill)

    def pressure_columns(self, add: Columns | None = None, spring: float = 0.0) -> float:
        """Multiply the columns by K, and return this rank's share of <u, K u>.

        Parameters
        ----------
        add : callable, optional
            add(block, m) completes the columns first.
        spring : float
            K(0): the uniform pressure that a uniform displacement takes.

        Returns
        -------
        float
            Without the other ranks'.
        """
        return self._columns(add=add, spring=spring)

    def use_rows(self, use: RowFunction) -> list:
        """End an application of K: rows of K u are given to use; returns what it returned."""
        self.pairs += 1
        return self.fft.backward_rows(use)

    def displacement_columns(self) -> float:
        """Multiply the columns by S after `pressure_rows` of a pressure, for `use_rows` of S p with
        zero mean; returns this rank's share of <p, S p>."""
        return self._columns(inverse=True)

    def compliance_columns(self) -> float:
        """Return, after `pressure_rows` of a pressure, this rank's share of <p, S p>. Half a pair
        in all, nothing is transformed back."""
        self.pairs += 0.5
        return self._columns(inverse=True, backward=False)


def reader(field: np.ndarray) -> Rows:
    """Return a fill function that copies rows of a local slab."""

    def fill(i0: int, i1: int, x: np.ndarray) -> None:
        x[: i1 - i0] = field[i0:i1]

    return fill
