"""One load of a sweep, from the scene to the solver."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import numpy as np

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

    def is_beyond(self, separated: Load | None) -> bool:
        """Return whether it holds the bodies as far apart as a load at which they came apart, or
        further.

        Parameters
        ----------
        separated : Load or None
            Of the same quantity; None where they are together.
        """
        if separated is None:
            return False
        if self.quantity == "approach":
            return self.value <= separated.value
        return self.value >= separated.value

    @property
    def closes(self) -> bool:
        """Whether the load is to be the least that closes the gap everywhere."""
        return self.quantity == "a_r" and self.value == 1

    @property
    def from_full_contact(self) -> bool:
        """Whether the iterations begin with a closed gap."""
        return self.search is not None and self.search.from_full_contact

    @property
    def spring(self) -> float:
        """Stiffness of the spring through which the body is pressed."""
        return 0.0 if self.search is None else self.search.spring

    @property
    def note(self) -> str | None:
        """What a user has to know of the load that was found."""
        return None if self.search is None else self.search.note


class Unfinished(NamedTuple):
    """What is kept of a load that was stopped in its middle.

    Attributes
    ----------
    gap : ndarray
        Local slab of the grid, in the program's unit and in the precision of that run.
    p_mean : float
        The mean pressure that it belongs to, in the unit of E_star.
    iterations : int
    pairs : float
        Iterations and FFT pairs that the load has taken so far.
    """

    gap: np.ndarray
    p_mean: float
    iterations: int
    pairs: float
