"""What a reader should know of a height map before the numbers that come from it, and whether it is
periodic: as the scene or the file says, else by the jump between its opposite edges."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..util.errors import SceneError
from .slabs import local, own_slabs, summed
from .topography import Topography

STEEP = 1.0 + 1e-6  # g_rms beyond which slopes are not small; 1 itself has rounding errors
ABSURD = 1e-5, 30.0  # g_rms of real surfaces is between them
OVERLOADED = 10.0  # mean pressure over E*
DIFFERENT_UNITS = "are probably in different units"
NO_MODULUS = "no modulus is given: E_star = 1 is taken, and pressures are in units of E*"
TILT = 0.5  # share of the variance of the heights
# mean square slope between neighbours over that between every second point: 1 where the grid
# resolves the spectrum
UNRESOLVED = 1.2
FILLED = 0.1  # share of the points
ROUNDING = 1e-12  # of the heights: edges that differ by less are the same
# jump between opposite edges over that between neighbouring points (medians), up to which it is one
# of them
JUMP = 3.0
SAMPLED, LAG = 512, 16  # rows that medians are taken of; points over which slopes are, at most
OUTLYING = 10.0  # times what neighbours differ by (median): a point that is so far from all of them


class MapQuality:
    """Sums and medians over a Topography, read once. Collective.

    jumps: for each axis the jump from the last point to the first one over that between neighbours,
    medians, which a few outliers do not change; typical: how much neighbours differ; tilt: share of
    the variance of the heights that a plane of the typical slope takes off, which a step has not;
    unresolved: see UNRESOLVED, the larger one of both axes.
    """

    def __init__(self, found: Topography, comm: Any) -> None:
        x, y = (np.arange(n) - (n - 1) / 2 for n in found.n)
        sums, rows = local(comm, lambda: _looked_at(found, comm, x, y))
        z, zz, zx, zy = comm.sum(sums)
        columns = np.concatenate(comm.allgather(rows)).T
        one_x, two_x, slope_x, one_y, two_y, slope_y, edge_y = np.nan_to_num(
            [_median(column[~np.isnan(column)]) for column in columns]
        )
        ends = local(comm, lambda: found.rows(0, 1) - found.rows(len(x) - 1, len(x)))
        edge_x = np.nan_to_num(_typical(ends))
        N = len(x) * len(y)
        variance = zz - z * z / N
        taken = sum(  # by a plane of these slopes
            slope * (2 * part - slope * (N / len(k)) * (k @ k))
            for slope, part, k in ((slope_x, zx, x), (slope_y, zy, y))
        )
        self.tilt = max(float(taken / variance), 0.0) if variance > 0 else 0.0
        self.typical = max(one_x, one_y)
        least = ROUNDING * np.sqrt(zz / N)
        self.jumps = [
            float(edge / one) if edge > least and one > 0 else 0.0
            for edge, one in ((edge_x, one_x), (edge_y, one_y))
        ]
        self.unresolved = max(
            (2 * one / two) ** 2 if two > 0 else 0.0
            for one, two in ((one_x, two_x), (one_y, two_y))
        )

    def notes(self, meet: Sequence[bool]) -> list[str]:
        """One line for each doubt; meet: whether the opposite edges as they are will be neighbours,
        along x, along y."""
        found = [
            f"opposite edges along {axis} differ by {jump:.3g} times what neighbouring points"
            " differ by: the jump is pressed, too"
            for axis, jump, edges in zip("xy", self.jumps, meet)
            if jump > JUMP and edges
        ]
        if self.tilt > TILT:
            found.append(
                f"{100 * self.tilt:.0f} % of the variance of the heights is tilt (surface.detrend ="
                ' "tilt" removes it)'
            )
        if self.unresolved > UNRESOLVED:
            found.append(
                "the spectrum is not resolved: it has power at the shortest waves of the grid, so"
                " that more points would change g_rms and the area"
            )
        return found


def notes_on(found: Topography, spec: Any, comm: Any) -> list[str]:
    """Notes on how a Topography quality. Collective.

    Raises SceneError where nobody says what its boundary is and it does not look periodic.
    """
    quality = MapQuality(found, comm)
    if spec.mirror or spec.window != "none":  # periodic whatever its edges are
        return quality.notes((False, False))
    for axis, jump in zip("xy", quality.jumps):
        if jump > JUMP and spec.boundary is None and not found.periodic:
            raise SceneError(
                f"surface.boundary: found nothing, and edges along {axis} that differ by {jump:.3g}"
                ' times what neighbouring points differ by, allowed: "free" (it ends there),'
                ' "periodic" (pressed with that jump), or detrend = "tilt", mirror = true, a'
                " window"
            )
    return quality.notes([not ends for ends in spec.free])


def slope_notes(g_rms: float, measured: bool) -> list[str]:
    """Of any surface; measured: it is no formula, of which any slope may be asked."""
    if g_rms > ABSURD[1] or (measured and 0 < g_rms < ABSURD[0]):
        return [f"g_rms = {g_rms:.2g}: heights and sizes {DIFFERENT_UNITS}"]
    return [f"g_rms = {g_rms:.3g}: the theory is that of small slopes"] if g_rms > STEEP else []


def outliers(found: Topography, quality: MapQuality, comm: Any) -> int:
    """Count points of a Topography that stand out of the median of their neighbours. Collective."""
    n_x, n_y = found.n

    def count() -> list[int]:
        total = 0
        for start, stop in own_slabs(n_x, comm) if min(n_x, n_y) > 2 else ():
            first, last = max(start - 1, 0), min(stop + 1, n_x)
            z = np.pad(found.rows(first, last), 1, mode="reflect")
            beside = [
                z[1 + i : len(z) - 1 + i, 1 + j : n_y + 1 + j]
                for i in (-1, 0, 1)
                for j in (-1, 0, 1)
                if i or j
            ]
            out = np.abs(z[1:-1, 1:-1] - np.median(beside, axis=0)) > OUTLYING * quality.typical
            total += int(np.count_nonzero(out[start - first : stop - first]))
        return [total]

    return int(summed(comm, count)[0])


def load_notes(p_mean: float, E_star: float, g_rms: float, unit: str) -> list[str]:
    """Notes on a mean pressure p_mean beside the modulus E_star, on a surface of slope g_rms; unit:
    of a measured one."""
    found = [NO_MODULUS] if unit and E_star == 1 else []
    if p_mean > OVERLOADED * E_star * max(g_rms, 1.0):
        found.append(f"p = {p_mean / E_star:.2g} E*: loads and moduli {DIFFERENT_UNITS}")
    return found


def _looked_at(
    found: Topography, comm: Any, x: np.ndarray, y: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """This rank's sums, and numbers of each of SAMPLED rows: along x, and then along y, how much
    neighbours and every second point differ, and the slope; the jump from the row's end to its
    beginning."""
    total, rows, n_x = np.zeros(4), [], found.n[0]
    lags = [min(LAG, max(n // 8, 1)) for n in found.n]
    for start, stop in own_slabs(n_x, comm):
        z = found.rows(start, min(stop + max(2, lags[0]), n_x))
        mine = z[: stop - start]
        total += [
            mine.sum(),
            np.sum(mine**2),
            x[start:stop] @ mine.sum(axis=1),
            y @ mine.sum(axis=0),
        ]
        every = -(-n_x // SAMPLED)
        for i in range(-start % every, len(mine), every):
            ahead = (
                lambda k, i=i, z=z: z[i + k] - z[i] if i + k < len(z) else z[:0],
                lambda k, row=z[i]: row[k:] - row[:-k],
            )
            found_ = [
                number
                for of, lag in zip(ahead, lags)
                for number in (_typical(of(1)), _typical(of(2)), _median(of(lag)) / lag)
            ]
            rows.append([*found_, abs(z[i, 0] - z[i, -1]) or np.nan])
    return total, np.array(rows).reshape(-1, 7)


def _typical(differences: np.ndarray) -> float:
    """Their median without sign, of those that are not 0, as many of rounded heights are."""
    return _median(np.abs(differences[differences != 0]))


def _median(values: np.ndarray) -> float:
    return float(np.median(values)) if values.size else float("nan")
