"""A scene file read to a Scene, with the overrides of a command line."""

import os
import tomllib
from collections.abc import Iterable
from os import PathLike
from pathlib import Path
from typing import Any

from ..util.errors import SceneError, one_line
from .explain import printable, shown
from .model import Scene, parse_toml
from .settings import LOADS

# by table, the keys of which one takes the place of another
ALTERNATIVES = {"load": LOADS, "solver": ("accuracy", "residual")}


def load_scene(path: str | PathLike, overrides: Iterable[str] = ()) -> Scene:
    """Read a scene file and apply overrides "table.key=value", each value in TOML or else a plain
    string.

    An override may replace a whole table: "load={pressure = [0.1]}". A relative surface path, in
    the file or in an override, counts from the folder of the scene file and becomes absolute.
    Raises SceneError.
    """
    origin = printable(str(path))
    data = parse_toml(_read(path, origin), origin)
    for override in overrides:
        apply_override(data, override)
    return Scene.from_dict(data, origin, Path(path).parent)


def with_overrides(scene: Scene, overrides: Iterable[str], table: str) -> Scene:
    """Return the scene with overrides "table.key=value" of that one table. Raises SceneError for
    others."""
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
        ) from None
    if not text.strip():
        raise SceneError(f"{origin}: found an empty file, allowed: at least [surface] and [load]")
    return text


def apply_override(data: dict[str, Any], override: str) -> None:
    """Change the tables by "table.key=value". Raises SceneError for another text."""
    key, equals, value = override.partition("=")
    *above, last = path = [part.strip() for part in key.split(".")]
    if not equals or not all(path):
        raise SceneError(f"--set: found {shown(override)}, allowed: table.key=value")
    table = data
    for depth, part in enumerate(above, 1):
        table = table.setdefault(part, {})
        if not isinstance(table, dict):
            before = ".".join(path[:depth])
            raise SceneError(
                f"--set: found {shown(key)}, but {printable(before)} is no table, "
                "allowed: table.key=value"
            )
    alternatives = ALTERNATIVES.get(".".join(above), ())
    for name in alternatives if last in alternatives else ():
        table.pop(name, None)
    table[last] = _value(value.strip())


def _value(text: str) -> Any:
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return parsed["value"] if len(parsed) == 1 else text
