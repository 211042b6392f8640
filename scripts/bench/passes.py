"""What the passes of the default solver move through memory.

Counted are the fields that a pass has to read or write at least once; what stays in cache between
the parts of a pass (row and column transforms work on pieces of 256 KiB) and what the memory system
adds on its own (reading lines that are about to be overwritten) is not counted, neither here nor
for the copy that they are compared with.
"""

from collections.abc import Sequence

COPY = 2.0  # fields that a copy moves: read one, write one


def field_passes(shapes: Sequence[Sequence[int]]) -> dict[str, float]:
    """{pass: fields read or written}, in fields of the fine grid. shapes: (n_x, n_y) of all levels,
    finest first."""
    points = [n_x * n_y for n_x, n_y in shapes]
    share = [p / points[0] for p in points]
    first, coarser = (share[1] if len(share) > 1 else 1.0), sum(share[2:])
    d = 0.5  # the last step, in half the width
    spectrum = 1 + 2 / shapes[0][1]  # n_y/2 + 1 complex columns
    return {
        "search + rows": 2
        + 2 * d
        + first
        + spectrum,  # read g, p, d and z of level 1; write d; write the row spectra
        "columns": 2 * spectrum,  # read and write
        "update + rows": spectrum
        + 4
        + d
        + 3 * first,  # read row spectra, g, p, d; write g, p; write p, theta and x on level 1
        # level 1: restrict p and theta, then read p, theta, x, write z; coarser ones: write and
        # read p and theta both ways, z
        "sweep": 6 * first + 8 * coarser,
    }
