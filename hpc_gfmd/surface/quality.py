"""Notes on a height map that a user should read before its results, and a check of its boundary.

A map is periodic if the scene or the file says so, else if its opposite edges do not jump.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..parallel.comm import SerialComm
from ..parallel.guard import on_rank_0
from ..util.errors import SceneError
from .slabs import with_neighbours
from .topography import Topography


@dataclass(frozen=True)
class Doubt:
    """Thresholds above which a height map triggers a note (chosen by hand).

    Attributes
    ----------
    tilt : float
        Share of the variance of the heights that is tilt.
    unresolved : float
        Mean square slope between neighbours over that between second neighbours: near 1 if the grid
        resolves the spectrum.
    filled : float
        Share of the points that had no height.
    jump : float
        Difference between opposite edges over that between neighbours.
    kink : float
        Change of slope at the edge over that inside.
    outlying : float
        Distance of a height from the median of its neighbours over the difference of neighbours.
    faded : float
        Relative change of h_rms or g_rms by a window.
    rounding : float
        Opposite edges count as equal if they differ by less than this share of the rms height.
    rows : int
        Number of rows that are looked at, at most.
    lag : int
        Distance, in points, of the heights from which the tilt is taken, at most.
    """

    tilt: float = 0.5
    unresolved: float = 1.2
    filled: float = 0.1
    jump: float = 3.0
    kink: float = 8.0
    outlying: float = 10.0
    faded: float = 0.1
    rounding: float = 1e-12
    rows: int = 512
    lag: int = 16


DOUBT = Doubt()


@dataclass(frozen=True)
class MapQuality:
    """Statistics of some rows of a Topography, mostly medians, which a few outliers do not change.

    Attributes
    ----------
    jumps : ndarray, shape (2,)
        Along x and y: difference between last and first point over that between neighbours.
    kinks : ndarray, shape (2,)
        Along x and y: change of slope at the edge over that inside.
    typical : float
        Median difference between neighbours, in the unit of the heights; the larger one of both
        axes.
    tilt : float
        Share of the variance of the heights that a plane with the median slope removes. A step does
        not count as tilt.
    unresolved : float
        Measure of unresolved roughness, see Doubt; the larger one of both axes.
    h_rms : float
        In the unit of the heights.
    g_rms : float
        From differences between neighbours.
    """

    jumps: np.ndarray
    kinks: np.ndarray
    typical: float
    tilt: float
    unresolved: float
    h_rms: float
    g_rms: float

    def notes(self, meet: Sequence[bool]) -> list[str]:
        """Return notes on jumps and kinks at the edges, tilt, and an unresolved spectrum.

        Parameters
        ----------
        meet : (bool, bool)
            Along x, along y: whether opposite edges become neighbours as they are, so that jumps
            and kinks there matter.

        Returns
        -------
        list of str
            One line for each threshold of `Doubt` that is exceeded.
        """
        lines = []
        for axis, jump, kink, edges_meet in zip("xy", self.jumps, self.kinks, meet):
            if edges_meet and jump > DOUBT.jump:
                lines.append(
                    f"opposite edges along {axis} differ by {jump:.3g} times what neighbouring"
                    " points differ by: the jump is pressed, too"
                )
            elif edges_meet and kink > DOUBT.kink:
                lines.append(
                    f"opposite edges along {axis} meet in a kink: the slope changes there"
                    f' {kink:.3g} times as much as inside (surface.boundary = "free" for a single'
                    " body, such as a lens)"
                )
        if self.tilt > DOUBT.tilt:
            lines.append(
                f"{100 * self.tilt:.0f} % of the variance of the heights is tilt (surface.detrend ="
                ' "tilt" removes it)'
            )
        if self.unresolved > DOUBT.unresolved:
            lines.append(
                "the spectrum is not resolved: it has power at the shortest waves of the grid, so"
                " that more points would change g_rms and the area"
            )
        return lines


def quality_of(topography: Topography, comm: Any) -> MapQuality:
    """Compute statistics of a map. Collective: rank 0 reads at most DOUBT.rows groups of rows.

    Parameters
    ----------
    topography : Topography
        Without holes.
    comm : Comm

    Returns
    -------
    MapQuality
        The same on all ranks.
    """
    return on_rank_0(comm, "reading the surface", lambda: _measure_quality(topography))


def notes_on(topography: Topography, spec: Any, comm: Any) -> tuple[tuple[str, ...], MapQuality]:
    """Return notes on a Topography and its quality; its boundary must be known. Collective.

    Parameters
    ----------
    topography : Topography
        Without holes, before mirroring or a window makes it periodic.
    spec : scene.File
    comm : Comm

    Returns
    -------
    notes : tuple of str
        A line each.
    quality : MapQuality

    Raises
    ------
    SceneError
        If neither scene nor file gives the boundary and opposite edges jump.
    """
    quality = quality_of(topography, comm)
    made_periodic = spec.mirror or spec.window != "none"  # whatever its edges are
    is_told = made_periodic or spec.boundary is not None or topography.periodic
    for axis, jump in zip("xy", quality.jumps):
        if jump > DOUBT.jump and not is_told:
            raise SceneError(
                f"surface.boundary: not given, with edges along {axis} that differ by {jump:.3g}"
                ' times what neighbouring points differ by, allowed: "free" (it ends there),'
                ' "periodic" (pressed with that jump), or detrend = "tilt", mirror = true, a'
                " window"
            )
    notes = quality.notes([not (made_periodic or ends) for ends in spec.free])
    share = topography.filled / np.prod(topography.n)
    if share > DOUBT.filled:
        notes.append(f"{100 * share:.0f} % of the heights are filled, not measured")
    return tuple(notes), quality


def window_note(before: MapQuality, after: MapQuality, kept: float, name: str) -> tuple[str, ...]:
    """Return a note on what a window did to a map.

    Parameters
    ----------
    before, after : MapQuality
        Of the map without and with the window.
    kept : float
        Share of the area in which the window is more than 1/2.
    name : str
        Name of the window.

    Returns
    -------
    tuple of str
        One note; empty if h_rms and g_rms change by less than DOUBT.faded.
    """

    def change(name: str) -> float:
        values = getattr(before, name), getattr(after, name)
        return abs(values[1] / values[0] - 1) if values[0] else 0.0

    if max(change("h_rms"), change("g_rms")) < DOUBT.faded:
        return ()
    return (
        f"the window {name} takes h_rms from {before.h_rms:.3g} to {after.h_rms:.3g} and g_rms from"
        f" {before.g_rms:.3g} to {after.g_rms:.3g}; {100 * kept:.0f} % of the area keep more than"
        " half of their heights and bear the load: area and gap are not those of the map",
    )


def outliers(topography: Topography, typical: float) -> int:
    """Count points that differ far more from their neighbours than neighbours usually do.

    All heights are read, by this process. A point counts if it is farther than DOUBT.outlying *
    typical from the median of its eight neighbours.

    Parameters
    ----------
    topography : Topography
        Without holes.
    typical : float
        Typical difference between neighbours.

    Returns
    -------
    int
        0 for maps of fewer than three rows or columns.
    """
    from scipy.ndimage import median_filter

    if min(topography.n) < 3:
        return 0
    beside = np.ones((3, 3))
    beside[1, 1] = 0
    total = 0
    for _, z in with_neighbours(topography, SerialComm(), "reflect"):
        out = np.abs(z - median_filter(z, footprint=beside)) > DOUBT.outlying * typical
        total += int(np.count_nonzero(out[1:-1, 1:-1]))
    return total


@dataclass(frozen=True)
class _Differences:
    """Differences between the points of one row and others along an axis.

    Attributes
    ----------
    step : float
        Median difference from the next point, without sign and without zeros.
    second : float
        The same from the second next point.
    far : float
        Median slope over a longer distance, per point, with sign.
    bend : float
        Median change of the step from one point to the next, without sign and without zeros.
    square : float
        Mean square of the step.
    """

    step: float
    second: float
    far: float
    bend: float
    square: float


def _measure_quality(topography: Topography) -> MapQuality:
    """Compute the quality of a map from at most DOUBT.rows rows and their neighbours.

    Not collective: called on rank 0.
    """
    n_x, n_y = topography.n
    first = float(topography.rows(0, 1)[0, 0])

    def row(i: int) -> np.ndarray:
        """Read row i, shape (1, n_y), or (0, n_y) beyond the map; heights above the first point."""
        return topography.rows(min(i, n_x), min(i + 1, n_x)) - first

    def differences(z: np.ndarray, i: int, axis: int) -> _Differences:
        """Return the differences between row i, which is z, and the next points along an axis."""
        lag = min(DOUBT.lag, max(topography.n[axis] // 8, 1))
        if axis == 0:
            below = row(i + 1)
            further = row(i + 2)
            step = below - z
            second = further - z
            far = row(i + lag) - z
            bend = further - 2 * below + z if len(further) else further
        else:
            step, second, far = (z[:, k:] - z[:, :-k] for k in (1, 2, lag))
            bend = np.diff(step, axis=1)
        square = float(np.mean(step**2)) if step.size else float("nan")
        return _Differences(
            _typical(step), _typical(second), _median(far) / lag, _typical(bend), square
        )

    x = np.arange(0, n_x, -(-n_x // DOUBT.rows))
    y = np.arange(n_y) - (n_y - 1) / 2
    means = []
    squares = []
    along_y = []
    of_axes: tuple[list[_Differences], list[_Differences]] = ([], [])
    ends_of_rows = []
    for i in x.tolist():
        z = row(i)
        means.append(z.mean())
        squares.append(np.mean(z**2))
        along_y.append(np.mean(y * z))
        for axis in (0, 1):
            of_axes[axis].append(differences(z, i, axis))
        ends_of_rows.append([z[0, -2 % n_y], z[0, -1], z[0, 0], z[0, 1 % n_y]])
    ends = (
        np.concatenate([row((n_x - 2) % n_x), row(n_x - 1), row(0), row(1 % n_x)]),
        np.transpose(ends_of_rows),
    )

    def median_of(name: str) -> np.ndarray:
        return np.nan_to_num([_median([getattr(d, name) for d in axis]) for axis in of_axes])

    step = median_of("step")
    second = median_of("second")
    bend = median_of("bend")
    square = np.mean(squares)
    variance = square - np.mean(means) ** 2
    along_x = (x - x.mean()) @ np.array(means) / len(x)
    taken_by_plane = sum(
        m * (2 * part - m * k.var())
        for m, part, k in zip(median_of("far"), (along_x, np.mean(along_y)), (x, y))
    )
    edge = np.nan_to_num([_typical(rows[2] - rows[1]) for rows in ends])
    edge_bend = np.nan_to_num([_typical(np.diff(rows, n=2, axis=0)) for rows in ends])
    rounding = DOUBT.rounding * np.sqrt(square + first**2)
    mean_squares = [_mean([d.square for d in axis]) for axis in of_axes]
    spacings = [size / k for size, k in zip(topography.sizes, topography.n)]
    with np.errstate(divide="ignore", invalid="ignore"):
        return MapQuality(
            jumps=np.where((edge > rounding) & (step > 0), edge / step, 0.0),
            kinks=np.where((edge_bend > rounding) & (bend > rounding), edge_bend / bend, 0.0),
            typical=step.max(),
            tilt=max(float(taken_by_plane / variance), 0.0) if variance > 0 else 0.0,
            unresolved=np.where(second > 0, (2 * step / second) ** 2, 0.0).max(),
            h_rms=float(np.sqrt(max(variance, 0.0))),
            g_rms=float(np.sqrt(sum(m / a**2 for m, a in zip(mean_squares, spacings)))),
        )


def _typical(differences: np.ndarray) -> float:
    """Return the median of the magnitudes of differences that are not 0; nan if there are none.

    Rounded heights often differ by exactly 0.
    """
    return _median(np.abs(differences[differences != 0]))


def _median(values: Any) -> float:
    """Return the median of the values that are not nan; nan if there are none."""
    values = np.asarray(values, dtype=float)
    values = values[~np.isnan(values)]
    return float(np.median(values)) if values.size else float("nan")


def _mean(values: list[float]) -> float:
    """Return the mean of the values that are not nan; 0 if there are none."""
    numbers = [value for value in values if value == value]
    return float(np.mean(numbers)) if numbers else 0.0
