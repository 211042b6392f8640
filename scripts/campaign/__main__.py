"""`python scripts/campaign`, from any folder."""

import os
import sys
from pathlib import Path

if not __package__:  # started by its path
    sys.path[0] = str(Path(__file__).resolve().parents[1])

from campaign import calibrate, run

if __name__ == "__main__":
    os.environ["OMP_NUM_THREADS"] = "1"
    given = run.parser().parse_args()
    sys.exit((calibrate.calibrate if given.what == "calibrate" else run.main)(given))
