"""A rank of a run that nobody started: enough for whatever asks who has what, without memory and
messages."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike


class Imagined:
    """Rank `rank` of `size`, as a communicator that cannot send. nodes: that of every rank
    (default: each has one to itself, so that everything between ranks is a message)."""

    mpi = parent = None

    def __init__(self, rank: int, size: int, nodes: ArrayLike | None = None):
        self.rank, self.size = rank, size
        self._nodes = np.arange(size) if nodes is None else np.asarray(nodes)

    @property
    def node_ranks(self) -> np.ndarray:
        """The ranks on the same node."""
        return np.flatnonzero(self._nodes == self._nodes[self.rank])

    def subcomm(self, ranks: Any) -> "Imagined | None":
        """The communicator of these ranks alone, None where this rank is not one of them."""
        place = int(np.searchsorted(ranks, self.rank))
        return (
            Imagined(place, len(ranks), self._nodes[ranks])
            if place < len(ranks) and ranks[place] == self.rank
            else None
        )
