"""Forecast of the memory of a scene on each rank: never too low, and at most 25 % too high."""

from math import prod
from pathlib import Path

from ..scene import File, Scene, each
from ..surface import Size, cell_of
from ..surface.prepare import asks_for_preparation
from ..util.machine import GIB

# Bytes per point of the grid and rank, by (bytes of a number, low memory, axes with free edges): on
# one rank, for one load and for several (which keep the one before); on several ranks, likewise.
BYTES = {
    (4, False, 0): (34, 39, 37, 42),
    (4, False, 1): (25, 30, 33, 38),
    (4, False, 2): (32, 37, 41, 45),
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
BY_ROWS = (".npy", ".h5", ".hdf5", ".nc")  # names of files of which every rank reads its rows
# Of a map on the process that reads or prepares it, however many points are missing; of two scans
# one is kept while the other one is read or filled.
COPIES = {"read": 2.1, "changed": 3.2, "filled": 3.0, "added": 4.0, "built": 2.1}
TEXTS = 2.0  # times the bytes of a file that is no array: while its header is taken off
HALO = 12  # numbers per point along y: rows beside those of the rank on all levels
RANKED = 72  # bytes per point on rank 0 for heights with a given distribution
PROCESS_GIB = 0.217  # interpreter, libraries, compiled kernels, buffers of MPI
THREAD_GIB = 0.0035  # scratch of a thread


def _is_read_whole(surface: File) -> bool:
    """Whether one process reads a whole map, as far as its name and the scene tell."""
    return asks_for_preparation(surface) or not _is_array(surface)


def _is_array(surface: File) -> bool:
    """Whether all maps lie in files as arrays, by their names; others are read as a whole."""
    paths = [body.path for body in surface.bodies or ()] or each(surface.path)
    return all(Path(str(path)).suffix in BY_ROWS for path in paths)


def _preparing(surface: File, size: Size) -> float:
    """Return how many numbers in double precision reading and preparing a map hold at once."""
    after = prod(size.n)
    step = surface.downsample / surface.refine
    mirrored = step**2 * after  # points before they are resampled; likewise the next
    kept = mirrored / 2 ** sum(surface.mirrored)
    steps = surface.detrend, surface.window, surface.spikes, surface.flip
    is_changed = steps != ("none", "none", "keep", False)
    copies = COPIES["filled"] if surface.fill != "none" else 1.0
    copies = COPIES["changed"] if is_changed else copies
    copies = COPIES["added"] if surface.bodies else copies
    resampling = mirrored + (step + 1) * after if step != 1 else 0.0
    mirroring = kept if any(surface.mirrored) else 0.0
    of_text = 0.0 if _is_array(surface) else TEXTS * size.file_bytes / 8
    return max(
        COPIES["read"] * size.read,
        size.read + of_text,
        size.read + (copies - 1) * kept,  # a part that is cropped keeps the whole map
        resampling + mirroring,
        COPIES["built"] * after,
    )


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
    if scene.surface.kind == "file" and _is_read_whole(scene.surface):  # on rank 0
        nbytes = max(nbytes, 8 * _preparing(scene.surface, size))
    if getattr(scene.surface, "has_distribution", False):
        nbytes = max(nbytes, RANKED * cell[0] * cell[1])
    return nbytes / GIB + PROCESS_GIB + threads * THREAD_GIB
