"""One load of a sweep, from the scene to the solver."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .search import LoadSearch


@dataclass
class Load:
    """What is asked of one load, and the mean pressure that gives it.

    Attributes
    ----------
    quantity : str
        "pressure", "a_r", "gap_mean" or "approach".
    value : float
        What is asked for: a pressure in the unit of E_star, a length in the unit of the heights, or
        a relative area.
    given_p0 : float
        The mean pressure in the program's units, where it follows from `value`; nan before the
        sweep comes to this load.
    search : LoadSearch or None
        Finds the mean pressure; None where no iteration is needed for that.
    """

    quantity: str
    value: float
    given_p0: float = nan
    search: LoadSearch | None = None

    @property
    def p0(self) -> float:
        """The present mean pressure, in the program's units."""
        return self.given_p0 if self.search is None else self.search.p0

    @property
    def half_area(self) -> float:
        """About half of the relative contact area."""
        return self.given_p0 if self.search is None else self.search.half_area

    @property
    def is_pressure(self) -> bool:
        """Whether the mean pressure is what is asked for."""
        return self.quantity == "pressure"

    @property
    def closes(self) -> bool:
        """Whether the load is to be the least that closes the gap everywhere."""
        return self.quantity == "a_r" and self.value == 1

    @property
    def from_full_contact(self) -> bool:
        """Whether the iterations begin with a closed gap."""
        return self.search is not None and self.search.from_full_contact

    @property
    def note(self) -> str | None:
        """What a user has to know of the load that was found."""
        return None if self.search is None else self.search.note
