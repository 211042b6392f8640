"""Validation errors of pydantic as one line: the key, what was found, what is allowed."""

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


MEANT = {  # usual words for keys that have another name
    "tol": "accuracy",
    "tolerance": "accuracy",
    "rtol": "accuracy",
    "eps": "accuracy",
    "periodic": "boundary",
    "mirror": "boundary",
    "modulus": "E_star",
    "E": "E1",
    "nu": "nu1",
    "lengths": "physical_sizes",
    "size": "physical_sizes",
    "sizes": "physical_sizes",
}


WRITTEN_AS = {  # what to write instead of keys that do not exist
    "mirror": 'boundary = "mirror", or one for each axis, such as ["mirror", "periodic"]'
}


def nearest(name: str, names: Iterable[str]) -> str:
    """Return the valid name that was probably meant (MEANT, or a similar one), or ""."""
    names = sorted(names)
    if MEANT.get(name) in names:
        return MEANT[name]
    return next(iter(difflib.get_close_matches(name[:80], names, n=1)), "")


def suggested(name: str, names: Iterable[str]) -> str:
    """Return 'nearest: "NAME", ' for the valid name that was probably meant; "" if none is near."""
    near = nearest(name, names)
    return f'nearest: "{near}", ' if near else ""


def require_known(key: str, name: str, names: Iterable[str]) -> None:
    """Raise SceneError unless a name is valid: with a near one, or physics that is not modelled."""
    allowed = sorted(names)
    if name not in allowed:
        why = not_modelled(str(name))
        hint = f"{why}, " if why else suggested(str(name), allowed)
        raise SceneError(f"{key}: found {shown(name)}, {hint}allowed: {', '.join(allowed)}")


def shown(value: object) -> str:
    """Return a value as text for a message: one short line, texts in quotes, bools as in TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a table"
    try:
        return one_line(_short.repr(value))
    except ValueError:  # an integer of more digits than Python prints
        return "a huge integer"


def printable(key: str) -> str:
    """Return a name for a message, quoted and cut if empty, long or with control characters."""
    return key if key and key.isprintable() and len(key) <= 200 else _short.repr(key)


Model = type[BaseModel]


def explain(error: ValidationError, scene: Model, data: dict) -> str:
    """Return one line on the first eight validation errors, unknown keys first, one a key, and the
    number of others. scene: the validated class; data: its tables.
    """
    # Several errors of one key (alternatives of its type, entries of a list) count as one. A
    # misspelt key comes first: it explains the "not given" that follows from it.
    lines: dict[tuple, str] = {}
    errors = error.errors(include_url=False)
    for item in sorted(errors, key=lambda e: e["type"] != "extra_forbidden"):
        if item["type"] != "default_factory_not_called":  # only follows from another error
            key, line = _line(item, scene, data)
            lines.setdefault(key, line)
    messages = [*lines.values()]
    more = f" (and {len(messages) - 8} more)" if len(messages) > 8 else ""
    return "; ".join(messages[:8]) + more


def _line(item: Any, scene: Model, data: dict) -> tuple[tuple, str]:
    """Return (key as a tuple of names, message) for one entry of `ValidationError.errors`."""
    if not item["loc"]:  # a rule on the whole scene
        return (), str(item["ctx"]["error"])
    name, *rest = item["loc"]
    fields = _fields(scene, name)
    if name == "surface" and rest and rest[0] in KINDS:
        fields = KINDS[rest.pop(0)].model_fields
    key = (name, *rest[:1])
    path = ".".join(map(printable, key))
    of_table = f"{name}." if rest else ""
    if item["type"].startswith("union_tag"):
        return key, _kind(data[name].get("kind"))
    if not rest and item["type"] == "value_error" and fields:
        return key, f"{path}: {item['ctx']['error']}"  # a rule on the whole table has its own words
    field, *deeper = rest or [name]
    table = data[name] if rest else data
    if not rest:
        fields = scene.model_fields
    inner_fields = table_fields(fields[field]) if field in fields else {}
    in_a_list = inner_fields and len(deeper) > 1 and isinstance(deeper[0], int)
    if in_a_list:  # of tables
        place, *deeper = deeper
        table = {**table, field: table[field][place]}
        key, path = (*key, place), f"{path}[{place}]"
    if deeper and inner_fields and isinstance(table[field], dict):  # of a table within a table
        of_table = f"{path}."
        table, fields = table[field], inner_fields
        field, *deeper = deeper
        key, path = (*key, field), f"{path}.{printable(field)}"
    if item["type"] == "extra_forbidden" and field in WRITTEN_AS:
        return key, f"{path}: found {shown(table[field])}, allowed: {WRITTEN_AS[field]}"
    if item["type"] == "extra_forbidden":
        inner = table[field] if not rest and isinstance(table[field], dict) else ()
        why = not_modelled(field, *inner) or _nearest(field, of_table, fields, scene)
        return key, f"{path}: {why}, allowed: {', '.join(fields)}"
    value = table.get(field)
    found_text = "not given"
    if field in table:
        for place in deeper[:1]:  # of a list or a table; otherwise one of several types
            if isinstance(value, list) and place in range(len(value)):
                path, value = f"{path}[{place}]", value[place]
            elif isinstance(value, dict) and place in value:
                path, value = f"{path}.{printable(place)}", value[place]
        found_text = f"found {shown(value)}"
    allowed = allowed_of(fields[field]) + _limits(item)
    why = _why(item) if rest else ""
    return key, f"{path}: {found_text}, {why}allowed: {allowed}"


def _why(item: Any) -> str:
    """Return what is wrong with a value and ", ", or "" if the allowed values tell."""
    value = item["input"]
    if item["type"] == "value_error":
        return f"{item['ctx']['error']}, "
    if item["type"] == "literal_error" and (why := not_modelled(str(value))):
        return f"{why}, "
    return f"{NO_COMMA}, " * (isinstance(value, str) and bool(DECIMAL_COMMA.fullmatch(value)))


def _limits(item: Any) -> str:
    """Return ", from ... to ..." if a number violates SMALLEST or LARGEST, else ""."""
    beyond = {"greater_than_equal": "ge", "less_than_equal": "le"}.get(item["type"])
    return (
        f", from {SMALLEST:g} to {LARGEST:g}"
        if beyond and item["ctx"][beyond] in (SMALLEST, LARGEST) and item["input"] > 0
        else ""
    )


def _fields(scene: Model, table: str) -> Mapping[str, Any]:
    """Return {key: field} of a table of a scene, empty for [surface], which has kinds."""
    field = scene.model_fields.get(table)
    return getattr(field and field.annotation, "model_fields", {})


def _nearest(name: str, of_table: str, siblings: Iterable[str], scene: Model) -> str:
    """Return "unknown key, nearest: ...": a similar sibling or this very name in another table;
    of_table: as "load.", or "".
    """
    places = {
        key: f"{table}.{key}" for table in scene.model_fields for key in _fields(scene, table)
    }
    places |= {key: f"surface.{key}" for kind in KINDS.values() for key in kind.model_fields}
    places |= {table: table for table in scene.model_fields}
    similar = nearest(name, siblings)
    guesses = [of_table + similar] if similar else []
    elsewhere = places.get(name)
    if elsewhere and elsewhere != of_table + name:  # else: a key of another kind of surface
        guesses.append(elsewhere)
    return f"unknown key, nearest: {' or '.join(guesses)}" if guesses else "unknown key"


def _kind(value: object) -> str:
    """Return the message for a missing or unknown kind of surface."""
    allowed = ", ".join(f'"{kind}"' for kind in KINDS)
    hint = suggested(value, KINDS) if isinstance(value, str) else ""
    found_text = "not given" if value is None else f"found {shown(value)}"
    return f"surface.kind: {found_text}, {hint}allowed: {allowed}"
