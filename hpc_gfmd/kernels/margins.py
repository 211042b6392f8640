"""How near the points of a surface are to coming into contact, or leaving it: counts by pressure or
gap."""

import numpy as np

from .halfwidth import narrow
from .jit import kernel

NUMBERS = (
    2**15
)  # of 16 bits that are not negative, see halfwidth.py: seven of them after the first that counts


def number_of(k):
    """What the kth of them stands for."""
    return (np.asarray(k, np.uint32) << 16).view(np.float32).astype(np.float64)


@kernel
def count_margins(g, p, inside, closed, counts):
    """Count the points in contact by their pressure, or (closed = False) those out of it by their
    gap: counts[k] have the kth of NUMBERS. g, p: a slab; inside: shape of its part of the nominal
    area."""
    rows, n = inside
    for i in range(rows):
        for j in range(n):
            if (g[i, j] <= 0 and p[i, j] > 0) == closed:
                counts[narrow(abs(np.float32(p[i, j] if closed else max(g[i, j], 0))))] += (
                    1  # a zero may have a sign
                )
