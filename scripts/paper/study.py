"""The type of an item: a figure or table of the paper, or a question beyond it."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from .rows import Rows


class Study(NamedTuple):
    """An item from its runs to the comparison with the paper.

    catalogue.toml holds its texts and the surfaces that it needs.

    Attributes
    ----------
    name : str
        Name on the command line and of its files.
    tabulate : function
        tabulate(runs, level) returns the rows.
    draw : function
        draw(rows, path) writes the picture.
    compare : function
        compare(rows) yields lines "claim / we find / remark" (rows.comparison).
    """

    name: str
    tabulate: Callable[[Rows, str], Rows]
    draw: Callable[[Rows, Path], None]
    compare: Callable[[Rows], Iterable[dict]]
