"""The studies there are: every file of items/ is a figure or a table of the paper; adding one means dropping in one file.

A study is a module with NAME, TITLE, PAPER (what the paper shows there), cases(level) -> list of Case,
tabulate(runs, level) -> rows, draw(rows, path) and compare(rows) -> what the paper says beside what we find.
"""

import importlib
import pkgutil
import re

from ..errors import SceneError
from ..scene.explain import nearest
from . import items


def names():
    """Names of all studies, figures first, by their numbers."""
    return sorted((m.name for m in pkgutil.iter_modules(items.__path__)), key=lambda n: (re.sub(r"\d+", "", n), _number(n)))


def study(name):
    """The module of a study. Raises SceneError that names the nearest one."""
    if name not in names():
        raise SceneError(f"NAME: found {name!r}, nearest: {nearest(name, names())!r}, allowed: all, {', '.join(names())}")
    return importlib.import_module(f"{items.__name__}.{name}")


def _number(name):
    digits = re.search(r"\d+", name)
    return int(digits[0]) if digits else 0
