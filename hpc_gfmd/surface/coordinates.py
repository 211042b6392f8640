"""Coordinates in a text: columns x, y, z, or the first line and column of a table."""

from dataclasses import dataclass

import numpy as np

from .metadata import UNEVEN

FEWEST = 8  # numbers that do not rise evenly by chance
NO_GRID = "its points are not those of a regular grid"
ON_A_LINE = "its points lie on one line, a profile, allowed: points of a regular grid"
SPARSE = 8  # times as many points of a grid as are given, at most


@dataclass(frozen=True)
class GridAxis:
    """Grid lines on which points lie along one axis.

    Attributes
    ----------
    index : ndarray of int
        Grid line of each point, from 0, rising with its coordinate.
    n : int
        Number of lines.
    step : float
        Distance between lines.
    """

    index: np.ndarray
    n: int
    step: float


def grid_axis(coordinates: np.ndarray) -> GridAxis:
    """Find the evenly spaced lines on which points with these coordinates lie.

    Coordinates may deviate by rounding to the digits that are written. Lines on which no point lies
    are counted, too.

    Parameters
    ----------
    coordinates : ndarray, shape (points,)

    Returns
    -------
    GridAxis

    Raises
    ------
    ValueError
        If the points do not lie on at least two evenly spaced lines, of which at least 1/SPARSE
        have a point.
    """
    values = np.unique(coordinates)
    if not np.isfinite(values).all() or values.size < 2:
        raise ValueError(NO_GRID)
    gaps = np.diff(values)
    wide = gaps[gaps > 0.25 * gaps.max()]
    n = int(np.rint(wide / np.median(wide)).sum()) + 1
    if n > SPARSE * values.size:
        raise ValueError(NO_GRID)
    if n == values.size and np.ptp(gaps) <= UNEVEN * gaps.mean():
        origin = float(values[0])
        step = float(gaps.mean())
    else:
        line = np.rint((values - values[0]) * (n - 1) / (values[-1] - values[0]))
        step, origin = np.polyfit(line, values, 1).tolist()
        deviation = np.abs(values - origin - line * step)
        allowed = UNEVEN * step + 0.6 * _rounding(values)
        if (deviation > np.minimum(allowed, 0.3 * step)).any():
            raise ValueError(NO_GRID)
    return GridAxis(np.rint((coordinates - origin) / step).astype(np.intp), n, step)


def points_on_grid(
    x: np.ndarray, y: np.ndarray, z: np.ndarray
) -> tuple[np.ndarray, tuple[float, float]]:
    """Put points, given in any order, on a regular grid.

    Parameters
    ----------
    x, y, z : ndarray, shape (points,)

    Returns
    -------
    heights : ndarray, shape (n_x, n_y)
        nan at grid points that are not given.
    sizes : (L_x, L_y)
        Number of points times their distance.

    Raises
    ------
    ValueError
        If the points do not lie on a grid, fill less than 1/SPARSE of it, or one is there twice.
    """
    across = np.abs(np.ptp(y) * (x - x.min()) - np.ptp(x) * (y - y.min()))
    across_falling = np.abs(np.ptp(y) * (x - x.min()) - np.ptp(x) * (y.max() - y))
    if min(across.max(), across_falling.max()) <= UNEVEN * np.ptp(x) * np.ptp(y) / x.size:
        raise ValueError(ON_A_LINE)
    along_x = grid_axis(x)
    along_y = grid_axis(y)
    if along_x.n * along_y.n > SPARSE * z.size:
        raise ValueError(NO_GRID)
    heights = np.full((along_x.n, along_y.n), np.nan)
    place = along_x.index * along_y.n + along_y.index
    if np.unique(place).size < place.size:
        raise ValueError("it has a point twice")
    heights.ravel()[place] = z
    return heights, (along_x.step * along_x.n, along_y.step * along_y.n)


def is_grid(table: np.ndarray) -> bool:
    """Whether the first two columns of a table are x, y of every point of a grid, each once."""
    x = table[:, 0]
    y = table[:, 1]
    if np.unique(x).size * np.unique(y).size != len(table):
        return False
    try:
        heights, _ = points_on_grid(x, y, np.zeros(len(table)))
    except ValueError:
        return False
    return bool(np.isfinite(heights).all())


def changes_evenly(values: np.ndarray, fewest: int = 3) -> bool:
    """Whether numbers rise or fall in even steps, as coordinates do.

    Parameters
    ----------
    values : ndarray
    fewest : int
        False for fewer numbers than this, which may be even by chance.

    Returns
    -------
    bool
    """
    if values.size < fewest or not np.isfinite(values).all():
        return False
    steps = np.diff(values)
    step = steps.mean()
    allowed = np.minimum(UNEVEN * abs(step) + _rounding(values)[1:], 0.05 * abs(step))
    return bool(step and (np.abs(steps - step) <= allowed).all())


def numbers_from_0(values: np.ndarray) -> bool:
    """Whether values are 0, 1, 2, ..., at least two of them."""
    return values.size > 1 and bool(np.array_equal(values, np.arange(values.size)))


def is_plane(table: np.ndarray) -> bool:
    """Whether the values of a table lie on a plane, so that even steps do not show coordinates.

    They may deviate by a tenth of the mean step along the axis on which it is larger.
    """
    lines, columns = (np.arange(n) / max(n - 1, 1) for n in table.shape)
    corner = table[0, 0]
    steps = [abs(table[-1, 0] - corner) / len(lines), abs(table[0, -1] - corner) / len(columns)]
    allowed = 0.1 * max(steps)
    across = corner + columns * (table[0, -1] - corner)
    planes = (across + line * (table[-1, 0] - corner) for line in lines)
    return all(np.abs(row - plane).max() <= allowed for row, plane in zip(table, planes))


def _rounding(values: np.ndarray) -> np.ndarray:
    """Return one unit of the last digit with which each coordinate was written, shape (points,).

    All are taken to have as many decimals, or as many significant digits, as the one with the most,
    whichever is coarser; 0 if one has more than 12 digits, and so was not rounded.
    """
    written = [np.format_float_scientific(abs(value)).split("e") for value in values.tolist()]
    digits = np.array([len(mantissa.replace(".", "")) for mantissa, _ in written])
    powers = np.array([int(power) for _, power in written])
    significant = digits.max()
    if significant > 12:  # written in full
        return np.zeros(values.size)
    decimals = (digits - 1 - powers).max()
    return np.maximum(10.0**-decimals, 10.0 ** (powers + 1 - significant))
