"""Templates: scenes that run, with a comment on every key, made from the models of the keys."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .reference import Key, sections, toml
from .surface import KINDS

COLUMN = 40  # where comments begin
CHOSEN = {  # keys that are set in every template, besides those that must be given
    "load": {"p_star": [0.01, 0.1]},
    "solver": {"accuracy": 1e-3},
    "output": {"path": "contact.h5", "fields": ["pressure", "gap"]},
}
# keys that are set in the template of a kind, besides those that must be given
CHOSEN_OF_KIND = {
    "spectrum": {"wavelengths": [0.5, 0.25, 0.01], "hurst": [-1.0, 0.8], "g_rms": 1.0}
}


@dataclass
class Suggestion:
    """Values that a height map suggests for the keys of [surface]."""

    values: dict = field(default_factory=dict)  # keys to be set
    # keys whose values the file itself has; shown as comments
    from_file: dict = field(default_factory=dict)
    # reasons for both, shown instead of the meaning of the key
    why: dict = field(default_factory=dict)
    # keys that neither the file nor the user has given, and that only the user knows
    missing: list = field(default_factory=list)
    silent: list = field(default_factory=list)  # names of the files that lack some of these
    # keys whose values were chosen although only the user knows them
    open: list = field(default_factory=list)
    about: list = field(default_factory=list)  # notes on the map, one line each
    unit: str = ""  # "m" if lengths have units, else ""


def template(kind: str, tables: Mapping[str, Any], suggestion: Suggestion, head: str) -> str:
    """Return a scene as TOML with a comment on every key; keys that must be given and are not in
    `tables` have their examples, others are comments.
    """
    surface = {"kind": kind} | tables.get("surface", {}) | suggestion.values
    values = {"": tables, **tables, "surface": surface}
    keys_of_kind = {
        key.name for section in sections() if section.kind == kind for key in section.keys
    }
    lines = [f"# {line}" for line in (head, *suggestion.about)]
    previous_table = None
    for section in sections():
        if section.kind not in ("", kind):
            continue
        table = section.table
        if table and table != previous_table:
            lines += ["", _beside(f"[{table}]", section.title)]
        previous_table = table
        is_common = table == "surface" and not section.kind
        lines += [
            _line(key, values.get(table, {}), suggestion if table == "surface" else Suggestion())
            for key in section.keys
            if not (is_common and key.name in keys_of_kind)  # described with the kind
        ]
    return "\n".join(lines) + "\n"


def _line(key: Key, values: Mapping[str, Any], suggestion: Suggestion) -> str:
    """Return the line of a key: set, or as a comment with its default and an example."""
    value = values.get(key.name, key.example if key.default is None else None)
    if key.name == "kind":
        other_kinds = ", ".join(toml(kind) for kind in KINDS if kind != value)
        return _beside(f"kind = {toml(value)}", f"or {other_kinds}")
    reason = suggestion.why.get(key.name)
    if value is not None:
        return _beside(f"{key.name} = {toml(value)}", reason or key.meaning)
    shows_default = not reason and key.default not in ("none", toml(key.example))
    default = f" (default: {key.default})" if shows_default else ""
    example = toml(suggestion.from_file.get(key.name, key.example))
    return _beside(f"# {key.name} = {example}", (reason or key.meaning) + default)


def _beside(setting: str, comment: str) -> str:
    """Return a setting with a comment beside it, in one line; comments start in column COLUMN."""
    return f"{setting + '  ':<{COLUMN}}# {comment}"
