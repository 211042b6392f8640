"""Descriptions of the values that a key may have, derived from the type that checks them."""

from dataclasses import asdict
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt

SMALLEST = 1e-100  # bounds that keep squares and products of a few numbers finite
LARGEST = 1e100
MAX_INT = 2**63 - 1  # the largest integer of TOML and of HDF5
EXAMPLES = {
    "length": "100 um",
    "pressure": "50 GPa",
    "force": "5 mN",
    "work": "50 mJ/m2",
    "time": "10 s",
}
COUNTS = {2: "two", 3: "three", 4: "four"}


def allowed_values(annotation: Any, metadata: tuple = (), unit: str = "") -> str:
    """Describe the values of a type with its bounds, as "a number above 0 and up to 1"; metadata:
    further bounds; unit: what numbers measure, if they may have units. "a text" for unknown types.
    """
    origin = get_origin(annotation)
    if origin is Annotated:
        annotation, *inner = get_args(annotation)
        return allowed_values(annotation, (*inner, *metadata), unit)
    if origin in (Union, UnionType):
        texts = []
        for member in get_args(annotation):
            texts += _names(member) or [allowed_values(member, metadata, unit)] * (
                member is not NoneType
            )
        return _either(texts)
    if names := _names(annotation):
        return _either(names)
    if origin is tuple:
        return _list(get_args(annotation), unit)
    if annotation in (int, float):
        number = _number("a whole number" if annotation is int else "a number", metadata)
        return f'{number}, plain or as "{EXAMPLES[unit]}"' if unit in EXAMPLES else number
    return "a text"


def _number(noun: str, metadata: tuple) -> str:
    """Describe a number by its bounds but LARGEST and MAX_INT (overflow); SMALLEST is "above 0"."""
    bounds: dict[str, Any] = {}
    for item in metadata:
        for part in getattr(item, "metadata", None) or [item]:  # a pydantic Field has several
            if isinstance(part, Ge | Gt | Le | Lt):
                bounds |= asdict(part)
    words = []
    if "gt" in bounds:
        words.append(f"above {_plain(bounds['gt'])}")
    elif bounds.get("ge") == SMALLEST:
        words.append("greater than 0")
    elif bounds.get("ge", -LARGEST) > -MAX_INT:
        words.append(f"from {_plain(bounds['ge'])}")
    if "lt" in bounds:
        words.append(f"below {_plain(bounds['lt'])}")
    elif bounds.get("le", LARGEST) not in (LARGEST, MAX_INT):
        words.append(f"up to {_plain(bounds['le'])}")
    limits = " and ".join(words)
    if limits.startswith("from"):
        limits = limits.replace(" and up to", " to")
    return f"{noun} {limits}".strip()


def _plain(bound: Any) -> str:
    """Return a bound as it is written in a scene."""
    return f"{bound:g}" if isinstance(bound, float) else str(bound)


def _names(annotation: Any) -> list[str]:
    """Return the values of a bool or Literal type as a scene writes them; [] for other types."""
    if annotation is bool:
        return ["true", "false"]
    if get_origin(annotation) is Literal:
        return [f'"{value}"' for value in get_args(annotation)]
    return []


def _list(members: tuple, unit: str) -> str:
    """Describe a tuple type of any or fixed length; keys of any length take a single value, too."""
    text = allowed_values(members[0], unit=unit)
    if members[-1] is Ellipsis:
        return f"{text}, or a list of them"
    return f"a list of {COUNTS[len(members)]}, each {text}"


def _either(texts: list[str]) -> str:
    """Join alternatives, at least one, with commas and "or"."""
    *all_but_one, final = texts
    if not all_but_one:
        return final
    separator = ", or " if any(", " in text for text in texts) else " or "
    return f"{', '.join(all_but_one)}{separator}{final}"
