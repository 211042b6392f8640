"""Range checks of the theory functions; messages name quantity, number and interval."""

import numpy as np
from numpy.typing import ArrayLike

from ..util.errors import SceneError


def within(
    name: str, value: ArrayLike, low: float, high: float, open_low: bool = False
) -> np.ndarray:
    """Return numbers as a float array; SceneError unless all are finite and in the interval."""
    try:
        x = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise SceneError(f"{name}: found {value!r}, allowed: numbers") from None
    good = np.isfinite(x) & (x <= high) & ((x > low) if open_low else (x >= low))
    if not good.all():
        interval = f"{'(' if open_low else '['}{low:g}, {high:g}{')' if np.isinf(high) else ']'}"
        raise SceneError(f"{name}: found {x[~good].flat[0]:g}, allowed: {interval}")
    return x
