"""Whether a height map is periodic: as the scene or the file says, else by the jump between its opposite edges."""

from typing import Any

from ..errors import SceneError
from .quality import JUMP, MapQuality
from .topography import Topography


def notes_on(found: Topography, spec: Any, comm: Any) -> list[str]:
    """Notes on how a Topography quality. Collective.

    Raises SceneError where nobody says what its boundary is and it does not look periodic.
    """
    quality = MapQuality(found, comm)
    if spec.mirror or spec.window != "none":  # periodic whatever its edges are
        return quality.notes((False, False))
    for axis, jump in zip("xy", quality.jumps):
        if jump > JUMP and spec.boundary is None and not found.periodic:
            raise SceneError(f"surface.boundary: found nothing, and edges along {axis} that differ by {jump:.3g} times what "
                             'neighbouring points differ by, allowed: "free" (it ends there), "periodic" (pressed with that jump), or '
                             'detrend = "tilt", mirror = true, a window')
    return quality.notes([not ends for ends in spec.free])
