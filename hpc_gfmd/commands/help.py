"""`hpc-gfmd help`: what the commands do, and every key of a scene."""

from argparse import ArgumentParser, Namespace
from typing import Any

from ..errors import SceneError


def add_parser(subparsers: Any) -> ArgumentParser:
    parser = subparsers.add_parser(
        "help",
        help="every key of a scene: default, unit, meaning",
        description=(
            "Explain the keys of a scene (help scene), one table or key of it (help scene solver,"
            " help scene solver.accuracy), or a command (help run)."
        ),
    )
    parser.add_argument(
        "topic", metavar="scene|COMMAND", nargs="?", help="what about (default: the commands)"
    )
    parser.add_argument("key", metavar="KEY", nargs="?", help="a table or a key of a scene")
    parser.add_argument(
        "--markdown", action="store_true", help="all keys of a scene as a page in Markdown"
    )
    return parser


def main(args: Namespace) -> int:
    """Print; raises SceneError for a topic or a key that there is not."""
    if args.topic != "scene":
        return _of_command(args.topic)
    from ..registry import distribution_names, observable_names, solver_names
    from ..scene.reference import markdown, text

    names = {
        "solver.name": solver_names(),
        "output.observables": observable_names(),
        "output.distributions": distribution_names(),
    }
    print(markdown(names) if args.markdown else text(args.key, names))
    return 0


def _of_command(name: str | None) -> int:
    from ..cli import COMMANDS, build_parser

    known = (*COMMANDS, "restart")  # which lives with run
    if name not in (None, *known):
        raise SceneError(f"help: found {name!r}, allowed: scene, {', '.join(known)}")
    build_parser().parse_args([*([name] if name else []), "--help"])
    return 0
