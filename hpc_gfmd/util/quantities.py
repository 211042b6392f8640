"""Numbers with units: "100 um" is 1e-4 (m), "50 GPa" is 5e10 (Pa). Inside the program they are
numbers in SI units. Lengths are those of util/lengths.py, pressures and forces those of pint."""

import difflib
import re
from collections.abc import Iterable, Mapping
from functools import cache
from math import floor, isfinite, log10
from typing import Any

from .errors import one_line
from .lengths import length_factor

SI = {"length": "m", "pressure": "Pa", "force": "N", "work": "J/m^2"}
USUAL = {  # to guess from what was meant
    "length": ("m", "mm", "um", "nm", "pm"),
    "pressure": ("Pa", "kPa", "MPa", "GPa", "bar", "N/mm^2"),
    "force": ("N", "uN", "nN", "mN", "kN"),
    "work": ("J/m^2", "mJ/m^2", "N/m", "mN/m"),
}
DECIMAL_COMMA = re.compile(r"\s*[-+]?\d*,\d+(?!.*,).*")
NO_COMMA = "decimals have a point, not a comma"
# No more than this goes to pint, which would also evaluate formulas.
_FACTOR = r"[A-Za-zµμÅ]+(?:(?:\^|\*\*)?-?[1-9])?"
_UNIT = re.compile(rf"{_FACTOR}(?: ?[/*] ?{_FACTOR}){{0,3}}")
_QUANTITY = re.compile(rf"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*({_UNIT.pattern})\s*")


class Quantity(float):
    """A number in SI units that was given with a unit; `text` is what was given."""

    text: str


def parse(text: str, dimension: str) -> Quantity:
    """Read the Quantity that "100 um" or "50 GPa" stands for; dimension: a key of SI. Raises
    ValueError."""
    found = _QUANTITY.fullmatch(text[:100])
    if not found:
        raise ValueError(
            NO_COMMA if DECIMAL_COMMA.fullmatch(text) else "it is no number with a unit"
        )
    quantity = Quantity(float(found[1]) * factor(found[2], dimension))
    quantity.text = text
    return quantity


def format_quantity(value: float, like: float | None = None) -> str:
    """Write a number as messages say it: as it was given, or in the unit of `like`, which was
    given."""
    if like is None:
        return value.text if isinstance(value, Quantity) else f"{value:g}"
    unit = _QUANTITY.fullmatch(like.text) if isinstance(like, Quantity) else None
    return f"{value / factor(unit[2]):.6g} {unit[2]}" if unit else f"{value:.6g}"


@cache
def factor(unit: str, dimension: str = "length") -> float:
    """Return one `unit` in the SI unit of a dimension. Raises ValueError for what is no unit of
    it."""
    unit = str(unit).strip()
    if found := _in_si(unit, dimension):
        return found
    others = [other for other in SI if _in_si(unit, other)]
    usual = {name.lower(): name for name in USUAL[dimension]}
    like = [] if others else difflib.get_close_matches(unit.lower(), usual, n=1)
    raise ValueError(
        f"{one_line(unit, 80)!r} is "
        + (f"a unit of {others[0]}, not of {dimension}" if others else f"no unit of {dimension}")
        + (f' (did you mean "{usual[like[0]]}"?)' if like else "")
    )


def _in_si(unit: str, dimension: str) -> float | None:
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


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


def in_units(unit: str, surface: Mapping[str, Any]) -> str:
    """Write a product of "length", "pressure" and "force" in the units that attributes of a surface
    name: "m^2"; "1" of "", and "" where one of them has no name."""
    said = [surface.get(key) for key in ("unit", "pressure_unit")]
    length, pressure = (name if isinstance(name, str) else "" for name in said)
    names = {"length": length, "pressure": pressure, "force": "N" if length and pressure else ""}
    words = "|".join(names)
    if not all(names[word] for word in re.findall(words, unit)):
        return ""
    return re.sub(words, lambda word: names[word[0]], unit) or "1"


PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "u", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}


def prefixed(values: Iterable[Any], unit: str) -> tuple[float, str]:
    """Return (what one prefixed unit is in `unit`, its name) for numbers to be read together: (1e6,
    "MPa"). (1.0, "") without a unit."""
    largest = max(
        (abs(value) for value in values if isinstance(value, int | float) and isfinite(value)),
        default=0.0,
    )
    if not unit:
        return 1.0, ""
    power = 3 * floor(log10(largest) / 3 + 1e-12) if largest > 0 else 0
    power = min(max(power, min(PREFIXES)), max(PREFIXES))
    return 10.0**power, PREFIXES[power] + unit
