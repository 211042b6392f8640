"""What several commands take and give: numbers such as 0.25, 1e-3 and 1/1024, JSON."""

import json
from typing import Any

from pydantic_core import to_json


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
    return json.loads(to_json(value, inf_nan_mode="null", fallback=str))
