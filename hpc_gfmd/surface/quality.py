"""What a reader should know of a height map before the numbers that come from it, and whether it is
periodic: as the scene or the file says, else by the jump between its opposite edges."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..util.errors import SceneError
from .slabs import local, own_slabs, summed, with_neighbours
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


class MapQuality:
    """Sums and medians over a Topography, read once. Collective.

    jumps: for each axis the jump from the last point to the first one over that between neighbours,
    medians, which a few outliers do not change; typical: how much neighbours differ; tilt: share of
    the variance of the heights that a plane of the typical slope takes off, which a step has not;
    unresolved: see Doubt, the larger one of both axes.
    """

    def __init__(self, found: Topography, comm: Any) -> None:
        x, y = (np.arange(n) - (n - 1) / 2 for n in found.n)
        sums, rows = local(comm, lambda: _looked_at(found, comm, x, y))
        z, zz, zx, zy = comm.sum(sums)
        medians = np.nan_to_num([*map(_median, np.concatenate(comm.allgather(rows)).T)])
        ends = local(comm, lambda: found.rows(0, 1) - found.rows(len(x) - 1, len(x)))
        one, two, slope = medians[:6].reshape(2, 3).T  # along x, y
        edge = np.nan_to_num([_typical(ends), medians[6]])
        N = len(x) * len(y)
        variance = zz - z * z / N
        taken = sum(  # by a plane of these slopes
            m * (2 * part - m * (N / len(k)) * (k @ k))
            for m, part, k in zip(slope, (zx, zy), (x, y))
        )
        self.tilt = max(float(taken / variance), 0.0) if variance > 0 else 0.0
        self.typical = one.max()
        least = DOUBT.rounding * np.sqrt(zz / N)
        with np.errstate(divide="ignore", invalid="ignore"):
            self.jumps = np.where((edge > least) & (one > 0), edge / one, 0.0)
            self.unresolved = np.where(two > 0, (2 * one / two) ** 2, 0.0).max()

    def notes(self, meet: Sequence[bool]) -> list[str]:
        """One line for each doubt; meet: whether the opposite edges as they are will be neighbours,
        along x, along y."""
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


def notes_on(found: Topography, spec: Any, comm: Any) -> list[str]:
    """Notes on a Topography. Collective.

    Raises SceneError where nobody says what its boundary is and it does not look periodic.
    """
    quality = MapQuality(found, comm)
    if spec.mirror or spec.window != "none":  # periodic whatever its edges are
        return quality.notes((False, False))
    for axis, jump in zip("xy", quality.jumps):
        if jump > DOUBT.jump and spec.boundary is None and not found.periodic:
            raise SceneError(
                f"surface.boundary: not given, with edges along {axis} that differ by {jump:.3g}"
                ' times what neighbouring points differ by, allowed: "free" (it ends there),'
                ' "periodic" (pressed with that jump), or detrend = "tilt", mirror = true, a'
                " window"
            )
    return quality.notes([not ends for ends in spec.free])


def slope_notes(g_rms: float, measured: bool) -> list[str]:
    """Of any surface; measured: it is no formula, of which any slope may be asked."""
    low, high = DOUBT.slopes
    if g_rms > high or (measured and 0 < g_rms < low):
        return [f"g_rms = {g_rms:.2g}: heights and sizes {DIFFERENT_UNITS}"]
    steep = g_rms > DOUBT.steep
    return [f"g_rms = {g_rms:.3g}: the theory is that of small slopes"] if steep else []


def outliers(found: Topography, quality: MapQuality, comm: Any) -> int:
    """Count points of a Topography that stand out of the median of their neighbours. Collective."""
    n_x, n_y = found.n

    def count() -> list[int]:
        total = 0
        for start, stop in own_slabs(n_x, comm) if min(n_x, n_y) > 2 else ():
            z = with_neighbours(found, start, stop, mode="reflect")
            around = np.lib.stride_tricks.sliding_window_view(z, (3, 3)).reshape(-1, 9)
            beside = np.delete(around, 4, axis=1)
            out = (
                np.abs(around[:, 4] - np.median(beside, axis=1)) > DOUBT.outlying * quality.typical
            )
            total += int(np.count_nonzero(out))
        return [total]

    return int(summed(comm, count)[0])


def load_notes(p_mean: float, E_star: float, g_rms: float, unit: str) -> list[str]:
    """Notes on a mean pressure p_mean beside the modulus E_star, on a surface of slope g_rms; unit:
    of a measured one."""
    found = [NO_MODULUS] if unit and E_star == 1 else []
    if p_mean > DOUBT.overload * E_star * max(g_rms, 1.0):
        found.append(f"p = {p_mean / E_star:.2g} E*: loads and moduli {DIFFERENT_UNITS}")
    return found


def _looked_at(
    found: Topography, comm: Any, x: np.ndarray, y: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """This rank's sums, and numbers of some of its rows: along x, and then along y, how much
    neighbours and every second point differ, and the slope; the jump from the row's end to its
    beginning."""
    total, rows, n_x = np.zeros(4), [], found.n[0]
    lags = [min(DOUBT.lag, max(n // 8, 1)) for n in found.n]
    every = -(-n_x // DOUBT.rows)
    for start, stop in own_slabs(n_x, comm):
        z = found.rows(start, min(stop + max(2, lags[0]), n_x))
        mine = z[: stop - start]
        total += [
            mine.sum(),
            np.sum(mine**2),
            x[start:stop] @ mine.sum(axis=1),
            y @ mine.sum(axis=0),
        ]
        for i in range(-start % every, len(mine), every):
            numbers = []
            for axis, lag in enumerate(lags):
                ahead = [_ahead(z, i, k, axis) for k in (1, 2, lag)]
                numbers += [_typical(ahead[0]), _typical(ahead[1]), _median(ahead[2]) / lag]
            rows.append([*numbers, abs(z[i, 0] - z[i, -1]) or np.nan])
    return total, np.array(rows).reshape(-1, 7)


def _ahead(z: np.ndarray, i: int, k: int, axis: int) -> np.ndarray:
    """How much the points k further along an axis differ from those of row i."""
    if axis:
        return z[i, k:] - z[i, :-k]
    return (z[i + k : i + k + 1] - z[i]).ravel()  # none beyond the map


def _typical(differences: np.ndarray) -> float:
    """Their median without sign, of those that are not 0, as many of rounded heights are."""
    return _median(np.abs(differences[differences != 0]))


def _median(values: np.ndarray) -> float:
    values = values[~np.isnan(values)]
    return float(np.median(values)) if values.size else float("nan")
