"""Turns validation errors into one line: the key, what was found, what is allowed."""

import difflib
import reprlib
from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import BaseModel, ValidationError

from ..util.errors import SceneError, one_line
from ..util.quantities import DECIMAL_COMMA, NO_COMMA
from .allowed import LARGEST, SMALLEST
from .not_modelled import not_modelled
from .surface import KINDS
from .table import allowed_of, table_fields

_short = reprlib.Repr()
_short.maxstring = _short.maxother = _short.maxlong = 60
_short.maxlist = 4
_short.maxlevel = 2


MEANT = {  # other words for keys of a scene
    "tol": "accuracy",
    "tolerance": "accuracy",
    "rtol": "accuracy",
    "eps": "accuracy",
    "periodic": "boundary",
    "modulus": "E_star",
    "E": "E1",
    "nu": "nu1",
    "lengths": "physical_sizes",
    "size": "physical_sizes",
}


def nearest(name: str, known: Iterable[str]) -> str:
    """Return the entry of `known` that `name` means or is most like."""
    known = list(known)
    if MEANT.get(name) in known:
        return MEANT[name]
    return difflib.get_close_matches(name[:80], sorted(known), n=1, cutoff=0)[0]


def require_known(key: str, name: str, known: Iterable[str]) -> None:
    """Raise SceneError for a name that is none of `known`."""
    allowed = sorted(known)
    if name not in allowed:
        why = not_modelled(str(name)) or f'nearest: "{nearest(str(name), allowed)}"'
        raise SceneError(f"{key}: found {shown(name)}, {why}, allowed: {', '.join(allowed)}")


def shown(value: object) -> str:
    """Write a value in a few printable characters of one line, as TOML would have it where that is
    short."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a table"
    try:
        return one_line(_short.repr(value))
    except ValueError:  # an integer of more digits than Python prints
        return "a huge integer"


def printable(key: str) -> str:
    """Return a key or a path as it may stand in a message."""
    return key if key and key.isprintable() and len(key) <= 200 else _short.repr(key)


Model = type[BaseModel]


def explain(error: ValidationError, scene: Model, data: dict) -> str:
    """Put the first eight errors in one line. data: what was validated."""
    # several errors of one key (alternatives of a type, entries of a list) are one; a misspelt key
    # first: it explains the "missing" that comes with it
    lines: dict[tuple, str] = {}
    errors = error.errors(include_url=False)
    for item in sorted(errors, key=lambda e: e["type"] != "extra_forbidden"):
        if item["type"] != "default_factory_not_called":  # only follows from another error
            key, line = _line(item, scene, data)
            lines.setdefault(key, line)
    found = [*lines.values()]
    return "; ".join(found[:8]) + f" (and {len(found) - 8} more)" * (len(found) > 8)


def _line(item: Any, scene: Model, data: dict) -> tuple[tuple, str]:
    if not item["loc"]:  # a rule on the whole scene
        return (), str(item["ctx"]["error"])
    name, *rest = item["loc"]
    fields = _fields(scene, name)
    if name == "surface" and rest and rest[0] in KINDS:
        fields = KINDS[rest.pop(0)].model_fields
    key = (name, *rest[:1])
    path, of_table = ".".join(map(printable, key)), f"{name}." * bool(rest)
    if item["type"].startswith("union_tag"):
        return key, _kind(data[name].get("kind"))
    if not rest and item["type"] == "value_error" and fields:
        return key, f"{path}: {item['ctx']['error']}"  # a rule on the whole table has its own words
    field, *deeper = rest or [name]
    table, fields = (data[name], fields) if rest else (data, scene.model_fields)
    inner_fields = table_fields(fields[field]) if field in fields else {}
    if deeper and inner_fields:  # of a table within a table
        of_table = f"{path}."
        table, fields = table[field], inner_fields
        field, *deeper = deeper
        key, path = (*key, field), f"{path}.{printable(field)}"
    if item["type"] == "extra_forbidden":
        inner = table[field] if not rest and isinstance(table[field], dict) else ()
        why = not_modelled(field, *inner) or _nearest(field, of_table, fields, scene)
        return key, f"{path}: {why}, allowed: {', '.join(fields)}"
    found, value = "not given", table.get(field)
    if field in table:
        for place in deeper[:1]:  # of a list or a table; otherwise one of several types
            if isinstance(value, list) and place in range(len(value)):
                path, value = f"{path}[{place}]", value[place]
            elif isinstance(value, dict) and place in value:
                path, value = f"{path}.{printable(place)}", value[place]
        found = f"found {shown(value)}"
    what = allowed_of(fields[field]) + _limits(item)
    why = _why(item) if rest else ""
    return key, f"{path}: {found}, {why}allowed: {what}"


def _why(item: Any) -> str:
    """Say what is wrong with a value, where that is more than what is allowed says; ""
    otherwise."""
    value = item["input"]
    if item["type"] == "value_error":
        return f"{item['ctx']['error']}, "
    if item["type"] == "literal_error" and (why := not_modelled(str(value))):
        return f"{why}, "
    return f"{NO_COMMA}, " * (isinstance(value, str) and bool(DECIMAL_COMMA.fullmatch(value)))


def _limits(item: Any) -> str:
    """Name the limits of all numbers, where one that makes sense is beyond them; "" otherwise."""
    beyond = {"greater_than_equal": "ge", "less_than_equal": "le"}.get(item["type"])
    return (
        f", from {SMALLEST:g} to {LARGEST:g}"
        if beyond and item["ctx"][beyond] in (SMALLEST, LARGEST) and item["input"] > 0
        else ""
    )


def _fields(scene: Model, table: str) -> Mapping[str, Any]:
    """Return the keys of a table, none where it has kinds or is none."""
    field = scene.model_fields.get(table)
    return getattr(field and field.annotation, "model_fields", {})


def _nearest(name: str, of_table: str, here: Iterable[str], scene: Model) -> str:
    """Name the key that is most like an unknown one of the same table ("" or "TABLE."), and where
    the same name is a key of another one, that, too."""
    known = {key: f"{table}.{key}" for table in scene.model_fields for key in _fields(scene, table)}
    known |= {key: f"surface.{key}" for kind in KINDS.values() for key in kind.model_fields}
    known |= {table: table for table in scene.model_fields}
    guess, other = of_table + nearest(name, here), known.get(name)
    if other and other != of_table + name:  # that is a key of another kind of surface
        # without a table it is a key that lost its own
        guess = f"{guess} ({other} is a key, too)" if of_table else other
    return f"unknown key, nearest: {guess}"


def _kind(found: object) -> str:
    allowed = ", ".join(f'"{kind}"' for kind in KINDS)
    guess = f'nearest: "{nearest(found, KINDS)}", ' if isinstance(found, str) else ""
    said = "not given" if found is None else f"found {shown(found)}"
    return f"surface.kind: {said}, {guess}allowed: {allowed}"
