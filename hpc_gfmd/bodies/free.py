"""The elastic half-space under a surface with free boundaries along one axis or both.

The grid is a cell longer than the surface along free axes, and points beyond it never touch. S must
be that of free space between points of the surface and is arbitrary elsewhere: it is S of the
periodic half-space plus, in the lowest modes, what cancels the images (bodies/images.py). K is its
inverse: |q|/2, except that these modes are coupled.

On a grid |q| has a kink where the wave numbers end, which gives S a tail, (-1)^i/i^2, and images
that do not decay as 1/r. Wave numbers of a free axis are rounded there, so that K is smooth.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..kernels.lowmodes import join, multiply, split
from ..parallel.fft import SlabFFT
from ..parallel.grid import Grid
from ..scene import Material
from .base import Body, Multipliers, Waves, once_per_grid
from .halfspace import HalfSpace
from .images import ALONE, NEEDED, PARITIES, Images, images

SHARES = 24  # shares of a cell that are told apart: nearly the same grids have the same modes
COVERED = 16  # of them that a surface has at most, see surface.cell_of
# width of the kink, over 1/a: the tail of S has died out within the points beyond a surface
ROUNDED = 0.055
DECAY = 18.0  # wave number times distance over which the waves of a periodic axis die out

Matrices = dict[bool, dict[tuple[int, int], np.ndarray]]


class Shape(NamedTuple):
    """What `images` needs of a grid, in roots of the cell's area; at most three `points` a mode."""

    cell: tuple[float, float]
    inside: tuple[float, float]
    free: tuple[bool, bool]
    modes: tuple[int, int]
    points: tuple[int, int]


@dataclass(frozen=True)
class Free(HalfSpace):
    """A half-space under a surface with free boundaries along at least one axis."""

    free: tuple[bool, bool]

    name = "free"
    full_p_star = np.inf  # outside the surface nothing ever touches
    # the largest seen, where all of the surface touches, whatever the grid; a tenth of it at light
    # loads
    error = 5e-7

    @classmethod
    def of(cls, material: Material, free: Sequence[bool]) -> Body | None:
        """Return the half-space under a surface with a free boundary, without a thickness."""
        return cls((free[0], free[1])) if material.thickness is None and any(free) else None

    @classmethod
    def examples(cls) -> list[Body]:
        """Return bodies free along both axes, along x and along y, for the contract tests."""
        return [cls((True, True)), cls((True, False)), cls((False, True))]

    @once_per_grid
    def bounds(self, grid: Grid) -> tuple[float, float]:
        """Return bounds of K, in 1/a; the lower is below all waves: coupled modes are softer."""
        smallest, largest = super().bounds(grid)
        return 0.4 * smallest, largest  # S of a mode is at most 2.5 times that of the cell

    def waves(self, grid: Grid, q_x: np.ndarray, q_y: np.ndarray) -> Waves:
        """Return the wave numbers, without their kink at the shortest wave along free axes."""
        q_x, q_y = map(rounded, (q_x, q_y), np.divide(grid.spacings, grid.a), self.free)
        return q_x, q_y

    def make_multipliers(self, grid: Grid, fft: SlabFFT, q: Waves) -> Multipliers:
        """Make Multipliers that couple the lowest modes of the free axes. Collective."""
        shape = self._shape(grid)
        return (
            Coupled(grid, fft, q, *_half_space(shape, fft.dtype))
            if shape
            else super().make_multipliers(grid, fft, q)
        )

    def exchanged(self, grid: Grid) -> int:
        """Return how many numbers each rank adds to a sum over ranks in one multiplication by K."""
        shape = self._shape(grid)
        return 4 * (shape.modes[0] + 1) * (shape.modes[1] + 1) if shape else 0

    def _shape(self, grid: Grid) -> Shape | None:
        """Return the Shape of a grid; None if no free axis has more than two points."""
        free = self.free[0] and grid.n[0] > 2, self.free[1] and grid.n[1] > 2
        if not any(free):
            return None
        # without a surface: of a small one
        points = [m if m < n else n // 4 for m, n in zip(grid.nominal, grid.n)]
        shares = [
            min(max(-(-SHARES * (m - 1) // n), 1), COVERED) / SHARES if ends else 1.0
            for m, n, ends in zip(points, grid.n, free)
        ]
        X, Y = (round(size / np.sqrt(np.prod(grid.sizes)), 12) for size in grid.sizes)
        open_part = min(
            (1 - share) * size for share, size, ends in zip(shares, (X, Y), free) if ends
        )
        needed = [
            (NEEDED if all(free) else ALONE) if ends else DECAY / (2 * np.pi) for ends in free
        ]
        k_x, k_y = (
            min(int(np.ceil(k * size / open_part)), (n - 1) // 2)
            for k, size, n in zip(needed, (X, Y), grid.n)
        )
        n_x, n_y = (min(n, 3 * k + 1) for n, k in zip(grid.n, (k_x, k_y)))
        return Shape((X, Y), (shares[0] * X, shares[1] * Y), free, (k_x, k_y), (n_x, n_y))


def rounded(q: np.ndarray, spacing: float, ends: bool) -> np.ndarray:
    """Return the wave numbers of an axis; if it `ends`, without the kink of |q| at pi/spacing."""
    from scipy.special import erfc

    if not ends:
        return q
    width = np.sqrt(2) * ROUNDED
    t = (np.pi - abs(q) * spacing) / width
    return abs(q) - width / spacing * (np.exp(-t * t) / np.sqrt(np.pi) - t * erfc(t))


@lru_cache(maxsize=16)
def _half_space(shape: Shape, dtype: np.dtype) -> tuple[Images, Matrices]:
    """Return the Images of a shape and its `matrices_of` in a precision; do not change them."""
    waves = [2 * np.pi / size * np.arange(k + 1) for size, k in zip(shape.cell, shape.modes)]
    q_x, q_y = map(rounded, waves, np.divide(shape.cell, shape.points), shape.free)
    q = np.hypot(q_x[:, None], q_y)
    S = np.divide(2, q, out=np.zeros_like(q), where=q > 0)
    of_shape = images(*shape[:-1])
    return of_shape, matrices_of(of_shape, S, dtype)


def matrices_of(of_shape: Images, S: np.ndarray, dtype: np.dtype) -> Matrices:
    """Return {inverse: {parities: (stack, m, m)}}, added to K or S of the lowest modes."""
    return {
        inverse: {parity: matrix.astype(dtype) for parity, matrix in matrices.items()}
        for inverse, matrices in ((False, of_shape.inverse(S)), (True, of_shape.T))
    }


class Coupled(Multipliers):
    """Multipliers that also couple the lowest modes of the cell, by the images of its Shape.

    `couple` computes what that adds: `up` and `down` for wave numbers along x from 0 up and
    negative, `energy` for <u, K u> or <p, S p>. `norm` makes modes orthonormal; `unit`: factors for
    K and S.
    """

    alone = False

    def __init__(self, grid: Grid, fft: SlabFFT, q: Waves, of_shape: Images, matrices: Matrices):
        length = np.sqrt(np.prod(grid.sizes)) / grid.a
        super().__init__(grid, fft, q, uniform=1 / (of_shape.constant * length))
        self.comm = grid.comm
        self.by_columns = not of_shape.free[1]
        self.matrices = matrices
        self.modes = of_shape.modes
        self.edges = fft.edges
        self.unit = {False: fft.scale / length, True: fft.scale * length}
        middle = [(m - 1) / 2 * 2 * np.pi / n for m, n in zip(grid.nominal, grid.n)]
        k_x, k_y = (np.arange(k + 1) for k in of_shape.modes)
        self.shift_x = np.exp(1j * middle[0] * k_x)
        self.shift_y = np.exp(1j * middle[1] * k_y)
        # of this rank's rows alone
        self.shift_rows = np.exp(1j * (middle[0] - 2 * np.pi / grid.n[0] * grid.rows[0]) * k_x)
        self.norm = np.outer(*(np.where(k > 0, 2.0, np.sqrt(2)) for k in (k_x, k_y))) / 2
        self.parts = np.zeros((4, *self.norm.shape))
        self.scratch = np.zeros(self.norm.size, fft.dtype)
        self.up = np.zeros(self.norm.shape, complex)
        self.down = np.zeros(self.norm.shape, complex)[1:]
        self.energy = 0.0

    def couple(self, fft: SlabFFT, inverse: bool) -> None:
        """Compute what the coupling of the lowest modes adds; `multiply` adds it. Collective."""
        from scipy.fft import fft as transform

        waves = transform(fft.first_columns(self.norm.shape[1]), fft.n[0], axis=0)
        split(waves, self.shift_rows, self.shift_y, self.norm, self.parts)
        parts = self.parts = self.comm.sum(self.parts.ravel()).reshape(self.parts.shape)
        energy = 0.0
        for part, (a, b) in zip(parts, PARITIES):
            energy += multiply(
                part[int(a < 0) :, int(b < 0) :],
                self.matrices[inverse][a, b],
                self.by_columns,
                self.scratch,
            )
        self.energy = energy * self.unit[inverse]
        join(
            self.parts,
            self.shift_x,
            self.shift_y,
            self.norm,
            self.unit[inverse],
            self.up,
            self.down,
        )

    def multiply(self, block: np.ndarray, m: int, inverse: bool) -> float:
        """Multiply the columns of a block; the energy of the coupled modes counts in block 0."""
        energy = super().multiply(block, m, inverse)
        columns = slice(int(self.edges[m]), int(min(self.edges[m + 1], self.modes[1] + 1)))
        width = columns.stop - columns.start
        if width > 0:
            block[:width, : self.modes[0] + 1] += self.up[:, columns].T
            block[:width, block.shape[1] - self.modes[0] :] += self.down[:, columns].T
        return energy + (self.energy if m == 0 else 0.0)
