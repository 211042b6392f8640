"""Numbers of arguments, 0.25, 1e-3 and 1/1024, and numbers as JSON."""

from math import isfinite
from typing import Any


def number(text: str) -> float:
    """A float from a decimal number or a ratio of two; ValueError otherwise."""
    top, slash, bottom = text.partition("/")
    try:
        return float(top) / float(bottom) if slash else float(top)
    except ZeroDivisionError:
        raise ValueError(text) from None


def finite(value: Any) -> Any:
    """The same with null for what JSON does not know: infinity, NaN and complex numbers."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if isinstance(value, float) and not isfinite(value):
        return None
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)
