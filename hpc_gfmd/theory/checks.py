"""Range checks shared by the theory functions.

A message is one line: the name of the quantity, the number found and the interval allowed.
"""

import numpy as np
from numpy.typing import ArrayLike

from ..util.errors import SceneError


def within(
    name: str, value: ArrayLike, low: float, high: float, open_low: bool = False
) -> np.ndarray:
    """Check that numbers are finite and within an interval, and return them as a float array.

    Parameters
    ----------
    name : str
        Name of the quantity in the message.
    value : array_like
        The numbers; not changed.
    low, high : float
        The interval, ends included.
    open_low : bool
        Whether `low` itself is excluded.

    Returns
    -------
    ndarray of float64
        In the shape of value (0-dimensional for a scalar).

    Raises
    ------
    SceneError
        If value is not numeric, or any number is nan, infinite or outside of the interval.
    """
    try:
        x = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise SceneError(f"{name}: found {value!r}, allowed: numbers") from None
    good = np.isfinite(x) & (x <= high) & ((x > low) if open_low else (x >= low))
    if not good.all():
        interval = f"{'(' if open_low else '['}{low:g}, {high:g}{')' if np.isinf(high) else ']'}"
        raise SceneError(f"{name}: found {x[~good].flat[0]:g}, allowed: {interval}")
    return x
