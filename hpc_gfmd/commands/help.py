"""`hpc-gfmd help`: what the commands do, every key of a scene, every number of a result."""

from argparse import ArgumentParser, Namespace

from ..util.errors import SceneError

HELP = "every key of a scene: default, unit, meaning"
DESCRIPTION = """
Explain the keys of a scene (help scene), of one table or a single key (help scene solver, help
scene solver.accuracy), the numbers of a result (help observables), or a command (help run)."""

ABOUT_NUMBERS = (
    "Attributes of each load in a result. length: in the unit of the surface; pressure: in that of"
    " the moduli. Numbers with a name under `on request` are computed if output.observables (for"
    " arrays output.distributions) has that name, all others always."
)


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the command to its parser."""
    parser.add_argument(
        "topic",
        metavar="scene|observables|COMMAND",
        nargs="?",
        help="what to explain (default: the commands)",
    )
    parser.add_argument("key", metavar="KEY", nargs="?", help="a table or a key of a scene")
    parser.add_argument(
        "--markdown", action="store_true", help="scene, observables: print a page in Markdown"
    )


def main(args: Namespace) -> int:
    """Print help on commands, scene keys or numbers; returns 0."""
    if args.key is not None and (args.topic != "scene" or args.markdown):
        raise SceneError(f"help: found {args.key}, allowed: a key after scene, without --markdown")
    if args.topic == "scene":
        print(_scene_keys(args.key, args.markdown))
    elif args.topic == "observables":
        print(_numbers_page() if args.markdown else _numbers_text())
    else:
        _print_command_help(args.topic)
    return 0


def _scene_keys(key: str | None, markdown: bool) -> str:
    """Return help on a key or table of a scene, or on all; as Markdown always on all."""
    from ..contact import all_distributions, observable_names
    from ..scene import reference
    from ..solvers import solver_names

    names = {
        "solver.name": solver_names(),
        "output.observables": observable_names(),
        "output.distributions": all_distributions(),
    }
    return reference.markdown(names) if markdown else reference.text(key, names)


def _number_rows() -> list[tuple[str, str, str, str]]:
    """List (name, unit, name in output.observables or "", meaning) of all numbers of a load."""
    from ..contact import all_numbers, default_observables, observable_names, observables_named

    groups = {name: observables_named([name]) for name in observable_names()}
    requested_as = {}
    for group in sorted(groups, key=lambda name: len(groups[name])):
        for name in groups[group]:
            if name not in default_observables():
                requested_as[name] = group
    return [
        (name, unit, requested_as.get(name, ""), meaning)
        for name, (meaning, unit) in all_numbers().items()
    ]


def _numbers_text() -> str:
    rows = [("name", "unit", "on request", "meaning"), *_number_rows()]
    lines = [
        f"{name:<36} {unit:<18} {requested_as:<14} {text}"
        for name, unit, requested_as, text in rows
    ]
    return "\n".join([ABOUT_NUMBERS, "", *lines])


def _numbers_page() -> str:
    rows = [
        f"| `{name}` | {unit} | {requested_as} | {text} |"
        for name, unit, requested_as, text in _number_rows()
    ]
    head = ["| name | unit | on request | meaning |", "|---|---|---|---|"]
    return "\n".join(["# The numbers of a load", "", ABOUT_NUMBERS, "", *head, *rows])


def _print_command_help(name: str | None) -> None:
    """Print the help of a command, and exit the process, or of the program if name is None."""
    from .cli import COMMANDS, build_parser

    if name is None:
        build_parser().print_help()
        return
    if name not in COMMANDS:
        raise SceneError(
            f"help: found {name!r}, allowed: scene, observables, {', '.join(COMMANDS)}"
        )
    build_parser().parse_args([name, "--help"])
