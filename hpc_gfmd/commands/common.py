"""What several commands take and give: numbers such as 0.25, 1e-3 and 1/1024, JSON."""

import json
from typing import Any


def number(text: str) -> float:
    """Read a decimal number or a ratio of two; ValueError otherwise."""
    top, slash, bottom = text.partition("/")
    try:
        return float(top) / float(bottom) if slash else float(top)
    except ZeroDivisionError:
        raise ValueError(text) from None


def as_json(value: Any, indent: int | None = None) -> str:
    """Write JSON: infinity and NaN, which it does not know, as null, and what is no number, text or
    list as its text."""
    known = json.loads(json.dumps(value, default=str), parse_constant=lambda _: None)
    return json.dumps(known, indent=indent)
