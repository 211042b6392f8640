"""The half-space with free edges as most codes discretise it: a pressure that is constant on the cell around each grid point.

Love's solution for the displacement in the middle of one cell by the pressure on another, in place of the band-limited Green's
function of bodies/free.py. For comparisons on equal terms only.
"""

from dataclasses import dataclass

import numpy as np

from ..bodies.free import Free, offsets


@dataclass(frozen=True)
class Cells(Free):
    """See bodies/free.py: nothing but S between two points is different."""

    def compliance_rows(self, grid):
        half = [s / grid.a / 2 for s in grid.spacings]
        x, y = (offsets(np.arange(n), n) * 2 * s for n, s in zip(grid.n, half))

        def fill(i0, i1, out):
            row = x[grid.rows[0] + i0:grid.rows[0] + i1, None]
            out[: i1 - i0] = sum(sx * sy * _corner(row + sx * half[0], y + sy * half[1]) for sx in (1, -1) for sy in (1, -1)) / np.pi

        return fill


def _corner(x, y):
    """Integral of 1/r over the rectangle between the origin and (x, y)."""
    return x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))
