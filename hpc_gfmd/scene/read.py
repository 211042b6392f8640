"""Reading of scene files, with overrides from a command line."""

import os
import tomllib
from collections.abc import Iterable
from os import PathLike
from pathlib import Path
from typing import Any

from ..util.errors import SceneError, one_line
from .explain import printable, shown
from .history import refuse_relaxation
from .model import Scene, parse_toml
from .settings import LOADS

# keys of which a table has one: an override of one removes the others
ALTERNATIVES = {"load": LOADS, "solver": ("accuracy", "residual")}


def load_scene(
    path: str | PathLike, overrides: Iterable[str] = (), needs_load: bool = True
) -> Scene:
    """Read and validate a scene file, with overrides; paths of maps, relative to its folder, become
    absolute. Without needs_load, for a law, a missing [load] gets some load.
    """
    origin = printable(str(path))
    text = _read(path, origin)
    try:
        data = parse_toml(text, origin)
    except SceneError as error:
        raise SceneError(f"{error}{_if_a_map(origin)}") from None
    for override in overrides:
        apply_override(data, override)
    if not needs_load:
        refuse_relaxation(data, origin)
        data.setdefault("load", {"p_star": 0.01})
    return Scene.from_dict(data, origin, Path(path).parent)


def with_overrides(scene: Scene, overrides: Iterable[str], table: str) -> Scene:
    """Return a scene with changed keys ("table.key=value") in the one table that allows it."""
    data = scene.model_dump(exclude_none=True)
    for override in overrides:
        if not override.strip().startswith(f"{table}."):
            raise SceneError(f"--set: found {shown(override)}, allowed: {table}.key=value")
        apply_override(data, override)
    return Scene.from_dict(data, "--set") if overrides else scene


def _read(path: str | PathLike, origin: str) -> str:
    if not os.path.isfile(path):
        raise SceneError(f"{origin}: no such file, allowed: a scene file in TOML")
    try:
        text = Path(path).read_text("utf-8-sig")
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or one_line(str(error))
        raise SceneError(
            f"{origin}: cannot read this scene file: {why}, allowed: UTF-8 text in TOML"
            + _if_a_map(origin)
        ) from None
    if not text.strip():
        raise SceneError(f"{origin}: found an empty file, allowed: at least [surface] and [load]")
    return text


def _if_a_map(origin: str) -> str:
    """Return what to do if a file that is no scene is a height map; "" for one in TOML."""
    if origin.endswith(".toml"):
        return ""
    return f"; hpc-gfmd init {origin} writes a scene for a height map"


def apply_override(data: dict[str, Any], override: str) -> None:
    """Set one key in the tables, in place: "table.key=value", "key=value" or "table={...}"; what is
    not TOML is text. One of alternatives (kinds of load; accuracy, residual) removes the others.
    """
    key, equals, value = override.partition("=")
    path = [part.strip() for part in key.split(".")]
    *tables, name = path
    if not equals or not all(path):
        raise SceneError(f"--set: found {shown(override)}, allowed: table.key=value")
    table = data
    for depth, part in enumerate(tables, 1):
        table = table.setdefault(part, {})
        if not isinstance(table, dict):
            outer = ".".join(path[:depth])
            raise SceneError(
                f"--set: found {shown(key)}, but {printable(outer)} is no table, "
                "allowed: table.key=value"
            )
    alternatives = ALTERNATIVES.get(".".join(tables), ())
    for alternative in alternatives if name in alternatives else ():
        table.pop(alternative, None)
    table[name] = _value(value.strip())


def _value(text: str) -> Any:
    """Return the value that a text stands for in TOML, or the text itself if it is not TOML."""
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return parsed["value"] if len(parsed) == 1 else text
