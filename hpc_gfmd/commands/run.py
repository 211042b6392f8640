"""`hpc-gfmd run`: solve a scene."""

from argparse import Namespace


def main(args: Namespace) -> int:
    """Solve a scene; the exit code tells whether every step converged."""
    from ..runs.simulation import run_scene

    return run_scene(
        args.scene, args.set, args.output, force=args.force, quiet=args.quiet
    ).exit_code
