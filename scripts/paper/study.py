"""What a figure or table of the paper, or a question beyond it, is to this program."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from .rows import Rows


class Study(NamedTuple):
    """One item, from its runs to the comparison with what is printed; its texts and the surfaces
    that it needs are in catalogue.toml.

    tabulate: makes rows of the runs and the level. draw: writes the picture of rows to a path.
    compare: makes lines "paper says / we find / why" of rows (rows.saying).
    """

    name: str
    tabulate: Callable[[Rows, str], Rows]
    draw: Callable[[Rows, Path], None]
    compare: Callable[[Rows], Iterable[dict]]
