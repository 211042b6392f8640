"""The elastic half-space: p = p0 + K u with K = |q|/2 in the units of problem.py (E* = 1, lengths in units of a)."""

from functools import cache

import numpy as np

from ..kernels.spectral import multiply_compliance, multiply_stiffness

NEAR_POINTS = 64  # along an axis are enough to know what K is between neighbours


class HalfSpace:
    """Applies K, or its inverse S = 2/|q|, to fields that the caller makes and uses a few rows at a time.

    `pairs` counts the FFT pairs done so far on this grid (a transform in one direction is half a pair).
    """

    def __init__(self, grid, dtype):
        self.grid = grid
        self.fft = grid.fft(dtype)
        self.q_x = np.repeat(grid.q_x, 2).astype(self.fft.dtype)  # kernels see real and imaginary parts as numbers of their own
        self.q_y, self.weight = grid.column_tables(self.fft)
        self.pairs = 0.0

    def _columns(self, kernel, factor, backward=True, add=None):
        scale = self.fft.scale

        def apply(block, m):
            if add is not None:
                add(block, m)
            return kernel(block.view(self.fft.dtype), self.q_x, self.q_y[m], self.weight[m], self.fft.dtype.type(factor * scale))

        return float(sum(self.fft.columns(apply, backward=backward)))

    def pressure_rows(self, fill, passes=None):
        """First third of an application of K: rows of u are made by fill; returns what it returned."""
        return self.fft.forward_rows(fill, passes)

    def pressure_columns(self, add=None):
        """Second third; returns this rank's share of <u, K u>, summed over all points. add(block, m) completes the columns first."""
        return self._columns(multiply_stiffness, 0.5, add=add)

    def use_rows(self, use, passes=None):
        """Last third: rows of K u are given to use; returns what it returned."""
        self.pairs += 1
        return self.fft.backward_rows(use, passes)

    def apply(self, fill, use):
        """K u by rows; returns this rank's share of <u, K u>."""
        self.pressure_rows(fill)
        energy = self.pressure_columns()
        self.use_rows(use)
        return energy

    def apply_to(self, u, out):
        """out = K u, local slabs; returns this rank's share of <u, K u>."""
        return self.apply(reader(u), writer(out))

    def apply_compliance(self, p, out):
        """out = S p with zero mean, local slabs; returns this rank's share of <p, S p>."""
        self.pressure_rows(reader(p))
        energy = self.displacement_columns()
        self.use_rows(writer(out))
        return energy

    def displacement_columns(self):
        """After `pressure_rows` of a pressure: S p with zero mean, for `use_rows`; returns this rank's share of <p, S p>."""
        return self._columns(multiply_compliance, 2.0)

    def compliance_columns(self):
        """After `pressure_rows` of a pressure: this rank's share of <p, S p>. Half a pair in all, nothing is transformed back."""
        self.pairs += 0.5
        return self._columns(multiply_compliance, 2.0, backward=False)


def near_stiffness(grid):
    """K between a point and itself, its neighbours along x, along y, and the diagonal ones (0 where there are none)."""
    return _near_stiffness(tuple(min(k, NEAR_POINTS) for k in grid.n), tuple(s / grid.a for s in grid.spacings))


@cache
def _near_stiffness(n, spacings):
    q = [2 * np.pi * np.fft.fftfreq(k) / s for k, s in zip(n, spacings, strict=True)]
    K = np.fft.ifft2(0.5 * np.hypot(q[0][:, None], q[1])).real
    x, y = (k > 2 for k in n)
    return np.array([K[0, 0], K[1 % n[0], 0] * x, K[0, 1 % n[1]] * y, K[1 % n[0], 1 % n[1]] * (x and y)])


def reader(field):
    """fill function that copies rows of a local slab."""

    def fill(i0, i1, x):
        x[: i1 - i0] = field[i0:i1]

    return fill


def writer(field):
    """use function that stores rows in a local slab."""

    def use(i0, i1, x):
        field[i0:i1] = x[: i1 - i0]

    return use


def total(comm, sums):
    """Sum the per-pass tuples of numbers over passes and ranks; returns an array of float64."""
    return comm.sum(np.sum(np.asarray(sums, dtype=np.float64), axis=0))
