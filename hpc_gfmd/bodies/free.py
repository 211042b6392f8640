"""The elastic half-space under a surface that ends: free boundaries along one axis or both.

The grid is then a cell at least twice as long as the surface along each free axis, and points beyond the surface never touch. For two
points of the surface S must be that of free space, for others it may be anything: S of the offsets up to half the cell, repeated
periodically, is positive, and its inverse K is as well conditioned as |q|/2.

S in real space comes from a longer cell, in which a smooth window cuts off the images: its spectrum is (2/|q|) times

    both axes free:  mean of J(|q| R),           J(x) = integral of Bessel's J_0 from 0 to x
    one axis free:   mean of (2/pi) Si(q R)      where q along the other axis is 0; 1 elsewhere: those waves die out by themselves

over a normal distribution of the radius R. With R beyond the largest distance on the surface, whatever of it, the window is 1 there;
and for waves much shorter than the width of the distribution the factor is 1.
"""

from dataclasses import dataclass

import numpy as np

from .halfspace import HalfSpace

WIDTH, FEWEST = 1 / 20, 2.4  # of the window: share of the largest distance on the surface, and grid spacings at least
TAILS = 6.4  # standard deviations that leave 1e-10 of a normal distribution
SHORT = 7.5  # wave number times width from which the factor is 1
NODES = 64  # of the mean over R
DECAY = 24.0  # wave number times distance over which the waves of a periodic axis die out
PIECE_BYTES = 2**22  # of its spectrum at a time


@dataclass(frozen=True)
class Free(HalfSpace):
    """free: whether the surface ends along x, along y; at least one is true."""

    free: tuple[bool, bool]

    name = "free"
    table_share = 0.25
    full_p_star = np.inf  # outside the surface nothing ever touches

    @property
    def absolute(self):
        """Along a periodic axis the load never ends: it sinks in without end."""
        return all(self.free)

    @classmethod
    def of(cls, thickness, nu, base, free):
        return cls(tuple(free)) if thickness is None and any(free) else None

    @classmethod
    def examples(cls):
        return [cls((True, True)), cls((True, False)), cls((False, True))]

    def bounds(self, grid):
        smallest, largest = super().bounds(grid)
        return 0.8 * smallest, 1.1 * largest  # |q|/2K is between 0.93 and 1.19

    def multipliers(self, grid, fft):
        return self.tabled(grid, fft)

    def table(self, grid, fft):
        n = grid.n
        out = np.zeros((fft.K, fft.W, n[0] // 2 + 1), fft.dtype)

        def keep(block, m):
            with np.errstate(divide="ignore"):
                S = block.real[:, : n[0] // 2 + 1]
                out[m // grid.comm.size, :len(S)] = 1 / S

        fft.forward_rows(self.compliance_rows(grid))
        fft.columns(keep, backward=False)
        return out

    def compliance_rows(self, grid):
        """fill(i0, i1, x): rows of S between point 0 and all others. Collective."""
        n, space = grid.n, _Space(grid, self.free)
        wanted = [np.unique(offsets(np.arange(*rows), n[0])) for rows in zip(grid.starts, grid.starts[1:])]  # of every rank
        places = np.searchsorted(wanted[grid.comm.rank], offsets(np.arange(*grid.rows), n[0]))
        rows = space.rows(grid.comm, wanted)
        fold = offsets(np.arange(n[1]), n[1])

        def fill(i0, i1, x):
            x[: i1 - i0] = space.back(rows[places[i0:i1]], 1)[:, fold]

        return fill


class _Space:
    """S in free space, on the long cell. Lengths in grid spacings a."""

    def __init__(self, grid, free):
        from scipy.fft import next_fast_len
        from scipy.special import roots_hermite

        self.free, self.n = free, grid.n
        spacings = [s / grid.a for s in grid.spacings]
        half = [k / 2 * s if f else 0.0 for k, s, f in zip(grid.n, spacings, free)]
        largest = np.hypot(*half)
        self.width = max(WIDTH * largest, FEWEST * max(spacings))
        radius = largest + TAILS * self.width
        x, weights = roots_hermite(NODES)
        self.radii, self.shares = radius + np.sqrt(2) * self.width * x, weights / np.sqrt(np.pi)
        reach = radius + TAILS * self.width
        if not all(free):  # and the waves along the other axis
            reach = max(reach, DECAY / (2 * np.pi / (grid.sizes[free.index(False)] / grid.a)))
        self.long = [2 * next_fast_len(int(np.ceil((h + reach) / s / 2)) + 1, real=True) if f else k
                     for h, s, k, f in zip(half, spacings, grid.n, free)]
        self.q = [2 * np.pi * np.arange(k // 2 + 1) / k / s for k, s in zip(self.long, spacings)]

    def spectrum(self, q_x, q_y):
        """S at all pairs of wave numbers along x and y."""
        q = np.hypot(q_x[:, None], q_y)
        S = np.divide(2, q, out=np.zeros_like(q), where=q > 0)
        cut = q * self.width < SHORT
        if not all(self.free):
            cut &= ((q_y if self.free[0] else q_x[:, None]) == 0)
        if cut.any():
            S[cut] = self._cut_off(q[cut])
        return S

    def _cut_off(self, q):
        from scipy.special import itj0y0, sici

        both = all(self.free)
        factor = np.zeros_like(q)
        for radius, share in zip(self.radii, self.shares):
            factor += share * (itj0y0(q * radius)[0] if both else sici(q * radius)[0] * 2 / np.pi)
        limit = 2 * (1.0 if both else 2 / np.pi) * np.dot(self.radii, self.shares)
        return np.divide(2 * factor, q, out=np.full_like(q, limit), where=q > 0)

    def back(self, spectrum, axis):
        """From q >= 0 to offsets up to half the grid's own cell, along one axis."""
        from scipy import fft

        k, keep = self.long[axis], self.n[axis] // 2 + 1
        if k % 2 == 0 and k > 2:
            x = fft.dct(spectrum, type=1, axis=axis) / k
        else:
            x = fft.irfft(spectrum.astype(complex), n=k, axis=axis)
        return x[:keep] if axis == 0 else x[:, :keep]

    def rows(self, comm, wanted):
        """Transformed along x alone: this rank's offsets along x, all q_y. Every rank transforms its share of the q_y; wanted: the
        offsets of every rank."""
        count = len(self.q[1])
        width = max(1, min(PIECE_BYTES // (8 * len(self.q[0])), -(-count // comm.size)))
        rows, filled = np.empty((len(wanted[comm.rank]), count)), 0
        for first in range(0, count, width * comm.size):
            mine = self.q[1][first + comm.rank * width: first + (comm.rank + 1) * width]
            made = self.back(self.spectrum(self.q[0], mine), 0)
            for part in comm.alltoall([made[k] for k in wanted]):
                rows[:, filled:filled + part.shape[1]] = part
                filled += part.shape[1]
        return rows


def offsets(i, n):
    """Distance of point i from point 0 on a ring of n."""
    return np.minimum(i, n - i)
