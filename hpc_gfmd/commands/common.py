"""What several commands take and give: numbers such as 0.25, 1e-3 and 1/1024, JSON."""

from math import isfinite
from typing import Any


def number(text: str) -> float:
    """Read a decimal number or a ratio of two; ValueError otherwise."""
    top, slash, bottom = text.partition("/")
    try:
        return float(top) / float(bottom) if slash else float(top)
    except ZeroDivisionError:
        raise ValueError(text) from None


def finite(value: Any) -> Any:
    """Replace what JSON does not know, infinity and NaN, by null, and what is no number, text or
    list by its text."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if isinstance(value, float) and not isfinite(value):
        return None
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)
