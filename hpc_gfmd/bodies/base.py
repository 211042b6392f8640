"""What an elastic body is: its stiffness K(q) on any grid, and what solvers derive from it.

Units as in operators/problem.py: E* = 1, in-plane lengths in grid spacings a. Load control
eliminates the rigid translation: K(0) = 0 and S = 1/K has zero mean; the response to a uniform
pressure (`stiffness` at q = 0) enters the approach alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any, TypeVar

import numpy as np

from ..kernels.spectral import multiply
from ..parallel.coarsening import levels
from ..parallel.fft import SlabFFT
from ..parallel.grid import Grid
from ..scene import Material

NEAR_POINTS = 64  # along an axis are enough to know what K is between neighbours
SAMPLES = 400  # of K between the longest and the shortest wave, where it may not be monotone
FLAT = 6  # exponent that suppresses levels where K is flat
LEFT = 0.3  # wave number over the largest: the typical one of what solvers leave
NOTHING = 1e30  # a stiffness against which a level does nothing
STEEP = 4  # times as long: what coarser levels see of a wave
SQRT2 = np.sqrt(2.0)

T = TypeVar("T")
Waves = tuple[np.ndarray, np.ndarray]  # wave numbers along x and along y


def once_per_grid(method: Callable[[Any, Grid], T]) -> Callable[[Any, Grid], T]:
    """Decorate a method of bodies: its value is kept for each body and size of grid."""

    @wraps(method)
    def known(self: Any, grid: Grid) -> T:
        return grid.once((method, self), lambda: method(self, grid))

    return known


class Multipliers:
    """Multiplies the columns of a spectrum by K/N or S/N in place (the transforms leave out 1/N).

    K is the stiffness, S = 1/K, N the number of points of the grid. Blocks of W columns are dealt
    out to the ranks in turn.

    Parameters
    ----------
    grid : Grid
        The grid of the fields.
    fft : SlabFFT
        The transforms that make the columns.
    q : (q_x, q_y)
        Wave numbers along x, (n_x,), and of the columns, (blocks of this rank, W), in 1/a. Without
        a table K is |q|/2.
    table : array (blocks of this rank, W, n_x//2 + 1), optional
        K of the columns at the wave numbers >= 0 along x, for other bodies; it is kept, not copied.
    uniform : float
        See below.

    Attributes
    ----------
    uniform : float
        Stiffness K(0) against a uniform pressure, in 1/a, which the multiplication leaves out. A
        uniform pressure moves some bodies without end: 0 for the periodic half-space, nan for one
        that is free along one axis alone.
    factors : tuple
        The factors as kernels/spectral.py: multiply takes them.
    alone : bool
        Whether multiplying by `factors` is all that has to be done: then compiled passes multiply
        many blocks in one call. If not, `multiply` must be called for every block.
    """

    alone = True

    def __init__(
        self,
        grid: Grid,
        fft: SlabFFT,
        q: Waves,
        table: np.ndarray | None = None,
        uniform: float = 0.0,
    ):
        self.dtype = fft.dtype
        self.ranks = grid.comm.size
        self.uniform = uniform
        weight = np.ascontiguousarray(grid.column_tables(fft)[1][grid.comm.rank :: self.ranks])
        # kernels see real and imaginary parts as numbers of their own
        waves = (np.ascontiguousarray(a, fft.dtype) for a in (np.repeat(q[0], 2), q[1]))
        self.factors = fft.dtype.type(fft.scale), weight, *waves, table

    def couple(self, fft: SlabFFT, inverse: bool) -> None:
        """Prepare the coupling of modes in different columns; does nothing for this class.

        To be called once before the columns of a field are multiplied. Collective.

        Parameters
        ----------
        fft : SlabFFT
            Holds the row spectra of the field.
        inverse : bool
            Whether the field will be multiplied by S.
        """

    def multiply(self, block: np.ndarray, m: int, inverse: bool) -> float:
        """Multiply the columns of a block by K/N, or by S/N (0 where K is 0), in place.

        Parameters
        ----------
        block : array (W, n_x), complex
            Columns of the spectrum.
        m : int
            Number of the block among those of all ranks; it must be one of this rank.
        inverse : bool
            Multiply by S.

        Returns
        -------
        float
            Share of these columns in <u, K u>, or with `inverse` in <p, S p>, where u or p is the
            field before the multiplication.
        """
        return float(multiply(block.view(self.dtype), m // self.ranks, inverse, *self.factors))


class Body:
    """An elastic body, given by its stiffness K as a function of |q|.

    To add a body, put a file into bodies/ with a subclass that has `of` and `stiffness`; all else
    follows from these. Bodies are frozen dataclasses and so hashable.

    Attributes
    ----------
    name : str
        Name of the body's file.
    table_share : float
        Size of the table of K in each precision, in numbers per point of the grid; 0 without one.
    full_p_star : float
        Mean pressure over E* g_rms below which full contact is taken to be impossible: the pressure
        that flattens a surface varies by std(p) >= E* g_rms/2 about its mean (unless the surface is
        very skewed).
    error : float
        Bound of the relative error of the pressure (L2) that comes from approximations in S.
    sources : tuple of str
        Papers that K is from, with DOI.
    """

    name = ""
    sources: tuple[str, ...] = (
        "Johnson, Contact Mechanics (1985), doi:10.1017/CBO9781139171731",
        "Stanley, Kato, J. Tribol. 119 (1997) 481, doi:10.1115/1.2833523",
    )
    table_share = 0.25
    full_p_star = 0.499
    error = 0.0

    @classmethod
    def of(cls, material: Material, free: Sequence[bool]) -> Body | None:
        """Return the body of this kind that a scene describes.

        Parameters
        ----------
        material : scene.Material
            The table [material] of the scene; lengths in the unit of the surface's.
        free : pair of bool
            Whether the boundaries along x, along y are free instead of periodic.

        Returns
        -------
        Body or None
            None if the scene describes another kind of body.
        """
        raise NotImplementedError

    @classmethod
    def examples(cls) -> list[Body]:
        """Return a few bodies of this kind, for the contract tests."""
        return [cls()]

    def stiffness(self, q: np.ndarray, a: float) -> np.ndarray:
        """Return the stiffness K, for E* = 1.

        Parameters
        ----------
        q : array
            Wave numbers >= 0, in units of 1/a.
        a : float
            Grid spacing in the unit of the body's own lengths.

        Returns
        -------
        array
            K in units of 1/a, in the shape of q.
        """
        raise NotImplementedError

    def waves(self, grid: Grid, q_x: np.ndarray, q_y: np.ndarray) -> Waves:
        """Return the wave numbers at which K is computed on a grid; here its own, unchanged.

        Parameters
        ----------
        grid : Grid
            The grid.
        q_x, q_y : array
            Wave numbers of the grid along x and along y, in 1/a.

        Returns
        -------
        tuple of array
            Along x and along y, in the shapes of q_x and q_y; perhaps these arrays themselves.
        """
        return q_x, q_y

    def multipliers(self, grid: Grid, fft: SlabFFT) -> Multipliers:
        """Return this body's Multipliers for the transforms of a grid. Collective.

        They are made at the first call and kept in `fft`: later calls return the same object.

        Parameters
        ----------
        grid : Grid
            The grid.
        fft : SlabFFT
            Its transforms in one precision.

        Returns
        -------
        Multipliers
            Of this body.
        """
        if self not in fft.multipliers:
            q_y = grid.column_tables(fft)[0][grid.comm.rank :: grid.comm.size]
            q = self.waves(grid, grid.q_x, q_y)
            fft.multipliers[self] = self.make_multipliers(grid, fft, q)
        return fft.multipliers[self]

    def make_multipliers(self, grid: Grid, fft: SlabFFT, q: Waves) -> Multipliers:
        """Make the Multipliers from a table of K for this rank's columns. Collective.

        K is even in q_x, so the table has the columns' non-negative wave numbers.

        Parameters
        ----------
        grid : Grid
            The grid.
        fft : SlabFFT
            Its transforms in one precision; the Multipliers keep no reference to it.
        q : (q_x, q_y)
            Wave numbers (n_x,) and (blocks of this rank, W), in 1/a.

        Returns
        -------
        Multipliers
            Of this body.
        """
        q_x = q[0][: grid.n[0] // 2 + 1]
        q_y = q[1]
        table = np.empty((*q_y.shape, len(q_x)), fft.dtype)
        for block, q_block in zip(table, np.asarray(q_y, np.float64)):
            block[...] = self.stiffness(np.hypot(q_x, q_block[:, None]), grid.a)
        uniform = float(grid.comm.bcast(table[0, 0, 0] if table.size else 0.0))
        if grid.comm.rank == 0:
            table[0, 0, 0] = 0  # the rigid translation
        return Multipliers(grid, fft, q, table, uniform)

    @once_per_grid
    def scale(self, grid: Grid) -> float:
        """Return the finest level's weight: K (1/a) at the Brillouin zone's corner over sqrt 2."""
        return float(self.stiffness(np.array([SQRT2 * grid.q_nyquist]), grid.a)[0]) / SQRT2

    @once_per_grid
    def bounds(self, grid: Grid) -> tuple[float, float]:
        """Return the smallest and the largest K, in 1/a, of 400 samples over the grid's waves."""
        shortest = SQRT2 * grid.q_nyquist
        longest = min(
            (2 * np.pi * grid.a / size for size, n in zip(grid.sizes, grid.n) if n > 1),
            default=shortest,
        )
        K = self.stiffness(np.geomspace(longest, shortest, SAMPLES), grid.a)
        return float(K.min()), float(K.max())

    @once_per_grid
    def typical(self, grid: Grid) -> float:
        """Return a typical K (1/a) of waves in the residual, which turns an error of energy into
        one of pressure: the largest up to LEFT times the shortest, equal to `scale` where K goes as
        q.
        """
        shortest = SQRT2 * grid.q_nyquist
        K = self.stiffness(
            np.append(np.linspace(0, LEFT * shortest, SAMPLES)[1:], LEFT * shortest), grid.a
        )
        return float(K.max()) / (SQRT2 * LEFT)

    def weights(self, grid: Grid) -> np.ndarray:
        """Return the stiffness of each level of the preconditioner, finest first, relative to the
        finest.

        The larger it is, the less a level corrects. K of a level is the largest of its waves and
        longer ones, which finer levels correct too. Where it falls less than in proportion to q (a
        thin layer pressed by long waves) the next level has little to add: its weight rises up to
        NOTHING. Where it falls more (a soft base) it is at most twice the K of waves twice as long.
        The last level is the rigid translation, which only contact resists.
        """
        q = np.array([level.q for level in levels(grid)])
        longer = np.append(np.geomspace(q[-1] / q[0], 1.0, SAMPLES), 0)
        K, of_longer = (
            np.array([self.stiffness(SQRT2 * x * longer[longer <= 1], grid.a).max() for x in waves])
            for waves in (q, q / 2)
        )
        K[1:] = np.minimum(K, 2 * of_longer)[1:]
        fall_of_K = 1 - K[1:] / K[:-1]
        fall_of_q = 1 - q[1:] / q[:-1]
        with np.errstate(divide="ignore", invalid="ignore"):
            flatness = np.maximum(fall_of_q / fall_of_K, 1) ** FLAT
            weights = np.minimum(
                K / K[0] * np.append(1, np.where(fall_of_q > 0, flatness, 1)), NOTHING
            )
        weights[-1] = q[-1] / q[0]
        return weights

    def softness(self, grid: Grid) -> np.ndarray:
        """Return what each level adds to S, over S of the shortest wave; finest level first.

        <r, S r> of a field r of zero mean is bounded by its squares on the levels times these
        numbers (operators/multilevel.py): the largest S of shorter waves, or as for S in proportion
        to 1/q up to waves STEEP times as long, of which coarser levels see a part.
        """
        q = np.array([level.q for level in levels(grid)])
        shorter = np.append(np.geomspace(q[-1] / q[0], 1.0, SAMPLES) * q[0], q)
        K = self.stiffness(SQRT2 * shorter, grid.a)
        largest = np.array([1 / K[shorter >= x].min() for x in q])
        S = np.maximum(largest, 1 / STEEP / self.stiffness(SQRT2 / STEEP * q, grid.a))
        share = 1 - q[1:] / q[:-1]
        with np.errstate(divide="ignore", invalid="ignore"):
            added = np.where(share > 0, (S[1:] - S[:-1]) / share, S[1:])
        return np.append(S[0], added) / largest[0]

    @once_per_grid
    def near(self, grid: Grid) -> np.ndarray:
        """Return K in real space (1/a): itself, neighbours along x, along y, diagonal; shape (4,).

        These are pressures, for E* = 1, where one point is displaced by 1 and others are held; 0
        along an axis of less than three points. The array is cached: do not change it.
        """
        n_x, n_y = (min(k, NEAR_POINTS) for k in grid.n)
        q_x, q_y = (
            2 * np.pi * np.fft.fftfreq(k) * grid.a / s for k, s in zip((n_x, n_y), grid.spacings)
        )
        K = np.fft.ifft2(self.stiffness(np.hypot(q_x[:, None], q_y), grid.a)).real
        has_x = n_x > 2
        has_y = n_y > 2
        along_x = K[1 % n_x, 0] * has_x
        along_y = K[0, 1 % n_y] * has_y
        diagonal = K[1 % n_x, 1 % n_y] * (has_x and has_y)
        return np.array([K[0, 0], along_x, along_y, diagonal])

    @once_per_grid
    def point_compliance(self, grid: Grid) -> float:
        """Return S between a point and itself, the displacement of a point under its own pressure.

        A pressure of E* on this point alone moves it so far relative to the mean of the grid.

        Parameters
        ----------
        grid : Grid
            Only its spacings and numbers of points are used.

        Returns
        -------
        float
            The mean of 1/K over all waves but the uniform one, in units of a. Few waves are summed:
            64 per axis, with finer and finer wave numbers for the longest ones.
        """
        left, unit, total = np.array(grid.n), np.array(grid.spacings) / grid.a, 0.0
        weight = 1.0
        while left.max() > 1:
            points = np.minimum(left, NEAR_POINTS)
            q_x, q_y = (2 * np.pi * np.fft.fftfreq(k) / s for k, s in zip(points, unit))
            q = np.hypot(q_x[:, None], q_y).ravel()[1:]
            weight /= points.prod()
            total += weight * float(np.sum(1 / self.stiffness(q, grid.a)))
            left = -(-left // points)
            unit = unit * points
        return total
