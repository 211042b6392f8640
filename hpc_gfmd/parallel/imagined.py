"""A rank of a run that nobody started: enough for whatever asks who has what, without memory and messages."""

import numpy as np


class Imagined:
    """Rank `rank` of `size`, as a communicator that cannot send."""

    mpi = parent = None

    def __init__(self, rank, size):
        self.rank, self.size = rank, size

    def among(self, ranks):
        """The communicator of these ranks alone, None where this rank is not one of them."""
        place = int(np.searchsorted(ranks, self.rank))
        return Imagined(place, len(ranks)) if place < len(ranks) and ranks[place] == self.rank else None
