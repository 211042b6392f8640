"""Check that a machine has the memory that a scene takes."""

import platform
from math import prod

from ..driver.precision import least_precision
from ..parallel.comm import Comm
from ..parallel.guard import raise_on_all
from ..scene import Scene
from ..surface import Size
from ..util.errors import SceneError
from ..util.machine import available_gib, limit_gib
from .memory import memory_of

ADVICE = "use more machines, fewer points or single precision"


def require_memory(comm: Comm, scene: Scene, size: Size, threads: int) -> None:
    """Raise SceneError on all ranks if a machine has, or its limits (ulimit -v, machine.memory_gib)
    allow, less memory than the lowest possible precision needs. Collective.
    """
    single = memory_of(scene, size, 4, comm.size, threads)
    double = memory_of(scene, size, 8, comm.size, threads)
    gib_per_rank = double if least_precision(scene, prod(size.n)).itemsize == 8 else single
    gib_of_limit = float(comm.min([limit_gib()])[0])
    n_x, n_y = size.n
    if gib_per_rank > gib_of_limit:
        raise SceneError(
            f"surface: {n_x} x {n_y} points need {gib_per_rank:.2f} GiB on each of {comm.size}"
            f" ranks, a process may have {max(gib_of_limit, 0.0):.2f} GiB more (ulimit -v): raise"
            " the limit, use more ranks, fewer points or single precision"
        )
    gib = comm.machine.size * gib_per_rank
    gib_available = scene.machine.memory_gib or float(comm.machine.min([available_gib()])[0])
    error = None
    if gib > gib_available:
        error = SceneError(
            f"surface: {n_x} x {n_y} points need {gib:.2f} GiB on {comm.machine.size} of"
            f" {comm.size} ranks, {platform.node()} has {gib_available:.2f} GiB: {ADVICE}"
        )
    raise_on_all(comm, error)
