"""`hpc-gfmd restart`: resume an interrupted run."""

from argparse import ArgumentParser, Namespace

from .common import add_file, add_overrides, add_quiet

HELP = "resume an interrupted run"
DESCRIPTION = "Resume the interrupted run of a result file on any number of ranks."


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the command to its parser."""
    add_file(parser, "file", metavar="OUT.h5", help="result file of the interrupted run")
    add_overrides(parser, "change a setting of the machine, such as machine.wall_seconds=3600")
    add_quiet(parser)


def main(args: Namespace) -> int:
    """Resume an interrupted run and write its result; returns its exit code. Collective."""
    from ..runs.simulation import restart

    return restart(args.file, args.set, quiet=args.quiet).exit_code
