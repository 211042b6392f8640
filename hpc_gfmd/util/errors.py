"""The exceptions and warnings that users meet. The command line turns each into one line on
standard error and an exit code."""

import re


class GfmdError(Exception):
    """Something went wrong while running."""

    exit_code = 1


class SceneError(GfmdError):
    """The scene, its files or the arguments are wrong; the message names the key, what was found
    and what is allowed."""

    exit_code = 2


class NotConverged(UserWarning):
    """A solution is less accurate than asked; its status says why."""


EXTRAS = {  # of setup.cfg, by the packages in them
    "mpi4py": "mpi",
    "mpi4py_fft": "mpi",
    "h5netcdf": "notebook",
    "ipywidgets": "notebook",
    "xarray": "notebook",
}


def how_to_install(package: str) -> str:
    """Return the command that installs a missing package."""
    extra = EXTRAS.get(package)
    return f"pip install 'hpc-gfmd[{extra}]'" if extra else f"pip install {package}"


def one_line(text: str, longest: int = 200) -> str:
    """Remove line ends and other control characters from a text and shorten it.

    Parameters
    ----------
    text : str
        A text from outside, such as the message of a library.
    longest : int
        Characters beyond which the middle is left out.

    Returns
    -------
    str
        One line.
    """
    printable = "".join(c if c.isprintable() else " " for c in text[: 100 * longest])
    line = " ".join(printable.split())
    return line if len(line) <= longest else f"{line[: longest - 60]} ... {line[-50:]}"


def reason(error: BaseException) -> str:
    """Describe an error in one line; of HDF5's long messages keep the system's reason."""
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    if by_system := re.search(r"error message = '([^']+)'", text):
        text = by_system.group(1)
    elif isinstance(error, MemoryError):
        text = f"out of memory ({text})"
    return one_line(text, 400)
