"""`hpc-gfmd run` and `hpc-gfmd restart`."""

from argparse import ArgumentParser, Namespace
from typing import Any

from .common import add_set


def add_parser(subparsers: Any) -> ArgumentParser:
    parser = subparsers.add_parser(
        "run",
        help="solve a scene",
        description=(
            "Solve a scene, alone or under mpirun/srun, and write its result file. Exit code 3: a"
            " step did not converge."
        ),
    )
    parser.add_argument("scene", metavar="SCENE.toml", help="scene file")
    parser.add_argument(
        "-o", "--output", metavar="OUT.h5", help="result file instead of the scene's"
    )
    add_set(parser, "change the scene: table.key=value")
    parser.add_argument(
        "--force",
        action="store_true",
        help="begin anew whatever is there: an interrupted run, the result of another scene",
    )
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors")
    parser.set_defaults(saves=True)

    again = subparsers.add_parser(
        "restart",
        help="continue an interrupted run",
        description="Continue the interrupted run of a result file, on any number of ranks.",
    )
    again.add_argument("file", metavar="OUT.h5", help="result file that the run was to write")
    add_set(again, "change machine.key, such as wall_seconds")
    again.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors")
    again.set_defaults(main=main_restart, saves=True)
    return parser


def main(args: Namespace) -> int:
    """Solve a scene; the exit code tells whether every step converged."""
    from ..runs.simulation import run_scene

    return run_scene(
        args.scene, args.set, args.output, force=args.force, quiet=args.quiet
    ).exit_code


def main_restart(args: Namespace) -> int:
    """Continue a run; the exit code is that of the whole run."""
    from ..runs.simulation import restart

    return restart(args.file, args.set, quiet=args.quiet).exit_code
