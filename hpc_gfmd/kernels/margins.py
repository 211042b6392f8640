"""How near the points of a surface are to coming into contact, or leaving it: counts by pressure or gap."""

import numpy as np

from .halfwidth import narrow
from .jit import kernel

NUMBERS = 2**15  # of 16 bits that are not negative, see halfwidth.py: seven of them after the first that counts


def number_of(k):
    """What the kth of them stands for."""
    return (np.asarray(k, np.uint32) << 16).view(np.float32).astype(np.float64)


@kernel
def count_margins(g, p, closed, counts):
    """Count the points in contact by their pressure, or (closed = False) those out of it by their gap: counts[k] have the kth of
    NUMBERS. g, p: the nominal area of a slab."""
    for i in range(g.shape[0]):
        for j in range(g.shape[1]):
            if (g[i, j] <= 0 and p[i, j] > 0) == closed:
                counts[narrow(abs(np.float32(p[i, j] if closed else max(g[i, j], 0))))] += 1  # a zero may have a sign
