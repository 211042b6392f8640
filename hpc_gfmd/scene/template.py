"""A scene that runs, with a comment on every key: what the models say of themselves."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .reference import Key, sections, toml
from .surface import KINDS

COLUMN = 40  # where comments begin
CHOSEN = {  # what is set, beside what must be given, unless somebody says otherwise
    "load": {"p_star": [0.01, 0.1]},
    "solver": {"accuracy": 1e-3},
    "output": {"path": "contact.h5", "fields": ["pressure", "gap"]},
}


@dataclass
class Suggestion:
    """What a height map says of the keys of [surface].

    values: those to be set; said: what the file itself says, shown as comments; why: reasons for
    both, in place of the meaning; missing: what only a person knows; about: the map, a line each;
    unit: "m" where lengths have units, else "".
    """

    values: dict = field(default_factory=dict)
    said: dict = field(default_factory=dict)
    why: dict = field(default_factory=dict)
    missing: list = field(default_factory=list)
    about: list = field(default_factory=list)
    unit: str = ""


def template(kind: str, tables: Mapping[str, Any], found: Suggestion, head: str) -> str:
    """Write TOML of a scene with this kind of surface; tables: what is set, beside what must be
    given; found: of a height map; head: the first line."""
    surface = {"kind": kind} | tables.get("surface", {}) | found.values
    values = {"": tables, **tables, "surface": surface}
    own = {key.name for section in sections() if section.kind == kind for key in section.keys}
    lines, last = [f"# {line}" for line in (head, *found.about)], None
    for section in sections():
        if section.kind not in ("", kind):
            continue
        if section.table and section.table != last:
            lines += ["", _beside(f"[{section.table}]", section.title)]
        last = section.table
        common = section.table == "surface" and not section.kind
        lines += [
            _line(key, values.get(last, {}), found if last == "surface" else Suggestion())
            for key in section.keys
            if not (common and key.name in own)  # the kind says it otherwise
        ]
    return "\n".join(lines) + "\n"


def _line(key: Key, values: Mapping[str, Any], found: Suggestion) -> str:
    value = values.get(key.name, key.example if key.default is None else None)
    if key.name == "kind":
        others = ", ".join(toml(other) for other in KINDS if other != value)
        return _beside(f"kind = {toml(value)}", f"or {others}")
    why = found.why.get(key.name)
    if value is not None:
        return _beside(f"{key.name} = {toml(value)}", why or key.meaning)
    plain = why or key.default in ("none", toml(key.example))
    default = "" if plain else f" (default: {key.default})"
    example = toml(found.said.get(key.name, key.example))
    return _beside(f"# {key.name} = {example}", (why or key.meaning) + default)


def _beside(setting: str, comment: str) -> str:
    return f"{setting + '  ':<{COLUMN}}# {comment}"
