"""What a figure or table of the paper, or a question beyond it, is to this program, and which there
are.

Every file of items/ lists some in STUDIES; adding one means adding an entry, or dropping in a file.
"""

import importlib
import pkgutil
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from hpc_gfmd.scene.explain import nearest
from hpc_gfmd.util.errors import SceneError

from . import items
from .case import Case
from .paper import Sayings
from .rows import Rows


@dataclass(frozen=True)
class Study:
    """One figure or table, from the contacts it needs to the comparison with what is printed.

    Attributes
    ----------
    name, title : str
        "fig1" and what it shows.
    paper : str
        What the paper says there, or the literature.
    cases : function of the level
        The contacts that it is made of.
    tabulate : function of the runs and the level
        Rows of the table.
    draw : function of the rows and a path
        Writes the picture.
    compare : function of the rows
        Lines "paper says / we find / why" (paper.saying).
    question : str
        Of a study beyond the paper: what it asks. It gets a page of its own instead of a place in
        the report.
    columns : dict
        The table of that page: {title: template of a cell (text.filled)}.
    lines : function of the rows
        The rows that fill them in, if not those of the table itself.
    """

    name: str
    title: str
    paper: str
    cases: Callable[[str], list[Case]]
    tabulate: Callable[[Rows, str], Rows]
    draw: Callable[[Rows, Path], None]
    compare: Callable[[Rows], Sayings]
    question: str = ""
    columns: dict[str, str] = field(default_factory=dict)
    lines: Callable[[Rows], Rows] = list


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
        raise SceneError(
            f"NAME: found {name!r}, nearest: {nearest(name, names())!r}, allowed: all,"
            f" {', '.join(names())}"
        )
    return _studies()[name]


@cache
def _studies() -> dict[str, Study]:
    modules = (
        importlib.import_module(f"{items.__name__}.{module.name}")
        for module in pkgutil.iter_modules(items.__path__)
    )
    return {study.name: study for module in modules for study in module.STUDIES}
