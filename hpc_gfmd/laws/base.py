"""What a law of attraction is: an energy per area phi(g) of the gap g >= 0, concave and increasing
from -work to 0, with the attraction t = phi' >= 0, which falls with the gap.

To add a law, put a file into laws/ with a subclass of `Law` whose `name` is the file's. Its
methods take a gap, in kernels a number, elsewhere numbers or arrays, so they are written with
NumPy's functions and compiled as they stand (kernels/attraction.py).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

SAMPLES = 2001  # gaps at which a law is looked at
FARTHEST = 5.0  # of them, in ranges
TOLERANCE = 1e-9  # of the largest curvature, by which rounding errors may miss 0


class Numbers(NamedTuple):
    """The numbers of a law, as kernels take them.

    Attributes
    ----------
    work : float
        Work of adhesion per area.
    range : float
        Length over which the attraction falls.
    """

    work: Any
    range: Any


class Law(Numbers):
    """A law of attraction, in the units of its numbers.

    Attributes
    ----------
    work : float
        Work of adhesion per area.
    range : float
        Length over which the attraction falls.
    name : str
        The file's.
    sources : tuple of str
        Papers that the law is from, with DOI.
    """

    name = ""
    sources: tuple[str, ...] = ()

    def energy(self, g: Any) -> Any:
        """Return phi(g), an energy per area: -work at 0, 0 far away."""
        raise NotImplementedError

    def traction(self, g: Any) -> Any:
        """Return phi'(g) >= 0, a pressure."""
        raise NotImplementedError

    def curvature(self, g: Any) -> Any:
        """Return phi''(g) <= 0, a pressure per length."""
        raise NotImplementedError


def gaps_of(law: Law) -> np.ndarray:
    """Return gaps from 0 on at which a law is looked at."""
    return np.linspace(0, FARTHEST * float(law.range), SAMPLES)


def is_concave(law: Law) -> bool:
    """Return whether the attraction falls with the gap everywhere."""
    curvature, traction = law.curvature(gaps_of(law)), law.traction(gaps_of(law))
    rises = TOLERANCE * np.abs(curvature).max()
    steeper = TOLERANCE * np.abs(traction).max()
    return bool(curvature.max() <= rises and np.diff(traction).max() <= steeper)


def steepest(law: Law) -> float:
    """Return the largest |phi''| of a law."""
    return float(np.abs(law.curvature(gaps_of(law))).max())


def scaled(law: Law, pressure: float, length: float) -> Law:
    """Return the same law in other units.

    Parameters
    ----------
    law : Law
        In units of a user.
    pressure, length : float
        The new units, in those of the law.

    Returns
    -------
    Law
        With its work in units of pressure times length.
    """
    return type(law)(law.work / (pressure * length), law.range / length)


def in_precision(law: Law, dtype: np.dtype) -> Law:
    """Return the same law as kernels take it.

    Parameters
    ----------
    law : Law
        Any.
    dtype : dtype
        Precision of the fields.

    Returns
    -------
    Law
        With its numbers in this precision.
    """
    real = dtype.type
    return type(law)(real(law.work), real(law.range))
