"""What a figure or table of the paper, or a question beyond it, is to this program."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from .case import Case
from .paper import Sayings
from .rows import Rows


def _as_they_are(rows: Rows) -> Rows:
    return rows


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
        Of a study beyond the paper: what it asks. It gets a page of its own instead of a place in the report.
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
    lines: Callable[[Rows], Rows] = _as_they_are
