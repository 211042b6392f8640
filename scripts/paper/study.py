"""What a figure or table of the paper, or a question beyond it, is to this program."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from .cases import CATALOGUE
from .rows import Rows


class Study(NamedTuple):
    """One item, from the runs it needs (catalogue.toml) to the comparison with what is printed.

    tabulate: makes rows of the runs and the level. draw: writes the picture of rows to a path.
    compare: makes lines "paper says / we find / why" of rows (rows.saying).
    """

    name: str
    tabulate: Callable[[Rows, str], Rows]
    draw: Callable[[Rows, Path], None]
    compare: Callable[[Rows], Iterable[dict]]

    @property
    def title(self) -> str:
        """Say what it shows."""
        return CATALOGUE["items"][self.name]["title"]

    @property
    def paper(self) -> str:
        """Say what the paper says there, or the literature."""
        return CATALOGUE["items"][self.name]["paper"]

    @property
    def question(self) -> str:
        """Say what an item beyond the paper asks, which has a page of its own; "" of others."""
        return CATALOGUE["items"][self.name].get("question", "")
