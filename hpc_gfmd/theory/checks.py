"""Range checks shared by the theory functions: one line naming the quantity, found and allowed."""

import numpy as np
from numpy.typing import ArrayLike

from ..util.errors import SceneError


def within(
    name: str, value: ArrayLike, low: float, high: float, open_low: bool = False
) -> np.ndarray:
    """Return numbers as a float array, all of them finite and within an interval.

    Parameters
    ----------
    name : str
        Of the quantity, for the message.
    value : array_like
        The numbers.
    low, high : float
        The interval, ends included.
    open_low : bool
        Whether `low` itself is left out.

    Returns
    -------
    ndarray of float64

    Raises
    ------
    SceneError
        For other numbers.
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
