"""Run the campaign from any folder: `python scripts/campaign`."""

import os
import sys
from pathlib import Path

if not __package__:  # run by its path
    sys.path[0] = str(Path(__file__).resolve().parents[1])

from campaign import run

if __name__ == "__main__":
    os.environ["OMP_NUM_THREADS"] = "1"
    sys.exit(run.main(run.make_parser().parse_args()))
