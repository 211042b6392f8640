"""Standard output and error that never fail: what cannot be printed is lost, the run is not."""

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from typing import Any


class Stream:
    """A text stream around another one, or None where there is none; lost: why not all of it was
    printed, an OSError, or None. Once something is lost, all that follows is.

    Characters that the terminal does not know are printed as escapes. Everything else is that of
    the stream inside.
    """

    def __init__(self, stream: Any):
        self._inside = stream
        self.lost = OSError(errno.EBADF, os.strerror(errno.EBADF)) if stream is None else None

    def write(self, text: str) -> int:
        """Print a text; return the number of characters, printed or not."""
        encoding = getattr(self._inside, "encoding", None) or "utf-8"
        self._unless_lost("write", text.encode(encoding, "backslashreplace").decode(encoding))
        return len(text)

    def flush(self) -> None:
        """Flush as far as it goes."""
        self._unless_lost("flush")

    def isatty(self) -> bool:
        """Tell whether somebody watches."""
        return bool(self._unless_lost("isatty"))

    def _unless_lost(self, method: str, *args: str) -> Any:
        try:
            return self.lost is None and getattr(self._inside, method)(*args)
        except (OSError, ValueError) as error:  # ValueError: closed by somebody
            self.lost = error if isinstance(error, OSError) else OSError(errno.EBADF, str(error))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inside, name)


@contextmanager
def unfailing_output() -> Iterator[Stream]:
    """`with unfailing_output() as out`: the standard streams of a command are Streams; out: its
    standard output."""
    # one that is closed would be that of the next file, into which libraries would print
    while (descriptor := os.open(os.devnull, os.O_RDWR)) < 3:
        pass
    with redirect_stdout(Stream(sys.stdout)) as out, redirect_stderr(Stream(sys.stderr)) as err:
        try:
            yield out
        finally:
            for stream in (out, err):
                stream.flush()
                # what is still in buffers goes nowhere, so that the interpreter can close it
                with suppress(OSError, ValueError, AttributeError):
                    if stream.lost is not None:
                        os.dup2(descriptor, stream.fileno())
            os.close(descriptor)
