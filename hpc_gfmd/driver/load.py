"""One load of a sweep, as a scene prescribes it, and the state of an unfinished one.

What the solver gets is the load's Target (target.py), which has or finds the mean pressure.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import numpy as np

    from .grid_errors import CoarseContact


@dataclass(frozen=True)
class Load:
    """One prescribed load of a sweep, in the units of the scene."""

    quantity: str  # which one is prescribed: "pressure", "a_r", "gap_mean" or "approach"
    value: float  # a pressure in the unit of E_star, a length in that of the heights, or an area
    time: float = 0.0  # when it is reached; only a body that relaxes (history.py) asks
    share: float = 1.0  # accuracy of its contact over that requested; only a history asks
    # Whether it holds the bodies farther apart than the load before; only a cycle of adhesion
    # (branches.py) asks.
    parts: bool = False

    @property
    def is_pressure(self) -> bool:
        """Whether the prescribed quantity is the mean pressure."""
        return self.quantity == "pressure"

    @property
    def closes(self) -> bool:
        """Whether the smallest load that closes the gap everywhere is sought (an area of 1)."""
        return self.quantity == "a_r" and self.value == 1

    def is_beyond(self, other: Load) -> bool:
        """Return whether this load holds the bodies at least as far apart as another one."""
        if self.quantity == "gap_mean":
            return self.value >= other.value
        return self.value <= other.value


class Unfinished(NamedTuple):
    """State of a load whose iterations were interrupted, from which a later run continues."""

    gap: np.ndarray  # local slab, in the program's unit and in the precision of the iterations
    p_mean: float  # mean pressure of this gap, in the unit of E_star
    iterations: int  # so far
    pairs: float  # so far
    # Its contacts on coarser grids, which tell the errors by the grid; empty if it started from the
    # load before.
    coarser: Sequence[CoarseContact] = ()
    # error of the mean gap by the grid, of the load before then or of this gap
    gap_discretisation: float | None = None
