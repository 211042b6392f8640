"""Reference of all keys of a scene, as text and as a page, from the models that check them."""

import json
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass, replace
from inspect import get_annotations
from typing import Any

from ..util.errors import SceneError
from .explain import nearest, printable
from .height_maps import OWN_KEYS, RoughBody
from .model import Scene
from .not_modelled import not_modelled
from .surface import KINDS, SurfaceTable
from .table import about, allowed_of

COMMON = SurfaceTable.__mro__
BODIES = "[[surface.bodies]]"
UNITS = {
    "length": "in the unit of the surface, or with a unit",
    "pressure": "in the unit of the moduli, or with a unit",
    "time": "in the unit of all other times, or with a unit",
    "work": "in the unit of the moduli times that of the surface, or with a unit",
    "force": "in the unit of the moduli times that of the surface squared, or with a unit",
}


@dataclass(frozen=True)
class Key:
    """What help and templates show of a key of a table."""

    name: str
    meaning: str
    allowed: str  # in words
    unit: str = ""  # "length", "pressure", ..., the name of a unit, or ""
    default: str | None = None  # in TOML or in words; None if the key must be given
    example: Any = None  # for templates, by default the default; None if there is none

    @property
    def facts(self) -> str:
        """Default, unit and allowed values, in words."""
        default = "must be given" if self.default is None else f"default {self.default}"
        unit = UNITS.get(self.unit, self.unit and f"in {self.unit}")
        return "; ".join(part for part in (default, unit, self.allowed) if part)


KIND = Key("kind", "which surface", ", ".join(map(json.dumps, KINDS)), example="self-affine")


@dataclass(frozen=True)
class Section:
    """The keys of a table of a scene, or of a kind of surface, with a description."""

    table: str  # "" for keys before the first table
    heading: str  # such as "[load]" or "[surface] of kind = ..."
    title: str  # what the table is, in a few words
    about: str  # the same in sentences
    keys: tuple[Key, ...]
    kind: str = ""  # kind of surface, or BODIES for the table of a body; else ""


def sections(names: Mapping[str, Any] | None = None) -> list[Section]:
    """Return the sections of all tables; `names`: lists of values that the models do not know."""
    names = names or {}
    fields = dict(Scene.model_fields)
    title = _key("title", fields.pop("title"))
    listed = [Section("", "title", "the scene", "A key before the first table.", (title,))]
    for table, field in fields.items():
        models: dict[str, Any] = {"": field.annotation}
        if table == "surface":
            models = {"": SurfaceTable, **KINDS}
        for kind, model in models.items():
            keys = [
                _key(name, model.model_fields[name], names.get(f"{table}.{name}"))
                for name in _names(model)
                if name != "kind"
            ]
            if model is SurfaceTable:
                keys.insert(0, KIND)
            heading = f'[{table}] of kind = "{kind}"' if kind else f"[{table}]"
            about_model = " ".join(model.__doc__.split())
            title_of_table = field.description or ""
            listed.append(Section(table, heading, title_of_table, about_model, tuple(keys), kind))
        if table == "surface":
            own_keys = tuple(_key(name, RoughBody.model_fields[name]) for name in OWN_KEYS)
            about_body = " ".join((RoughBody.__doc__ or "").split())
            listed.append(
                Section(table, BODIES, field.description or "", about_body, own_keys, BODIES)
            )
    return listed


def toml(value: Any) -> str:
    """Return a value as TOML, on one line; it must not hold None, and a date becomes a text."""
    if isinstance(value, dict):
        items = (
            f"{key if key.isidentifier() else toml(key)} = {toml(item)}"
            for key, item in value.items()
        )
        return f"{{{', '.join(items)}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml, value))}]"
    # as JSON has it, but for infinity; dates, which no key takes, become texts
    return (
        repr(value)
        if isinstance(value, float)
        else json.dumps(value, ensure_ascii=False, default=str)
    )


def text(key: str | None = None, names: Mapping[str, Any] | None = None) -> str:
    """Return the description of all keys, or of "solver", "accuracy" or "solver.accuracy"."""
    lines = []
    indent = " " * 22
    for section in _chosen(key, sections(names)):
        lines += ["", *textwrap.wrap(f"{section.heading}: {section.about}", 100)]
        for entry in section.keys:
            for start, words in ((f"  {entry.name:<18}  ", entry.meaning), (indent, entry.facts)):
                lines += textwrap.wrap(words, 100, initial_indent=start, subsequent_indent=indent)
    return "\n".join(lines[1:])


def markdown(names: Mapping[str, Any] | None = None) -> str:
    """Return the description of all keys as a page in Markdown. `names` is as for `sections`."""
    lines = [
        "# The keys of a scene",
        "",
        (
            "Made by `hpc-gfmd help scene --markdown`. Lengths are in the unit of the surface,"
            ' pressures in that of the moduli, or all have units ("100 um", "50 GPa").'
        ),
    ]
    columns = ["", "| key | meaning | default | unit | allowed |", "|---|---|---|---|---|"]
    for section in sections(names):
        lines += ["", f"## {section.heading}", "", section.about, *columns]
        lines += [
            f"| `{key.name}` | {key.meaning} | {key.default or 'must be given'} | {key.unit} |"
            f" {_listed(key.allowed)} |"
            for key in section.keys
        ]
    return "\n".join(lines)


def _listed(allowed: str) -> str:
    """Return allowed values as a cell; of over 120 characters only what is before the colon."""
    noun = allowed.partition(":")[0]
    return allowed if len(allowed) <= 120 else f"{noun}, of [these](observables.md)"


def _names(model: Any) -> list[str]:
    """Return the keys of a table in order, of a kind of surface those that it defines."""
    classes = [base for base in reversed(model.__mro__) if base is model or base not in COMMON]
    return list(dict.fromkeys(name for base in classes for name in get_annotations(base)))


def _key(name: str, field: Any, names: Any = ()) -> Key:
    """Return the Key of a field; `names`: allowed values that its type does not list."""
    extra = about(field)
    default = extra["default_text"]
    if not default and not field.is_required():
        default = "none" if field.default is None else toml(field.default)
    allowed = allowed_of(field) + (f": {', '.join(sorted(names))}" if names else "")
    return Key(name, field.description, allowed, extra["unit"], default or None, extra["example"])


def _chosen(key: str | None, listed: list[Section]) -> list[Section]:
    """Return the sections of a table, or those with a key, with this key alone; None: all."""
    if key is None:
        return listed
    if tables := [section for section in listed if key and section.table == key]:
        return tables
    table, _, name = key.rpartition(".")
    parts = [
        replace(section, keys=keys)
        for section in listed
        if table in ("", section.table)
        and (keys := tuple(entry for entry in section.keys if entry.name == name))
    ]
    if not parts:
        raise SceneError(f"help scene: found {printable(key)}, {_hint(key, listed)}")
    return parts


def _hint(key: str, listed: list[Section]) -> str:
    """Return what an unknown key may mean: physics that is not modelled, or a similar key."""
    names = {section.table for section in listed} - {""}
    for section in listed:
        for entry in section.keys:
            names |= {entry.name, f"{section.table}.{entry.name}"}
    similar = nearest(key, names)
    return not_modelled(key) or (
        "which is no key of a scene" + (f", nearest: {similar}" if similar else "")
    )
