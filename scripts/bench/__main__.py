"""`python scripts/bench ITEM`, also under mpirun: measures speed."""

import sys
from pathlib import Path

sys.path[0] = str(Path(__file__).resolve().parents[1])  # of the package `bench`

from bench.command import main  # noqa: E402

if __name__ == "__main__":
    sys.exit(main())
