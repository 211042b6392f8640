"""`hpc-gfmd init`: a commented scene that runs."""

import os
import tomllib
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..util.errors import SceneError, one_line

DEFAULT = "self-affine"


def add_parser(subparsers: Any) -> ArgumentParser:
    parser = subparsers.add_parser(
        "init",
        help="write a commented scene that runs",
        description=(
            "Write a scene with a comment on every key: for a kind of surface (self-affine, wave,"
            " sphere) or for a height map, which is read to see what it says of sizes and units,"
            " whether points are missing, whether it is tilted and has an edge."
        ),
    )
    parser.add_argument(
        "what",
        metavar="KIND|MAP",
        nargs="?",
        default=DEFAULT,
        help=f"kind of surface or a file (default: {DEFAULT})",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="SCENE.toml",
        default="scene.toml",
        help="scene file (default: %(default)s)",
    )
    parser.add_argument(
        "--set",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="what the scene is to say: table.key=value",
    )
    parser.add_argument("--force", action="store_true", help="overwrite a scene that is there")
    return parser


def main(args: Namespace) -> int:
    """Write it and say what is still to be filled in; raises SceneError if it cannot be written or
    the map cannot be read."""
    path = Path(args.output)
    if path.exists() and not args.force:
        raise SceneError(
            f"-o: found {path}, which exists, allowed: another path, or --force to overwrite it"
        )
    if not path.parent.is_dir():
        raise SceneError(f"-o: the folder {path.parent} does not exist")
    text, missing, about = compose(args.what, path, args.set)
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise SceneError(f"-o: cannot write {path}: {one_line(str(error))}") from None
    print(*about, sep="\n", end="\n" * bool(about))
    print(
        f"{path}: hpc-gfmd run {path}"
        if not missing
        else (
            f"{path}: before it runs it needs {' and '.join(f'surface.{key}' for key in missing)},"
            f" which {args.what} does not say"
        )
    )
    return 0


def compose(
    what: str, path: Path, overrides: Sequence[str] = ()
) -> tuple[str, list[str], list[str]]:
    """(TOML text of a scene that will lie at `path`, keys of [surface] that have to be filled in,
    what a height map shows, a line each). Raises SceneError."""
    from ..scene import Scene
    from ..scene.load import apply_override
    from ..scene.surface import KINDS
    from ..scene.template import template

    tables: dict[str, Any] = {}
    for override in overrides:
        apply_override(tables, override)
    given = {
        f"{table}.{key}": value
        for table, keys in tables.items()
        if isinstance(keys, dict)
        for key, value in keys.items()
    }
    said, why, missing, about, head = (
        {},
        {},
        [],
        [],
        [f"hpc-gfmd run {path.name}. Lines that begin with # show defaults and examples."],
    )
    if what in KINDS and what != "file":
        kind = what
    elif Path(what).is_file():
        kind, (found, values) = "file", _of_map(what, path, given)
        given = (
            {"title": Path(what).name}
            | given
            | {f"surface.{key}": value for key, value in values.items()}
        )
        said, why = (
            {f"surface.{key}": value for key, value in part.items()}
            for part in (found.said, found.why)
        )
        missing = found.missing
        about = [f"{what}: {line}" for line in found.about]
        from ..surface.quality import NO_MODULUS

        if found.unit and not any(key.startswith("material.") for key in given):
            about.append(f"{what}: {NO_MODULUS}")
    else:
        kinds = ", ".join(kind for kind in KINDS if kind != "file")
        raise SceneError(
            f"init: found {what}, allowed: a kind of surface ({kinds}) or the path of a height map"
        )
    text = template(kind, given, said, why, [*head, *about])
    if not missing:
        data = tomllib.loads(text)
        for override in overrides:
            apply_override(data, override)  # a key that no scene has is in no template
        Scene.from_dict(data, "init", path.parent)
    return text, missing, about


def _of_map(what: str, path: Path, given: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
    """(Suggestion, values of [surface]) for a height map; its path counts from the folder of the
    scene."""
    from ..scene import Scene
    from ..surface.suggest import suggestion

    chosen = {
        key.removeprefix("surface."): value
        for key, value in given.items()
        if key.startswith("surface.")
    }

    def make(values: dict[str, Any]) -> Any:
        surface = {"kind": "file", "path": os.path.abspath(what)} | values
        return Scene.from_dict({"surface": surface, "load": {"p_star": 1.0}}, "init").surface

    found = suggestion(make, chosen)
    return found, {"path": os.path.relpath(what, path.parent)} | found.values
