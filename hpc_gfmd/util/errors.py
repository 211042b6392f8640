"""The few exceptions and warnings users meet. The command line turns each into one line on stderr
and an exit code."""

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


def one_line(text: str, longest: int = 200) -> str:
    """Return a foreign text without line ends or other control characters, of bounded length."""
    text = "".join(c if c.isprintable() else " " for c in text[: 100 * longest])
    text = " ".join(text.split())
    return text if len(text) <= longest else f"{text[: longest - 60]} ... {text[-50:]}"


def reason(error: BaseException) -> str:
    """Say what went wrong in one line; of HDF5's long messages only the reason the system gave."""
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    found = re.search(r"error message = '([^']+)'", text)
    if found:
        text = found.group(1)
    elif isinstance(error, MemoryError):
        text = f"out of memory ({text})"
    return one_line(text, 400)
