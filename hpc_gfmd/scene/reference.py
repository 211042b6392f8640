"""All keys of a scene with what their models say of them: as text, and as a page of the
documentation."""

import json
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ..util.errors import SceneError
from .explain import nearest, printable
from .model import Scene
from .not_modelled import not_modelled
from .surface import KINDS, Surface
from .table import about, allowed_of

UNITS = {
    "length": "in the unit of the surface, or with a unit",
    "pressure": "in the unit of the moduli, or with a unit",
    "work": "in the unit of the moduli times that of the surface, or with a unit",
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
    """A table, or a kind of surface; kind: "" for all kinds and for other tables; heading: how a
    scene writes it."""

    table: str
    heading: str
    title: str
    about: str
    keys: tuple[Key, ...]
    kind: str = ""


def sections(names: Mapping[str, Any] | None = None) -> list[Section]:
    """List all tables and kinds of surface; names: those that a key takes, which the scene does not
    know: {"output.observables": [...]}."""
    fields = dict(Scene.model_fields)
    title = _key("title", fields.pop("title"))
    found = [Section("", "title", "the scene", "A key before the first table.", (title,))]
    for table, field in fields.items():
        models: dict[str, Any] = {"": field.annotation}
        if table == "surface":
            models = {"": Surface, **KINDS}
        for kind, model in models.items():
            keys = [
                _key(name, model.model_fields[name], (names or {}).get(f"{table}.{name}"))
                for name in model.__annotations__  # its own, not those that every kind has
                if name != "kind"
            ]
            keys = [KIND] * (model is Surface) + keys
            heading = f"[{table}]" + f' of kind = "{kind}"' * bool(kind)
            what, meaning = field.description or "", " ".join(model.__doc__.split())
            found.append(Section(table, heading, what, meaning, tuple(keys), kind))
    return found


def toml(value: Any) -> str:
    """Write a value as a line of a scene has it."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{toml(key)} = {toml(one)}' for key, one in value.items())}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml, value))}]"
    # as JSON has it, but for infinity; dates, which no key takes, become texts
    return (
        repr(value)
        if isinstance(value, float)
        else json.dumps(value, ensure_ascii=False, default=str)
    )


def text(key: str | None = None, names: Mapping[str, Any] | None = None) -> str:
    """Write the keys for a terminal: all, or those of a table, or those of one name ("accuracy",
    "solver.accuracy"). Raises SceneError."""
    lines, indent = [], " " * 22
    for section in _chosen(key, sections(names)):
        lines += ["", *textwrap.wrap(f"{section.heading}: {section.about}", 100)]
        for entry in section.keys:
            for first, words in ((f"  {entry.name:<18}  ", entry.meaning), (indent, entry.facts)):
                lines += textwrap.wrap(words, 100, initial_indent=first, subsequent_indent=indent)
    return "\n".join(lines[1:])


def markdown(names: Mapping[str, Any] | None = None) -> str:
    """Write all keys as a page in Markdown."""
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
    """Refer to the page that has the names of a long list."""
    what = allowed.partition(":")[0]
    return allowed if len(allowed) <= 120 else f"{what}, of [these](observables.md)"


def _key(name: str, field: Any, known: Any = ()) -> Key:
    extra, value = about(field), "none" if field.default is None else toml(field.default)
    default = extra["said"] or (None if field.is_required() else value)
    what = allowed_of(field) + (f": {', '.join(sorted(known))}" if known else "")
    return Key(name, field.description, what, extra["unit"], default, extra["example"])


def _chosen(key: str | None, found: list[Section]) -> list[Section]:
    if key is None:
        return found
    if whole := [section for section in found if key and section.table == key]:
        return whole
    table, _, name = key.rpartition(".")
    fits = [
        replace(section, keys=keys)
        for section in found
        if table in ("", section.table)
        and (keys := tuple(one for one in section.keys if one.name == name))
    ]
    if not fits:
        known = {section.table for section in found} - {""}
        for section in found:
            names = [one.name for one in section.keys]
            known |= {*names, *(f"{section.table}.{name}" for name in names)}
        near = f"which is no key of a scene, nearest: {nearest(key, known)}"
        why = not_modelled(key) or near
        raise SceneError(f"help scene: found {printable(key)}, {why}")
    return fits
