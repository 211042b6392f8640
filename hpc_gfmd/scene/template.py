"""A scene that runs, with a comment on every key: what the models say of themselves."""

from collections.abc import Mapping
from typing import Any

from .reference import Key, Section, sections, toml
from .surface import KINDS

COLUMN = 40  # where comments begin
CHOSEN = {
    "load.p_star": [0.01, 0.1],
    "solver.accuracy": 1e-3,
    "output.path": "contact.h5",
    "output.fields": ["pressure", "gap"],
}  # beside what must be given


def template(
    kind: str,
    values: Mapping[str, Any],
    said: Mapping[str, Any],
    why: Mapping[str, str],
    head: list[str],
) -> str:
    """TOML of a scene with this kind of surface.

    values: {"table.key": value} that are set, beside CHOSEN and what must be given; said: values
    that hold although they are not set, shown as comments; why: comments that stand in place of the
    meaning; head: the first lines.
    """
    loaded = any(path.startswith("load.") for path in values)
    chosen = {
        path: value for path, value in CHOSEN.items() if not (loaded and path.startswith("load."))
    }
    values = chosen | {"title": kind, "surface.kind": kind} | dict(values)
    lines, last = [f"# {line}" for line in head], None
    for section in sections():
        if section.kind in ("", kind):
            if section.table and section.table != last:
                lines += ["", _beside(f"[{section.table}]", section.title)]
            last = section.table
            lines += [
                _line(section, key, values, said, why)
                for key in section.keys
                if not _again(section, key, kind)
            ]
    return "\n".join(lines) + "\n"


def _again(section: Section, key: Key, kind: str) -> bool:
    """Whether the section of the kind says it otherwise."""
    return (
        section.table == "surface"
        and not section.kind
        and any(key.name == other.name for s in sections() if s.kind == kind for other in s.keys)
    )


def _line(
    section: Section,
    key: Key,
    values: Mapping[str, Any],
    said: Mapping[str, Any],
    why: Mapping[str, str],
) -> str:
    path = f"{section.table}.{key.name}" if section.table else key.name
    value = values.get(path, key.example if key.default is None else None)
    if key.name == "kind":
        others = ", ".join(toml(other) for other in KINDS if other != value)
        return _beside(f"kind = {toml(value)}", f"or {others}")
    comment = why.get(path, key.meaning)
    if value is not None:
        return _beside(f"{key.name} = {toml(value)}", comment)
    default = (
        ""
        if path in why or key.default in ("none", toml(key.example))
        else f" (default: {key.default})"
    )
    return _beside(f"# {key.name} = {toml(said.get(path, key.example))}", comment + default)


def _beside(setting: str, comment: str) -> str:
    return f"{setting + '  ':<{COLUMN}}# {comment}"
