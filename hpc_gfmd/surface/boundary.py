"""Whether a height map is periodic: as the scene or the file says, else by the jump between its opposite edges."""

from dataclasses import replace

from ..errors import SceneError
from .doubts import JUMP, Looks


def decided(found, spec, comm):
    """The Topography with `periodic` True, and notes on how it looks. Collective.

    Raises SceneError where nobody says that it is periodic and it does not look so.
    """
    looks = Looks(found, comm)
    if spec.mirror or spec.window != "none":  # whatever the edges are
        return replace(found, periodic=True), looks.notes(edges=False)
    for axis, jump in zip("xy", looks.jumps):
        if jump > JUMP and spec.boundary is None and not found.periodic:
            raise SceneError(f"surface.boundary: found nothing, and edges along {axis} that differ by {jump:.3g} times what "
                             'neighbouring points differ by, allowed: "periodic" (pressed with that jump), or detrend = "tilt", '
                             'mirror = true, a window')
    return replace(found, periodic=True), looks.notes()
