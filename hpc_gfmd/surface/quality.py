"""What a reader should know of a height map before the numbers that come from it, and whether it is
periodic: as the scene or the file says, else by the jump between its opposite edges."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..util.errors import SceneError
from .slabs import own_slabs, summed
from .topography import Topography

STEEP = 1.0 + 1e-6  # g_rms beyond which slopes are not small; 1 itself has rounding errors
ABSURD = 1e-5, 30.0  # g_rms of real surfaces is between them
TILT = 0.5  # share of the variance of the heights
# mean square slope between neighbours over that between every second point: 1 where the grid
# resolves the spectrum
UNRESOLVED = 1.2
FILLED = 0.1  # share of the points
ROUNDING = 1e-12  # of the heights: edges that differ by less are the same
# rms jump between opposite edges over that between neighbouring points, up to which it is one of
# them
JUMP = 3.0


class MapQuality:
    """Sums over a Topography, read once. Collective.

    jumps: for each axis the rms jump from the last point to the first one over that between
    neighbours; tilt: share of the variance of the heights that is a plane's; unresolved: see
    UNRESOLVED, the larger one of both axes.
    """

    def __init__(self, found: Topography, comm: Any) -> None:
        n_x, n_y = found.n
        x, y = (np.arange(n) - (n - 1) / 2 for n in found.n)
        s = summed(comm, lambda: _sums(found, comm, x, y))
        (one_x, one_y), (two_x, two_y), (edge_x, edge_y), (z, zz, zx, zy) = (
            s[:2],
            s[2:4],
            s[4:6],
            s[6:],
        )
        N = n_x * n_y
        variance = zz - z * z / N
        plane = sum(
            part**2 / (N / n * (k @ k)) for part, k, n in ((zx, x, n_x), (zy, y, n_y)) if n > 1
        )
        self.tilt = float(plane / variance) if variance > 0 else 0.0
        edge_x, edge_y = (edge if edge > ROUNDING**2 * zz else 0.0 for edge in (edge_x, edge_y))
        self.jumps = [
            _ratio(edge_x / n_y, one_x / (max(n_x - 1, 1) * n_y)),
            _ratio(edge_y / n_x, one_y / (max(n_y - 1, 1) * n_x)),
        ]
        self.unresolved = max(
            _ratio(one_x / max(n_x - 1, 1), two_x / max(n_x - 2, 1) / 4) ** 2,
            _ratio(one_y / max(n_y - 1, 1), two_y / max(n_y - 2, 1) / 4) ** 2,
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
        return [f"g_rms = {g_rms:.2g}: heights and sizes are probably in different units"]
    return [f"g_rms = {g_rms:.3g}: the theory is that of small slopes"] if g_rms > STEEP else []


def _sums(found: Topography, comm: Any, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    total, n_x = np.zeros(10), found.n[0]
    for start, stop in own_slabs(n_x, comm):
        m = stop - start
        z = found.rows(start, min(stop + 2, n_x))
        mine = z[:m]
        first = found.rows(0, 1) if stop == n_x else mine[:0]
        total += [
            np.sum((z[1 : m + 1] - z[: len(z[1 : m + 1])]) ** 2),
            np.sum(np.diff(mine, axis=1) ** 2),
            np.sum((z[2 : m + 2] - z[: len(z[2 : m + 2])]) ** 2),
            np.sum((mine[:, 2:] - mine[:, :-2]) ** 2),
            np.sum((first - mine[-1:]) ** 2) if len(first) else 0.0,
            np.sum((mine[:, 0] - mine[:, -1]) ** 2),
            mine.sum(),
            np.sum(mine**2),
            x[start:stop] @ mine.sum(axis=1),
            y @ mine.sum(axis=0),
        ]
    return total


def _ratio(a: float, b: float) -> float:
    return float(np.sqrt(a / b)) if b > 0 else 0.0
