"""What a law of attraction is: an energy per area phi(g) of the gap g >= 0, concave and increasing
from -work to 0, with the attraction t = phi' >= 0, which falls with the gap.

To add a law, put a file into laws/ with a subclass of `Law` whose `name` is the file's. Its
methods take a gap, in kernels a number, elsewhere numbers or arrays, so they are written with
NumPy's functions and compiled as they stand (kernels/attraction.py).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

SAMPLES = 2001  # number of gaps at which a law is sampled
FARTHEST = 5.0  # the largest of these gaps, in ranges
TOLERANCE = 1e-9  # rounding errors that `is_concave` ignores, relative to the largest value


class Numbers(NamedTuple):
    """Work and range of a law: a plain named tuple, which kernels can take.

    Attributes
    ----------
    work : float
        Work of adhesion per area.
    range : float
        Length over which the attraction falls; each law defines its meaning.
    """

    work: Any
    range: Any


class Law(Numbers):
    """A law of attraction between two surfaces; immutable.

    Its units are those of `work` and `range`: energies per area as `work`, gaps as `range`,
    pressures as work/range. The three methods take a gap >= 0, a number or an array, and return
    the same shape.

    Attributes
    ----------
    work : float
        Work of adhesion per area.
    range : float
        Length over which the attraction falls; each law defines its meaning.
    name : str
        Name of the law in a scene, and of its file.
    sources : tuple of str
        Papers that introduced the law, with DOI.
    """

    name = ""
    sources: tuple[str, ...] = ()

    def energy(self, g: Any) -> Any:
        """Return phi(g), the energy per area at the gap g: -work at 0, rising to 0 far away."""
        raise NotImplementedError

    def traction(self, g: Any) -> Any:
        """Return phi'(g) >= 0, the attraction at the gap g as a pressure."""
        raise NotImplementedError

    def curvature(self, g: Any) -> Any:
        """Return phi''(g) <= 0, the slope of the attraction at the gap g, a pressure per length."""
        raise NotImplementedError


def gaps_of(law: Law) -> np.ndarray:
    """Return the gaps at which a law is sampled: 2001 from 0 to 5 ranges, evenly spaced."""
    return np.linspace(0, FARTHEST * float(law.range), SAMPLES)


def is_concave(law: Law) -> bool:
    """Return whether the attraction never rises with the gap, tested at `gaps_of` only."""
    curvature, traction = law.curvature(gaps_of(law)), law.traction(gaps_of(law))
    rises = TOLERANCE * np.abs(curvature).max()
    steeper = TOLERANCE * np.abs(traction).max()
    return bool(curvature.max() <= rises and np.diff(traction).max() <= steeper)


def steepest(law: Law) -> float:
    """Return the largest |phi''| at the gaps of `gaps_of`, a pressure per length."""
    return float(np.abs(law.curvature(gaps_of(law))).max())


def scaled(law: Law, pressure: float, length: float) -> Law:
    """Convert a law to units of pressure and length that are measured in those of the law."""
    return type(law)(law.work / (pressure * length), law.range / length)


def in_precision(law: Law, dtype: np.dtype) -> Law:
    """Return a law whose numbers are NumPy scalars of a dtype, as compiled kernels require."""
    real = dtype.type
    return type(law)(real(law.work), real(law.range))
