"""Run a measurement from any folder, also under mpirun: `python scripts/bench ITEM`."""

import sys
from pathlib import Path

if not __package__:  # run by its path
    sys.path[0] = str(Path(__file__).resolve().parents[1])

from bench.command import make_parser
from hpc_gfmd.commands.cli import main

if __name__ == "__main__":
    sys.exit(main(script=make_parser))
