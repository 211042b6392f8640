"""Standard streams that are closed when a command starts, or break while it runs."""

import os
from contextlib import suppress
from typing import Any


def occupy_standard_descriptors() -> None:
    """Open the null device for each of the descriptors 0, 1 and 2 that is closed.

    Otherwise the next file to be opened, such as a result, gets the descriptor of standard output,
    and a library that prints writes into it.
    """
    while (descriptor := os.open(os.devnull, os.O_RDWR)) < 3:
        pass
    os.close(descriptor)


def discard(stream: Any) -> None:
    """Redirect a broken stream to the null device, so that flushing it at exit does not fail: the
    recipe of Python's documentation for SIGPIPE.
    """
    with suppress(OSError, ValueError, AttributeError):
        descriptor = stream.fileno()
        devnull = os.open(os.devnull, os.O_WRONLY)
        os.dup2(devnull, descriptor)
        os.close(devnull)
