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
    """One prescribed load of a sweep, and the mean pressure that belongs to it.

    Attributes
    ----------
    quantity : str
        Which quantity is prescribed: "pressure", "a_r", "gap_mean" or "approach".
    value : float
        Its prescribed value: a pressure in the unit of E_star, a length in the unit of the heights,
        or a relative area.
    given_p0 : float
        The mean pressure in the program's unit, if it is known without a search; nan in a load that
        is not yet prepared (`Searches.begin` returns a prepared copy) and in one with a search.
    search : LoadSearch or None
        Finds the mean pressure during the iterations; None if it is known without one.
    """

    quantity: str
    value: float
    given_p0: float = nan
    search: LoadSearch | None = None

    @property
    def p0(self) -> float:
        """The mean pressure in the program's unit, the given one or that of the search."""
        return self.given_p0 if self.search is None else self.search.p0

    @property
    def half_area(self) -> float:
        """An estimate of half the relative contact area, from the load alone."""
        return self.given_p0 if self.search is None else self.search.half_area

    @property
    def is_pressure(self) -> bool:
        """Whether the prescribed quantity is the mean pressure."""
        return self.quantity == "pressure"

    def is_beyond(self, separated: Load | None) -> bool:
        """Return whether this load holds the bodies at least as far apart as another one.

        Parameters
        ----------
        separated : Load or None
            The load, of the same quantity (mean gap or approach), at which the bodies came apart;
            None, which gives False, if they have not.
        """
        if separated is None:
            return False
        if self.quantity == "approach":
            return self.value <= separated.value
        return self.value >= separated.value

    @property
    def closes(self) -> bool:
        """Whether the smallest load that closes the gap everywhere is sought (an area of 1)."""
        return self.quantity == "a_r" and self.value == 1

    @property
    def from_full_contact(self) -> bool:
        """Whether the iterations start from a gap of 0 everywhere."""
        return self.search is not None and self.search.from_full_contact

    @property
    def spring(self) -> float:
        """Stiffness of the spring that presses the body, in the program's units (see Problem).

        0 for a pressure, given or searched for. Only a mean gap or an approach that is held under
        an attraction has a spring.
        """
        return 0.0 if self.search is None else self.search.spring

    @property
    def note(self) -> str | None:
        """A remark of the search for the user; None without one."""
        return None if self.search is None else self.search.note


class Unfinished(NamedTuple):
    """State of a load whose iterations were interrupted, from which a later run continues.

    Attributes
    ----------
    gap : ndarray
        The last gap, local slab of the grid, in the program's unit; its dtype is the precision in
        which the load was iterated.
    p_mean : float
        Mean pressure of this gap, in the unit of E_star.
    iterations : int
        Iterations that the load has taken so far.
    pairs : float
        FFT pairs that the load has taken so far.
    """

    gap: np.ndarray
    p_mean: float
    iterations: int
    pairs: float
