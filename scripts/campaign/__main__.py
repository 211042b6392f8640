"""`python scripts/campaign`, from any folder."""

import sys
from pathlib import Path

if not __package__:  # started by its path
    sys.path[0] = str(Path(__file__).resolve().parents[1])

from campaign.run import main

if __name__ == "__main__":
    sys.exit(main())
