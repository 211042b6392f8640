"""`hpc-gfmd help`: what the commands do, every key of a scene, every number of a result."""

from argparse import Namespace

from ..util.errors import SceneError


def main(args: Namespace) -> int:
    """Print the help; raises SceneError for a topic or a key that there is not."""
    if args.key is not None and (args.topic != "scene" or args.markdown):
        raise SceneError(f"help: found {args.key}, allowed: a key after scene, without --markdown")
    if args.topic == "observables":
        print(_numbers("| `{}` | {} | {} | {} |" if args.markdown else "{:<36} {:<18} {:<14} {}"))
        return 0
    if args.topic != "scene":
        return _of_command(args.topic)
    from ..contact import all_distributions, observable_names
    from ..scene.reference import markdown, text
    from ..solvers import solver_names

    names = {
        "solver.name": solver_names(),
        "output.observables": observable_names(),
        "output.distributions": all_distributions(),
    }
    print(markdown(names) if args.markdown else text(args.key, names))
    return 0


def _numbers(row: str) -> str:
    """List all numbers of a load, each by `row`: name, unit, the name it is asked for by,
    meaning."""
    from ..contact import all_numbers, default_observables, observable_names, observables_named

    groups = {name: observables_named([name]) for name in observable_names()}
    asked = {
        one: name
        for name in sorted(groups, key=lambda name: len(groups[name]))
        for one in groups[name]
        if one not in default_observables()
    }
    page = row.startswith("|")
    return "\n".join(
        [
            *["# The numbers of a load", ""] * page,
            "The attributes of each load in a result; length: in the unit of the surface,"
            " pressure: in that of the moduli. Those with a name under `asked for` are there where"
            " output.observables names it, arrays where output.distributions does, all others"
            " always.",
            "",
            row.format("name", "unit", "asked for", "meaning").replace("`", ""),
            *["|---|---|---|---|"] * page,
            *(
                row.format(name, unit, asked.get(name, ""), about)
                for name, (about, unit) in all_numbers().items()
            ),
        ]
    )


def _of_command(name: str | None) -> int:
    from .cli import COMMANDS, build_parser

    if name not in (None, *COMMANDS):
        raise SceneError(
            f"help: found {name!r}, allowed: scene, observables, {', '.join(COMMANDS)}"
        )
    build_parser().parse_args([*([name] if name else []), "--help"])
    return 0
