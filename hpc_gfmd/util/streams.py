"""Standard output and error that never fail: what cannot be printed is lost, the run is not."""

import errno
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from typing import Any


class Stream:
    """A text stream around another one, or None where there is none; lost: why not all of it was
    printed, an OSError, or None.

    Characters that the terminal does not know are printed as escapes. Everything else is that of
    the stream inside.
    """

    def __init__(self, stream: Any):
        self._inside = stream
        self.lost = OSError(errno.EBADF, os.strerror(errno.EBADF)) if stream is None else None

    def write(self, text: str) -> int:
        """Returns the number of characters, printed or not."""
        self._unless_lost(self._write, text)
        return len(text)

    def flush(self) -> None:
        """As far as it goes."""
        self._unless_lost(lambda: self._inside.flush())

    def isatty(self) -> bool:
        """Whether somebody watches."""
        return self.lost is None and self._inside.isatty()

    def silence(self) -> None:
        """Let what is still in buffers go nowhere, so that the interpreter can close the stream."""
        with suppress(OSError, ValueError, AttributeError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._inside.fileno())
            os.close(nowhere)

    def _unless_lost(self, do: Callable[..., None], *args: str) -> None:
        """Once something is lost, all that follows is."""
        try:
            if self.lost is None:
                do(*args)
        except (OSError, ValueError) as error:  # ValueError: closed by somebody
            self.lost = error if isinstance(error, OSError) else OSError(errno.EBADF, str(error))

    def _write(self, text: str) -> None:
        try:
            self._inside.write(text)
        except UnicodeEncodeError as error:
            self._inside.write(
                text.encode(error.encoding, "backslashreplace").decode(error.encoding)
            )

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inside, name)


def unfailing(stream: Any) -> Stream:
    """The stream as one that never fails."""
    return stream if isinstance(stream, Stream) else Stream(stream)


@contextmanager
def unfailing_output() -> Iterator[Stream]:
    """`with unfailing_output() as out`: the standard streams of a command are Streams; out: its
    standard output."""
    for descriptor in range(
        3
    ):  # one that is closed would be that of the next file, into which libraries would print
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    with (
        redirect_stdout(unfailing(sys.stdout)) as out,
        redirect_stderr(unfailing(sys.stderr)) as err,
    ):
        try:
            yield out
        finally:
            for stream in (out, err):
                stream.flush()
                if stream.lost is not None:
                    stream.silence()
