"""What a reader should know of a height map before the numbers that come from it, and whether it is
periodic: as the scene or the file says, else by the jump between its opposite edges."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..parallel.comm import SerialComm
from ..parallel.guard import on_rank_0
from ..util.errors import SceneError
from .slabs import own_slabs, with_neighbours
from .topography import Topography

DIFFERENT_UNITS = "are probably in different units"
NO_MODULUS = "no modulus is given: E_star = 1 is taken, and pressures are in units of E*"


@dataclass(frozen=True)
class Doubt:
    """From where on a map is doubted; chosen, not fitted. Slopes are g_rms, medians those of
    neighbouring points."""

    steep: float = 1.0 + 1e-6  # slope that is not small; 1 itself has rounding errors
    slopes: tuple[float, float] = (1e-5, 30.0)  # of real surfaces are between these
    overload: float = 10.0  # mean pressure over E*
    tilt: float = 0.5  # share of the variance of the heights
    # mean square slope between neighbours over that between every second point: 1 where the grid
    # resolves the spectrum
    unresolved: float = 1.2
    filled: float = 0.1  # share of the points
    jump: float = 3.0  # between opposite edges, over that between neighbours
    outlying: float = 10.0  # times what neighbours differ by: far from all of them
    rounding: float = 1e-12  # of the heights: edges that differ by less are the same
    rows: int = 512  # that medians are taken of
    lag: int = 16  # points over which slopes are taken, at most


DOUBT = Doubt()


@dataclass(frozen=True)
class MapQuality:
    """What some rows of a Topography show.

    jumps: for each axis the jump from the last point to the first one over that between neighbours,
    medians, which a few outliers do not change; typical: how much neighbours differ; tilt: share of
    the variance of the heights that a plane of the typical slope takes off, which a step has not;
    unresolved: see Doubt, the larger one of both axes.
    """

    jumps: np.ndarray
    typical: float
    tilt: float
    unresolved: float

    def notes(self, meet: Sequence[bool]) -> list[str]:
        """Return one line for each doubt; meet: whether the opposite edges as they are will be
        neighbours, along x, along y."""
        found = [
            f"opposite edges along {axis} differ by {jump:.3g} times what neighbouring points"
            " differ by: the jump is pressed, too"
            for axis, jump, edges in zip("xy", self.jumps, meet)
            if jump > DOUBT.jump and edges
        ]
        if self.tilt > DOUBT.tilt:
            found.append(
                f"{100 * self.tilt:.0f} % of the variance of the heights is tilt (surface.detrend ="
                ' "tilt" removes it)'
            )
        if self.unresolved > DOUBT.unresolved:
            found.append(
                "the spectrum is not resolved: it has power at the shortest waves of the grid, so"
                " that more points would change g_rms and the area"
            )
        return found


def quality_of(found: Topography, comm: Any) -> MapQuality:
    """Look at a Topography, of which rank 0 reads DOUBT.rows rows at most. Collective."""
    return on_rank_0(comm, "reading the surface", lambda: _looked_at(found))


def notes_on(found: Topography, spec: Any, comm: Any) -> tuple[str, ...]:
    """Return the notes on a Topography. Collective.

    Raises SceneError where nobody says what its boundary is and it does not look periodic.
    """
    quality = quality_of(found, comm)
    made_periodic = spec.mirror or spec.window != "none"  # whatever its edges are
    for axis, jump in zip("xy", quality.jumps):
        said = made_periodic or spec.boundary is not None or found.periodic
        if jump > DOUBT.jump and not said:
            raise SceneError(
                f"surface.boundary: not given, with edges along {axis} that differ by {jump:.3g}"
                ' times what neighbouring points differ by, allowed: "free" (it ends there),'
                ' "periodic" (pressed with that jump), or detrend = "tilt", mirror = true, a'
                " window"
            )
    notes = quality.notes([not (made_periodic or ends) for ends in spec.free])
    share = found.filled / np.prod(found.n)
    if share > DOUBT.filled:
        notes.append(f"{100 * share:.0f} % of the heights are filled, not measured")
    return tuple(notes)


def slope_notes(g_rms: float, measured: bool) -> list[str]:
    """Return what is doubtful about the slope of a surface; measured: it is no formula, of which
    any slope may be asked."""
    low, high = DOUBT.slopes
    if g_rms > high or (measured and 0 < g_rms < low):
        return [f"g_rms = {g_rms:.2g}: heights and sizes {DIFFERENT_UNITS}"]
    steep = g_rms > DOUBT.steep
    return [f"g_rms = {g_rms:.3g}: the theory is that of small slopes"] if steep else []


def outliers(found: Topography, typical: float) -> int:
    """Count points of a Topography that stand out of the median of their neighbours; typical: how
    much neighbours differ."""
    from scipy.ndimage import median_filter

    if min(found.n) < 3:
        return 0
    beside, total = np.ones((3, 3)), 0
    beside[1, 1] = 0
    for start, stop in own_slabs(found, SerialComm()):
        z = with_neighbours(found, start, stop, "reflect")
        out = np.abs(z - median_filter(z, footprint=beside)) > DOUBT.outlying * typical
        total += int(np.count_nonzero(out[1:-1, 1:-1]))
    return total


def load_notes(p_mean: float, E_star: float, g_rms: float, unit: str) -> list[str]:
    """Return what is doubtful about a mean pressure p_mean beside the modulus E_star, on a surface
    of slope g_rms; unit: of a measured one."""
    found = [NO_MODULUS] if unit and E_star == 1 else []
    if p_mean > DOUBT.overload * E_star * max(g_rms, 1.0):
        found.append(f"p = {p_mean / E_star:.2g} E*: loads and moduli {DIFFERENT_UNITS}")
    return found


def _looked_at(found: Topography) -> MapQuality:
    n_x, n_y = found.n

    def row(i: int) -> np.ndarray:
        return found.rows(min(i, n_x), min(i + 1, n_x))  # none beyond the map

    def differences(z: np.ndarray, i: int, axis: int) -> tuple[float, float, float]:
        """Return how much neighbours and every second point differ in row i, and the slope."""
        lag = min(DOUBT.lag, max(found.n[axis] // 8, 1))
        one, two, far = (z[:, k:] - z[:, :-k] if axis else row(i + k) - z for k in (1, 2, lag))
        return _typical(one), _typical(two), _median(far) / lag

    x, y = np.arange(0, n_x, -(-n_x // DOUBT.rows)), np.arange(n_y) - (n_y - 1) / 2
    moments, of_axes, ends = [], [], []
    for i in x.tolist():
        z = row(i)
        moments.append([z.mean(), np.mean(z**2), np.mean(y * z)])
        of_axes.append([differences(z, i, axis) for axis in (0, 1)])
        ends.append(z[0, 0] - z[0, -1])
    one, two, slope = (np.nan_to_num([*map(_median, kind)]) for kind in np.transpose(of_axes))
    mean, square, along_y = np.mean(moments, axis=0)
    along_x = (x - x.mean()) @ np.array(moments)[:, 0] / len(x)
    variance = square - mean**2
    taken = sum(  # by a plane of these slopes
        m * (2 * part - m * k.var()) for m, part, k in zip(slope, (along_x, along_y), (x, y))
    )
    edge = np.nan_to_num([_typical(row(0) - row(n_x - 1)), _typical(np.array(ends))])
    least = DOUBT.rounding * np.sqrt(square)
    with np.errstate(divide="ignore", invalid="ignore"):
        return MapQuality(
            jumps=np.where((edge > least) & (one > 0), edge / one, 0.0),
            typical=one.max(),
            tilt=max(float(taken / variance), 0.0) if variance > 0 else 0.0,
            unresolved=np.where(two > 0, (2 * one / two) ** 2, 0.0).max(),
        )


def _typical(differences: np.ndarray) -> float:
    """Return the median of differences without sign. It leaves out those that are 0, as many of
    rounded heights are."""
    return _median(np.abs(differences[differences != 0]))


def _median(values: np.ndarray) -> float:
    values = values[~np.isnan(values)]
    return float(np.median(values)) if values.size else float("nan")
