"""`python scripts/campaign`: presses walls that nobody tuned to and prints what came of it."""

import sys
from pathlib import Path

sys.path[0] = str(Path(__file__).resolve().parents[1])  # of the package `campaign`

from campaign.run import main  # noqa: E402

if __name__ == "__main__":
    sys.exit(main())
