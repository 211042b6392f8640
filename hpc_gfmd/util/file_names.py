"""Names of files that the locale of this process cannot say."""

import os
import sys

from .errors import SceneError, one_line

WAY_OUT = "a UTF-8 locale, such as LC_ALL=C.UTF-8, or the environment variable PYTHONUTF8=1"


def require_name(key: str, path: str | os.PathLike) -> None:
    """Raise SceneError for a file name with characters that the locale's encoding lacks.

    This process can neither find nor create such a file.

    Parameters
    ----------
    key : str
        The key or the option that names the file.
    path : path
        The file.

    Raises
    ------
    SceneError
        With the key.
    """
    try:
        os.fsencode(path)
    except UnicodeEncodeError:
        raise _not_in_locale(key, os.fspath(path)) from None


def require_decoded(argument: str) -> None:
    """Raise SceneError for an argument of the command line that the locale's encoding could not
    decode. (In a UTF-8 locale it is the name of a file from another one, which can be opened.)"""
    if sys.getfilesystemencoding() == "utf-8":
        return
    try:
        argument.encode()
    except UnicodeEncodeError:  # surrogates stand for the bytes
        raise _not_in_locale("arguments", argument) from None


def _not_in_locale(key: str, name: str) -> SceneError:
    """Return the error of a name that the locale cannot write; key: of the scene."""
    text = one_line(name.encode("ascii", "backslashreplace").decode())
    encoding = sys.getfilesystemencoding()
    return SceneError(
        f"{key}: found {text}, which the locale's encoding ({encoding}) lacks, allowed: {WAY_OUT}"
    )
