"""`hpc-gfmd init`: a commented scene that runs."""

import os
import sys
import tomllib
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ..util.atomic import atomic_write
from ..util.errors import SceneError, one_line
from .common import add_file, add_overrides

HELP = "write a commented scene that runs"
DESCRIPTION = """
Write a scene with a comment on every key: for a kind of surface (self-affine, spectrum, wave,
sphere), for a table of a power spectrum, or for a height map, which is read to find its sizes and
units, missing points, a tilt, and whether its edges meet. Where they do not, a terminal is asked
what the map is; elsewhere boundary = "mirror" is written, a piece of a larger surface. Two height
maps are those of two rough bodies that face each other."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the command to its parser."""
    add_file(
        parser,
        "what",
        metavar="KIND|MAP",
        nargs="*",
        help="kind of surface, or one or two files with height maps (default: self-affine)",
    )
    add_file(
        parser,
        "-o",
        "--output",
        metavar="SCENE.toml",
        default="scene.toml",
        help="scene file (default: %(default)s)",
    )
    add_overrides(parser, "a setting of the scene: table.key=value")
    parser.add_argument("--force", action="store_true", help="overwrite an existing scene")


def main(args: Namespace) -> int:
    """Write a scene file and print remarks and what is still to be filled in; returns 0."""
    path = Path(args.output)
    if path.exists() and not args.force:
        raise SceneError(
            f"-o: found {path}, which exists, allowed: another path, or --force to overwrite it"
        )
    if not path.parent.is_dir():
        raise SceneError(f"-o: the folder {path.parent} does not exist")
    sources = args.what or ["self-affine"]
    draft = compose(sources, path, args.set)
    if draft.open and sys.stdin.isatty() and sys.stdout.isatty():
        boundary = _asked_boundary(sources)
        draft = compose(sources, path, [*args.set, f"surface.boundary={boundary}"])
    try:
        with atomic_write(path) as tmp:
            tmp.write_text(draft.text, encoding="utf-8")
    except OSError as error:
        raise SceneError(f"-o: cannot write {path}: {one_line(str(error))}") from None
    needs = " and ".join(f"surface.{key}" for key in draft.missing)
    silent = draft.silent or sources
    says = "does not say" if len(silent) == 1 else "do not say"
    todo = f"before it runs it needs {needs}, which {' and '.join(silent)} {says}" if needs else ""
    print(*draft.about, f"{path}: {todo or f'hpc-gfmd run {path}'}", sep="\n")
    return 0


def _asked_boundary(sources: list[str]) -> str:
    """Ask at the terminal what a map is, until the answer is one of the boundaries."""
    from ..scene.surface import CHOICES

    print(f"{' + '.join(sources)}: opposite edges do not meet. What is the map?")
    for name, meaning in CHOICES.items():
        print(f"  {name:<9} {meaning}")
    while True:
        try:
            answer = input("boundary [mirror]: ").strip().strip('"') or "mirror"
        except EOFError:
            return "mirror"
        if answer in CHOICES:
            return answer


class Draft(NamedTuple):
    """A scene in TOML, not yet written. missing: keys to fill in; about: what the map shows; open:
    chosen, but only the user knows; silent: names of those of two files that lack keys.
    """

    text: str
    missing: list[str]
    about: list[str]
    open: list[str]
    silent: list[str]


def compose(sources: str | Sequence[str], path: Path, overrides: Sequence[str] = ()) -> Draft:
    """Compose a scene at `path`; maps are read, nothing is written. sources: a kind of surface, or
    one or two maps.
    """
    from ..scene import Scene
    from ..scene.read import ALTERNATIVES, apply_override
    from ..scene.surface import KINDS
    from ..scene.template import CHOSEN, CHOSEN_OF_KIND, Suggestion, template
    from ..surface.spectrum_table import is_spectrum_table
    from ..surface.suggest_spectrum import spectrum_suggestion

    names = [sources] if isinstance(sources, str) else list(sources)
    settings: dict[str, Any] = {"title": " + ".join(Path(name).name for name in names)}
    for override in overrides:
        apply_override(settings, override)
    tables = {
        name: keys for name, keys in settings.items() if name == "title" or isinstance(keys, dict)
    }
    for name, usual in CHOSEN.items():
        keys = tables.get(name, {})
        tables[name] = keys if keys.keys() & ALTERNATIVES.get(name, ()) else usual | keys
    made = [kind for kind in KINDS if kind not in ("file", "fourier")]
    if names[0] in made and len(names) == 1:
        kind = names[0]
        user_keys = tables.get("surface", {})
        usual = {} if user_keys.keys() & {"path", "q"} else CHOSEN_OF_KIND.get(kind, {})
        suggested = Suggestion(usual | user_keys)
    elif len(names) == 1 and is_spectrum_table(names[0]):
        kind = "spectrum"
        suggested = spectrum_suggestion(names[0], path.parent, tables.get("surface", {}))
    elif len(names) <= 2 and all(Path(name).is_file() for name in names):
        kind = "file"
        suggested = _of_maps(names, path, tables)
    else:
        absent = [name for name in names if not Path(name).is_file()]
        hint = f"; there is no file {' or '.join(absent)}" if absent else ""
        raise SceneError(
            f"init: found {' '.join(names)}, allowed: a kind of surface ({', '.join(made)}) or the"
            f" path of a spectrum, of a height map, or of two{hint}"
        )
    head = f"hpc-gfmd run {path.name}. Lines that begin with # show defaults and examples."
    text = template(kind, tables, suggested, head)
    if not suggested.missing:
        data = tomllib.loads(text)
        for name, keys in settings.items():  # a key that no scene has is in no template
            data[name] = data.get(name, {}) | keys if isinstance(keys, dict) else keys
        Scene.from_dict(data, "init", path.parent)
    return Draft(text, suggested.missing, suggested.about, suggested.open, suggested.silent)


def _of_maps(maps: list[str], path: Path, tables: dict[str, Any]) -> Any:
    """Return the Suggestion for one or two maps, read with the user's tables["surface"]; without
    "material" it asks for a modulus if they have units.
    """
    from ..scene import Scene
    from ..surface.doubtful_numbers import NO_MODULUS
    from ..surface.suggest import suggestion

    def named(paths: list[str], unit: str = "") -> dict[str, Any]:
        if len(paths) == 1:
            return {"path": paths[0]}
        shift: list[Any] = ["0 um", "0 um"] if unit else [0.0, 0.0]
        of_second = {"path": paths[1], "mirrored": "x", "shift": shift}
        return {"bodies": [{"path": paths[0]}, of_second]}

    def make(values: dict[str, Any]) -> Any:
        surface = {"kind": "file"} | named([os.path.abspath(name) for name in maps]) | values
        return Scene.from_dict({"surface": surface, "load": {"p_star": 1.0}}, "init").surface

    result = suggestion(make, tables.get("surface", {}))
    result.values = (
        named([os.path.relpath(name, path.parent) for name in maps], result.unit) | result.values
    )
    if result.unit and "material" not in tables:
        result.about.append(NO_MODULUS)
    if len(maps) == 1:
        result.about = [f"{maps[0]}: {line}" for line in result.about]
    return result
