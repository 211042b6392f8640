"""One load of a sweep, from the scene to the solver."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import nan
from typing import TYPE_CHECKING, NamedTuple

from .target import Target

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np

    from ..contact.contact import GridErrors
    from .grid_errors import CoarseContact


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
    target : Target
        Has the mean pressure in the program's unit, or finds it during the iterations; nan in a
        load that the sweep has not prepared yet.
    time : float
        When it is reached; only a body that relaxes (history.py) asks.
    share : float
        Accuracy of its contact over that requested; only a history asks.
    parts : bool
        Whether it holds the bodies farther apart than the load before; only a cycle of adhesion
        (branches.py) asks.
    """

    quantity: str
    value: float
    target: Target = field(default_factory=lambda: Target(nan))
    time: float = 0.0
    share: float = 1.0
    parts: bool = False

    @property
    def p0(self) -> float:
        """The mean pressure in the program's unit."""
        return self.target.p0

    @property
    def is_pressure(self) -> bool:
        """Whether the prescribed quantity is the mean pressure."""
        return self.quantity == "pressure"

    def is_beyond(self, other: Load) -> bool:
        """Return whether this load holds the bodies at least as far apart as another one of the
        same quantity, which is no area."""
        if self.quantity == "gap_mean":
            return self.value >= other.value
        return self.value <= other.value

    @property
    def closes(self) -> bool:
        """Whether the smallest load that closes the gap everywhere is sought (an area of 1)."""
        return self.quantity == "a_r" and self.value == 1


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
    coarser : sequence of CoarseContact
        Its contacts on coarser grids, which tell the errors by the grid; empty if it started from
        the load before.
    of_grid : GridErrors or None
        The errors by the grid of the load before then, or of this gap.
    """

    gap: np.ndarray
    p_mean: float
    iterations: int
    pairs: float
    coarser: Sequence[CoarseContact] = ()
    of_grid: GridErrors | None = None
