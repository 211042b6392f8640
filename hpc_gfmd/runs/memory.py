"""Forecast of the memory of a scene on each rank, never too low and at most 25 % too high, and the
check that a machine has it.
"""

import platform
from math import prod

from ..driver.precision_forecast import first_of_scene, precisions
from ..parallel.comm import Comm
from ..parallel.guard import raise_on_all
from ..scene import Scene
from ..surface import Size, cell_of
from ..util.errors import SceneError
from ..util.machine import GIB, available_gib, limit_gib

ADVICE = "use more machines, fewer points or single precision"

# Bytes per point of the grid and rank, by (bytes of a number, low memory, axes with free edges): on
# one rank, for one load and for several (which keep the one before); on several ranks, likewise.
BYTES = {
    (4, False, 0): (34, 39, 37, 42),
    (4, False, 1): (25, 30, 33, 38),
    (4, False, 2): (32, 36, 41, 45),
    (4, True, 0): (21, 21, 17, 17),
    (4, True, 1): (28, 28, 28, 28),
    (4, True, 2): (29, 29, 30, 30),
    (8, False, 0): (51, 57, 50, 56),
    (8, False, 1): (53, 61, 58, 67),
    (8, False, 2): (53, 61, 58, 67),
    (8, True, 0): (38, 38, 32, 32),
    (8, True, 1): (51, 51, 51, 51),
    (8, True, 2): (51, 51, 51, 51),
}
FINE = 1e-3  # below this accuracy a low-memory run on several ranks may be certified in double:
CERTIFIED = 6  # bytes per point more
STIFFNESS = 5.0  # numbers per point for the tangent stiffness
STABILITY = 11.0  # numbers per point for the stability of a contact with attraction
ON_REQUEST = 2.0  # numbers per point for other observables and for distributions
FIELD_GIB = 1 / 8  # at most, for a piece of a field that is written
HISTORY = 1.0  # numbers per point for the original heights beside those that loads have changed
DENTS = 16.0  # bytes per point for dents that stay, those before a load and after it
RELAXING = 8.0  # for each field of a solid that relaxes: the displacement, and one an element
LAYER = 1.5  # numbers per point for the stiffness of a layer, a table
HALO = 12  # numbers per point along y: rows beside those of the rank on all levels
RANKED = 72  # bytes per point on rank 0 for heights with a given distribution
PROCESS_GIB = 0.217  # interpreter, libraries, compiled kernels, buffers of MPI
THREAD_GIB = 0.0035  # scratch of a thread


def memory_of(scene: Scene, size: Size, itemsize: int, ranks: int, threads: int = 1) -> float:
    """Return GiB of the largest rank."""
    cell = cell_of(size.n, scene.surface.free, size.lengths)
    points = -(-cell[0] // ranks) * cell[1]  # of the longest slab
    output = scene.output
    bytes_per_point = BYTES[itemsize, scene.solver.low_memory, sum(scene.surface.free)]
    column = 2 * (ranks > 1) + (len(scene.load.prescribed[1]) > 1)
    nbytes: float = bytes_per_point[column] * points
    is_fine = scene.solver.low_memory and (scene.solver.accuracy or 0) < FINE
    if itemsize == 4 and ranks > 1 and is_fine:
        nbytes += CERTIFIED * points
    if scene.material.thickness is not None:
        nbytes += LAYER * itemsize * points
    if scene.remembers:
        elements = scene.material.relaxation or ()
        relaxing = RELAXING * (1 + len(elements)) + DENTS if elements else 0.0
        nbytes += (HISTORY * itemsize + relaxing + DENTS * scene.load.history) * points
    passing = [0.0]  # one after the other
    if output.fields:
        passing.append(min(2 * itemsize * points, FIELD_GIB * GIB))
    if output.observables or output.distributions:
        passing.append(ON_REQUEST * itemsize * points)
    if "stiffness" in (output.observables or ()):
        passing.append(STIFFNESS * itemsize * points)
    if scene.material.adhesion is not None:
        passing.append(STABILITY * itemsize * points)
    nbytes += max(passing) + HALO * itemsize * cell[1]
    if size.preparing:  # on rank 0, which then hands the others their rows
        nbytes = max(nbytes, size.preparing, 8 * prod(size.n) * (1 + 1 / ranks))
    if getattr(scene.surface, "has_distribution", False):
        nbytes = max(nbytes, RANKED * cell[0] * cell[1])
    return nbytes / GIB + PROCESS_GIB + threads * THREAD_GIB


def require_memory(comm: Comm, scene: Scene, size: Size, threads: int) -> None:
    """Raise SceneError on all ranks if a machine has, or its limits (ulimit -v, machine.memory_gib)
    allow, less memory than its loads certainly need. Collective.
    """
    predicted = [dtype for dtype in precisions(scene, size.n) if dtype is not None]
    itemsize = max(dtype.itemsize for dtype in [first_of_scene(scene), *predicted])
    gib_per_rank = memory_of(scene, size, itemsize, comm.size, threads)
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
