"""The studies there are: every file of items/ lists some in STUDIES; adding one means adding an entry, or dropping in a file."""

import importlib
import pkgutil
import re
from functools import cache

from ..errors import SceneError
from ..scene.explain import nearest
from . import items
from .study import Study


def names() -> list[str]:
    """Names of all studies: figures and tables of the paper, then what goes beyond it."""
    return of_paper() + sorted(name for name, study in _studies().items() if study.question)


def of_paper() -> list[str]:
    """Names of its figures and tables, figures first, by their numbers."""
    found = [name for name, study in _studies().items() if not study.question]
    return sorted(found, key=lambda name: (re.sub(r"\d+", "", name), int(re.sub(r"\D+", "", name))))


def study(name: str) -> Study:
    """The study of a name. Raises SceneError that names the nearest one."""
    if name not in _studies():
        raise SceneError(f"NAME: found {name!r}, nearest: {nearest(name, names())!r}, allowed: all, {', '.join(names())}")
    return _studies()[name]


@cache
def _studies() -> dict[str, Study]:
    modules = (importlib.import_module(f"{items.__name__}.{module.name}") for module in pkgutil.iter_modules(items.__path__))
    return {study.name: study for module in modules for study in module.STUDIES}
