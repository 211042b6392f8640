"""Whether a height map is periodic: as the scene or the file says, else by the jump between its opposite edges."""

from dataclasses import replace

import numpy as np

from ..errors import SceneError
from .slabs import local, own_slabs, summed

JUMP = 3.0  # rms jump between opposite edges over that between neighbouring points, up to which it is one of them


def decided(found, spec, comm):
    """The Topography with `periodic` True. Collective. Raises SceneError where nobody says that it is and it does not look so."""
    if spec.boundary == "periodic" or spec.mirror or spec.window != "none" or found.periodic:
        return replace(found, periodic=True)
    for axis, jump in zip("xy", jumps(found, comm)):
        if jump > JUMP:
            raise SceneError(f"surface.boundary: found nothing, and edges along {axis} that differ by {jump:.3g} times what "
                             'neighbouring points differ by, allowed: "periodic" (pressed with that jump), or detrend = "tilt", '
                             'mirror = true, a window')
    return replace(found, periodic=True)


def jumps(found, comm):
    """For each axis the rms jump from the last point to the first one over the rms jump between neighbours."""
    n_x, n_y = found.n
    sums = summed(comm, lambda: _squares(found, comm))
    first, last = local(comm, lambda: (found.rows(0, 1), found.rows(n_x - 1, n_x)))
    along_x = np.sum((first - last) ** 2) / n_y, sums[0] / max((n_x - 1) * n_y, 1)
    along_y = sums[2] / n_x, sums[1] / max(n_x * (n_y - 1), 1)
    return [float(np.sqrt(jump / between)) if between > 0 else 0.0 for jump, between in (along_x, along_y)]


def _squares(found, comm):
    """Sums of squares over this rank's rows: steps to the next row, along the row, from its end to its beginning."""
    total = np.zeros(3)
    for start, stop in own_slabs(found.n[0], comm):
        z = found.rows(start, min(stop + 1, found.n[0]))
        mine = z[:stop - start]
        total += [np.sum(np.diff(z, axis=0) ** 2), np.sum(np.diff(mine, axis=1) ** 2), np.sum((mine[:, 0] - mine[:, -1]) ** 2)]
    return total
