"""Standard streams that are closed when a command starts, or break while it runs."""

import os
from contextlib import suppress
from typing import Any


def occupy_standard_descriptors() -> None:
    """Open the null device for closed descriptors 0, 1, 2: else a result might get that of standard
    output, and prints would go into it.
    """
    while (descriptor := os.open(os.devnull, os.O_RDWR)) < 3:
        pass
    os.close(descriptor)


def discard(stream: Any) -> None:
    """Redirect a broken stream to the null device, so that flushing it at exit does not fail."""
    with suppress(OSError, ValueError, AttributeError):
        descriptor = stream.fileno()
        devnull = os.open(os.devnull, os.O_WRONLY)
        os.dup2(devnull, descriptor)
        os.close(devnull)
