"""Numbers with units ("100 um" is 1e-4), in SI units; lengths by lengths.py, others by pint."""

import difflib
import re
from collections.abc import Iterable, Mapping
from functools import cache
from math import floor, isfinite, log10, nan
from typing import Any

from .errors import one_line
from .lengths import length_factor

SI = {
    "length": "m",
    "pressure": "Pa",
    "force": "N",
    "work": "J/m^2",
    "time": "s",
    "viscosity": "Pa*s",
}
USUAL = {  # suggested for misspelt units
    "length": ("m", "mm", "um", "nm", "pm"),
    "pressure": ("Pa", "kPa", "MPa", "GPa", "bar", "N/mm^2"),
    "force": ("N", "uN", "nN", "mN", "kN"),
    "work": ("J/m^2", "mJ/m^2", "N/m", "mN/m"),
    "time": ("s", "ms", "min", "h"),
    "viscosity": ("Pa s", "mPa s", "cP"),
}
DECIMAL_COMMA = re.compile(r"\s*[-+]?\d*,\d+(?!.*,).*")
NO_COMMA = "decimals have a point, not a comma"
# Only text of this form is passed to pint, which would also evaluate formulas.
_FACTOR = r"[A-Za-zµμÅ]+(?:(?:\^|\*\*)?-?[1-9])?"
_UNIT = re.compile(rf"{_FACTOR}(?:(?: ?[/*·] ?| ){_FACTOR}){{0,3}}")
_QUANTITY = re.compile(rf"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*({_UNIT.pattern})\s*")


class Quantity(float):
    """A number in SI units that was given with a unit; `text` is as it was given."""

    text: str


def parse(text: str, dimension: str) -> Quantity:
    """Convert a text such as "100 um" to the SI unit of a dimension, or raise ValueError."""
    parts = _QUANTITY.fullmatch(text[:100])
    if not parts:
        is_comma = DECIMAL_COMMA.fullmatch(text)
        raise ValueError(NO_COMMA if is_comma else "it is not a number with a unit")
    quantity = Quantity(float(parts[1]) * factor(parts[2], dimension))
    quantity.text = text
    return quantity


def finite_number(value: Any) -> float:
    """Return a finite number as a float, nan for anything else, such as a text."""
    try:
        number = nan if isinstance(value, str) else float(value)
    except (TypeError, ValueError):
        return nan
    return number if isfinite(number) else nan


def format_quantity(value: float, like: float | None = None) -> str:
    """Write a number for a message, with the unit that it or the length `like` was given in."""
    if like is None:
        return value.text if isinstance(value, Quantity) else f"{value:g}"
    unit = _QUANTITY.fullmatch(like.text) if isinstance(like, Quantity) else None
    return f"{value / factor(unit[2]):.6g} {unit[2]}" if unit else f"{value:.6g}"


@cache
def factor(unit: str, dimension: str = "length") -> float:
    """Return a unit such as "um" or "N/mm^2" in the SI unit of a dimension, or raise ValueError."""
    unit = str(unit).strip()
    if size := _in_si(unit, dimension):
        return size
    name = repr(one_line(unit, 80))
    for wrong_dimension in SI:
        if _in_si(unit, wrong_dimension):
            raise ValueError(f"{name} is a unit of {wrong_dimension}, not of {dimension}")
    usual = {name.lower(): name for name in USUAL[dimension]}
    similar = difflib.get_close_matches(unit.lower(), usual, n=1)
    hint = f' (did you mean "{usual[similar[0]]}"?)' if similar else ""
    raise ValueError(f"{name} is no unit of {dimension}{hint}")


def _in_si(unit: str, dimension: str) -> float | None:
    """Return a unit in SI or None; imports pint, which takes a while, for all but "length"."""
    if dimension == "length":
        return length_factor(unit)
    import pint

    try:
        if _UNIT.fullmatch(unit):
            power = re.sub(r"(?<=[^\W\d_])(-?[1-9])", r"^\1", unit)  # pint has "m^2" for "m2"
            return float(_registry()(power).to(SI[dimension]).magnitude)
    except (ValueError, AttributeError, pint.PintError):
        pass
    return None


def ratio(unit: str, divisor: str) -> float:
    """Return one unit, such as "Pa/m", over another one of the same dimension."""
    return float(_registry().Quantity(1.0, unit).to(divisor).magnitude)


@cache
def _registry() -> Any:
    """Return pint's table of units, made at the first call, which takes a while."""
    import pint

    return pint.UnitRegistry()


def in_units(unit: str, surface: Mapping[str, Any]) -> str:
    """Replace length, pressure, force and time in a unit by those of a surface, as "m^2"; ""
    becomes "1", or "" if one is missing.
    """
    length, pressure, time = (
        name if isinstance(name, str) else ""
        for name in map(surface.get, ("unit", "pressure_unit", "time_unit"))
    )
    force = "N" if length and pressure else ""
    names = {"length": length, "pressure": pressure, "force": force, "time": time}
    words = "|".join(names)
    if not all(names[word] for word in re.findall(words, unit)):
        return ""
    return re.sub(words, lambda word: names[word[0]], unit) or "1"


PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "u", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}


def prefixed(values: Iterable[Any], unit: str) -> tuple[float, str]:
    """Return, as (1e6, "MPa"), the SI unit with a prefix in which the largest finite number is 1 to
    1000; (1.0, "") without one.
    """
    largest = max(
        (abs(value) for value in values if isinstance(value, int | float) and isfinite(value)),
        default=0.0,
    )
    if not unit:
        return 1.0, ""
    power = 3 * floor(log10(largest) / 3 + 1e-12) if largest > 0 else 0
    power = min(max(power, min(PREFIXES)), max(PREFIXES))
    return 10.0**power, PREFIXES[power] + unit
