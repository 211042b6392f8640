"""All keys of a scene with what their models say of them: as text, and as a page of the
documentation."""

import json
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from pydantic_core import PydanticUndefined

from ..util.errors import SceneError
from .explain import nearest, printable
from .model import Scene
from .not_modelled import not_modelled
from .surface import KINDS, Surface

WIDTH = 100
UNITS = {
    "length": "in the unit of the surface, or with a unit",
    "pressure": "in the unit of the moduli, or with a unit",
    "force": "in the unit of the moduli times that of the surface squared, or with a unit",
}


@dataclass(frozen=True)
class Key:
    """A key of a table: what help and templates say of it. default: None where there is none;
    example: a value as it may stand."""

    name: str
    meaning: str
    allowed: str
    unit: str = ""
    default: str | None = None
    example: Any = None

    @property
    def facts(self) -> str:
        """Default, unit and allowed values."""
        first = "must be given" if self.default is None else f"default {self.default}"
        return "; ".join(
            part
            for part in (first, UNITS.get(self.unit, self.unit and f"in {self.unit}"), self.allowed)
            if part
        )


KIND = Key("kind", "which surface", ", ".join(map(json.dumps, KINDS)), example="self-affine")


@dataclass(frozen=True)
class Section:
    """A table, or a kind of surface; kind: "" for all kinds and for other tables."""

    table: str
    title: str
    about: str
    keys: tuple[Key, ...]
    kind: str = ""

    @property
    def heading(self) -> str:
        """How a scene writes it."""
        return (
            f'[{self.table}] of kind = "{self.kind}"'
            if self.kind
            else f"[{self.table}]"
            if self.table
            else "title"
        )


def sections(names: Mapping[str, Any] | None = None) -> list[Section]:
    """All of them; names: those that a key takes, which the scene does not know:
    {"output.observables": [...]}."""
    title = _key("title", Scene.model_fields["title"])
    found = [Section("", "the scene", "A key before the first table.", (title,))]
    for table, field in Scene.model_fields.items():
        models: dict[str, Any] = {"": field.annotation}
        if table == "surface":
            models = {"": Surface, **KINDS}
        for kind, model in models.items() if table != "title" else ():
            keys = tuple(
                _key(name, model.model_fields[name], (names or {}).get(f"{table}.{name}"))
                for name in model.__annotations__  # its own, not those that every kind has
                if name in model.model_fields and name != "kind"
            )
            about = " ".join(model.__doc__.split())
            keys = (KIND, *keys) if model is Surface else keys
            found.append(Section(table, field.description or "", about, keys, kind))
    return found


def toml(value: Any) -> str:
    """A value as a scene has it."""
    return json.dumps(value, ensure_ascii=False)


def text(key: str | None = None, names: Mapping[str, Any] | None = None) -> str:
    """The keys for a terminal: all, or those of a table, or those of one name ("accuracy",
    "solver.accuracy"). Raises SceneError."""
    lines = []
    for section in _chosen(key, sections(names)):
        lines += ["", *textwrap.wrap(f"{section.heading}: {section.about}", WIDTH)]
        for entry in section.keys:
            indent = " " * 22
            lines += textwrap.wrap(
                entry.meaning,
                WIDTH,
                initial_indent=f"  {entry.name:<18}  ",
                subsequent_indent=indent,
            )
            lines += textwrap.wrap(
                entry.facts, WIDTH, initial_indent=indent, subsequent_indent=indent
            )
    return "\n".join(lines[1:])


def markdown(names: Mapping[str, Any] | None = None) -> str:
    """The same as a page."""
    lines = [
        "# The keys of a scene",
        "",
        (
            "Made by `hpc-gfmd help scene --markdown`. Lengths are in the unit of the surface,"
            ' pressures in that of the moduli, or both are texts with units ("100 um", "50 GPa").'
        ),
    ]
    columns = ["", "| key | meaning | default | unit | allowed |", "|---|---|---|---|---|"]
    for section in sections(names):
        lines += ["", f"## {section.heading}", "", section.about, *columns]
        lines += [
            f"| `{key.name}` | {key.meaning} | {key.default or 'must be given'} | {key.unit} |"
            f" {key.allowed} |"
            for key in section.keys
        ]
    return "\n".join(lines)


def _key(name: str, field: Any, known: Any = ()) -> Key:
    extra, plain = field.json_schema_extra, field.default
    plain = None if plain is PydanticUndefined else toml(plain)
    default = extra["said"] or ("none" if plain == "null" else plain)
    what = extra["allowed"] + (f": {', '.join(sorted(known))}" if known else "")
    example = extra["example"]
    if example is None and field.default is not PydanticUndefined:
        example = field.default
    return Key(name, field.description, what, extra["unit"], default, example)


def _chosen(key: str | None, found: list[Section]) -> list[Section]:
    if key is None or key in {section.table for section in found if section.table}:
        return [section for section in found if key in (None, section.table)]
    table, _, name = key.rpartition(".")
    fits = [
        replace(s, keys=tuple(key for key in s.keys if key.name == name))
        for s in found
        if table in ("", s.table)
    ]
    fits = [section for section in fits if section.keys]
    if not fits:
        known = {
            name
            for s in found
            for name in (
                s.table,
                *(k.name for k in s.keys),
                *(f"{s.table}.{k.name}" for k in s.keys),
            )
            if name
        }
        why = not_modelled(key) or f"which is no key of a scene, nearest: {nearest(key, known)}"
        raise SceneError(f"help scene: found {printable(key)}, {why}")
    return fits
