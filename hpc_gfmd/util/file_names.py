"""Checks of file names: the locale's encoding must be able to represent them."""

import os
import sys

from .errors import SceneError, one_line

WAY_OUT = "a UTF-8 locale, such as LC_ALL=C.UTF-8, or the environment variable PYTHONUTF8=1"


def require_name(key: str, path: str | os.PathLike) -> None:
    """Raise SceneError for a file name with characters that the locale's encoding lacks."""
    try:
        os.fsencode(path)
    except UnicodeEncodeError:
        raise _not_in_locale(key, os.fspath(path)) from None


def require_decoded(argument: str) -> None:
    """Raise SceneError if a locale other than UTF-8 could not decode an argument."""
    if sys.getfilesystemencoding() == "utf-8":
        return
    try:
        argument.encode()
    except UnicodeEncodeError:  # surrogates stand for the bytes
        raise _not_in_locale("arguments", argument) from None


def _not_in_locale(key: str, name: str) -> SceneError:
    """Return, without raising it, the SceneError of a name that the locale cannot represent."""
    text = one_line(name.encode("ascii", "backslashreplace").decode())
    encoding = sys.getfilesystemencoding()
    return SceneError(
        f"{key}: found {text}, which the locale's encoding ({encoding}) lacks, allowed: {WAY_OUT}"
    )
