"""Whether this process serves a notebook."""

import sys


def in_notebook() -> bool:
    """Return whether this process is the kernel of a Jupyter notebook (not IPython's shell)."""
    ipython = sys.modules.get("IPython")
    return ipython is not None and hasattr(ipython.get_ipython(), "kernel")
