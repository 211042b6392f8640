"""The exceptions and warnings that users meet: on the command line a line and an exit code."""

import re
from collections.abc import Iterable
from pathlib import Path
from traceback import extract_tb


class GfmdError(Exception):
    """A run or command failed; the message says why. Exit code 1 on the command line."""

    exit_code = 1


class SceneError(GfmdError):
    """The scene, its files or the arguments are wrong. Exit code 2 on the command line.

    The message names the key, what was found and what is allowed.
    """

    exit_code = 2


class NotConverged(UserWarning):
    """A solution is less accurate than requested; its `status` gives the reason."""


class SurfaceWarning(UserWarning):
    """What may be wrong with a surface or its units; it stands in the notes of the result, too."""


class ReadingWarning(SurfaceWarning):
    """How a file was read that can be read in another way."""


def each_once(notes: Iterable[SurfaceWarning]) -> tuple[SurfaceWarning, ...]:
    """Return notes without those whose text has come before."""
    return tuple({str(note): note for note in notes}.values())


EXTRAS = {  # of setup.cfg, by the packages in them
    "mpi4py": "mpi",
    "mpi4py_fft": "mpi",
    "h5netcdf": "notebook",
    "ipywidgets": "notebook",
    "xarray": "notebook",
}


def how_to_install(package: str) -> str:
    """Return the pip command that installs a missing package, as a text for a message."""
    extra = EXTRAS.get(package)
    return f"pip install 'hpc-gfmd[{extra}]'" if extra else f"pip install {package}"


def one_line(text: str, longest: int = 200) -> str:
    """Replace control characters of a text by spaces; a longer text loses its middle."""
    printable = "".join(c if c.isprintable() else " " for c in text[: 100 * longest])
    line = " ".join(printable.split())
    return line if len(line) <= longest else f"{line[: longest - 60]} ... {line[-50:]}"


class ProgrammingError(Exception):
    """A programming error on another rank; the message has its traceback."""


MISTAKES = (AssertionError, AttributeError, NameError, TypeError, ProgrammingError)
_PACKAGE = Path(__file__).parents[1]


def is_mistake(error: BaseException) -> bool:
    """Whether an exception is a programming error: of these kinds, and raised by the code of this
    package, not by a library that reads a damaged file. It is no error of the user's.
    """
    place = Path(extract_tb(error.__traceback__)[-1].filename)
    return isinstance(error, MISTAKES) and place.is_relative_to(_PACKAGE)


def reason(error: BaseException) -> str:
    """Return one line on why an error occurred: the system's reason, or the error's message."""
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    if by_system := re.search(r"error message = '([^']+)'", text):
        text = by_system.group(1)
    elif isinstance(error, MemoryError):
        text = f"out of memory ({text})"
    return one_line(text, 400)
