"""`hpc-gfmd run`: solve a scene."""

from argparse import ArgumentParser, Namespace

from .common import add_file, add_overrides, add_quiet

HELP = "solve a scene"
DESCRIPTION = """
Solve a scene and write its result file, on one process or under mpirun/srun. Exit code 3: a load
did not converge."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the command to its parser."""
    add_file(parser, "scene", metavar="SCENE.toml", help="scene file")
    add_file(
        parser,
        "-o",
        "--output",
        metavar="OUT.h5",
        help="result file, instead of output.path of the scene",
    )
    add_overrides(parser, "change a setting of the scene: table.key=value")
    parser.add_argument(
        "--force",
        action="store_true",
        help="start anew: overwrite an interrupted run or the result of another scene",
    )
    add_quiet(parser)


def main(args: Namespace) -> int:
    """Solve a scene and write its result; returns its exit code. Collective.

    3 means that a load did not converge.
    """
    from ..runs.simulation import run_scene

    return run_scene(
        args.scene, args.set, args.output, force=args.force, quiet=args.quiet
    ).exit_code
