"""Standard streams that are closed or break while a command runs."""

import os
from contextlib import suppress
from typing import Any


def occupy_standard_descriptors() -> None:
    """Open the null device in place of each standard stream that is closed.

    Otherwise the next file to be opened, such as a result, gets the descriptor of standard output,
    and a library that prints writes into it.
    """
    while (descriptor := os.open(os.devnull, os.O_RDWR)) < 3:
        pass
    os.close(descriptor)


def discard(stream: Any) -> None:
    """Redirect a stream that can no longer be written to to the null device.

    This is the recipe of Python's documentation for SIGPIPE: what is left in the buffer would make
    the interpreter fail when it flushes the stream at exit. A stream without a file descriptor, or
    None, is left as it is.
    """
    with suppress(OSError, ValueError, AttributeError):
        descriptor = stream.fileno()
        devnull = os.open(os.devnull, os.O_WRONLY)
        os.dup2(devnull, descriptor)
        os.close(devnull)
