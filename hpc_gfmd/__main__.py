"""`python -m hpc_gfmd` is the command hpc-gfmd."""

import sys

from .commands.cli import main

sys.exit(main())
