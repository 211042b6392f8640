"""`python -m hpc_gfmd` is the command hpc-gfmd."""

import sys

from .cli import main

sys.exit(main())
