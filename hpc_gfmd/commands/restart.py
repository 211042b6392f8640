"""`hpc-gfmd restart`: continue an interrupted run."""

from argparse import Namespace


def main(args: Namespace) -> int:
    """Continue a run; the exit code is that of the whole run."""
    from ..runs.simulation import restart

    return restart(args.file, args.set, quiet=args.quiet).exit_code
