"""How much memory a scene takes on each rank, and whether it is there."""

import math
import platform
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike

from ..bodies import body_of
from ..driver.precision import (
    NOISE_IN_TURN,
    counting,
    first_precision,
    known_heights,
    known_p_stars,
    precisions,
)
from ..operators.problem import TRANSFORMED
from ..parallel.comm import Comm
from ..parallel.grid import Grid
from ..parallel.guard import agree
from ..scene import Scene
from ..surface import cell_of
from ..util.errors import SceneError
from ..util.machine import GIB, available_gib, limit_gib
from .decomposition import share_of

# g, p; d, which has half the width; and h, which in low memory is kept only where the surface
# ends
FIELDS, STEP = 2, 0.5
SOLVER = (
    4  # and a copy of the gap: what a coarse solution takes while it becomes that of the next grid
)
TANGENT = 4
PIECE_GIB = 1 / 16  # of a field that is written at a time
MODES_GIB = 0.025  # while the modes are made that free edges couple
PROCESS_GIB = 0.2  # interpreter, libraries, compiled kernels, MPI buffers
# what threads keep for themselves, however many; each of them
THREADS_GIB, THREAD_GIB = 0.01, 0.0015

# points: for more, which no machine holds, not even the tables of an axis are worth making
LONGEST_AXIS = 2**26


@dataclass(frozen=True)
class Memory:
    """GiB on one rank: fields and levels, heights, transforms of the solver (with all threads'
    scratch), of the certificate, the process; and the sum. all_heights: those of all ranks, which
    with free edges are not spread evenly."""

    fields: float
    heights: float
    transforms: float
    certificate: float
    process: float
    all_heights: float

    @property
    def total(self) -> float:
        """GiB on this rank."""
        return self.fields + self.heights + self.transforms + self.certificate + self.process

    def on_all(self, ranks: int) -> float:
        """GiB on so many ranks together, if the others need as much but for the heights."""
        return ranks * (self.total - self.heights) + self.all_heights


def memory_of(
    scene: Scene,
    n: tuple[int, int],
    sizes: tuple[float, ...],
    ranks: int,
    threads: int = 1,
    rank: int = 0,
    per_node: int = 1,
    unknown: DTypeLike | None = None,
) -> Memory:
    """The Memory of a scene, whose surface has n points and these sizes, on one of a number of
    ranks with so many threads each, so many on each node; rank 0 has a part in everything.
    unknown: precision of the loads of which it is not known beforehand, without it the first one.
    """
    other = np.dtype(unknown or first_precision(scene.solver))
    each = [dtype or other for dtype in precisions(scene, n)]
    dtype = max(each, key=lambda dtype: dtype.itemsize)
    itemsize, free = dtype.itemsize, scene.surface.free
    cell = cell_of(n, free, sizes)
    if max(cell) > LONGEST_AXIS:
        return Memory(
            FIELDS * np.prod(cell, dtype=float) * itemsize / ranks / GIB,
            0.0,
            0.0,
            0.0,
            PROCESS_GIB,
            0.0,
        )
    low, nested = scene.solver.low_memory, scene.solver.nested is not False
    share = share_of(cell, dtype, ranks, rank, nominal=n, nested=nested, per_node=per_node)
    field, step = share.points * itemsize / GIB, STEP * share.points * itemsize / GIB
    kept = itemsize if any(free) or not low else 0  # of a height
    loads = each.count(dtype)  # in the largest precision: before it nothing is kept

    levels, coarse = share.level_bytes / GIB, share.nested_points * itemsize / GIB
    # of the next grid, over this one
    first = np.prod(share.grids[0].shape) / share.points if share.grids else 0.0
    passing = [
        2 * min(field, PIECE_GIB) if scene.output.fields else 0.0,  # as it is, and as it is written
        coarse + first * (SOLVER * field + levels) if not low and loads > 1 else 0.0,
        field * TANGENT + levels if "stiffness" in (scene.output.observables or ()) else 0.0,
    ]

    def spectra(precision: DTypeLike, grids: Iterable[Grid]) -> float:
        return sum(share.layout_of(grid, precision).bytes for grid in grids) / GIB

    def scratch(precision: DTypeLike, grids: Iterable[Grid]) -> float:
        return threads * sum(share.layout_of(grid, precision).scratch_bytes for grid in grids) / GIB

    grids = [share.grid, *([] if low else share.grids)]
    with_table = 1 + body_of(scene.material, free).table_share
    transforms = spectra(dtype, grids[:1]) * with_table + spectra(dtype, grids[1:])
    transforms += sum(
        scratch(precision, grids) for precision in {dtype, first_precision(scene.solver)}
    )
    certificate = (
        0.0
        if low or itemsize == 8
        else spectra(np.float64, grids[:1]) * with_table + scratch(np.float64, grids[:1])
    )
    if low and itemsize == 4 and with_table == 1 and _in_double(scene, n, cell):
        # in turn with the solver's transforms, half as large, and d
        certificate = step
    flat = field if any(free) and _closes(scene) else 0.0
    heights, all_heights = (rows * n[1] * kept / GIB for rows in (share.grid.inside[0], n[0]))
    levels += MODES_GIB if all(free) else 0.0
    process = PROCESS_GIB + (THREADS_GIB + THREAD_GIB * threads) * (threads > 1)
    return Memory(
        FIELDS * field + step + levels + flat + max(passing),
        heights,
        transforms,
        certificate,
        process,
        all_heights,
    )


def _closes(scene: Scene) -> bool:
    """Whether a load is to be full contact, for which a flat surface that ends is solved for and
    kept."""
    name, values = scene.load.given
    return any(value == (name == "a_r") for value in values)


def _in_double(scene: Scene, n: tuple[int, int], cell: tuple[int, int]) -> bool:
    """Whether a surface in low memory may be certified in double precision, see lowmemory.py."""
    g_rms, h_rms = known_heights(scene, n)
    known = [p_star for p_star in known_p_stars(scene, g_rms) if p_star is not None]
    p_star = min(known, default=0.0)
    varies = p_star * math.prod(n) / math.sqrt(math.prod(cell)) if n != cell else h_rms
    if varies is None:
        return True
    noise = TRANSFORMED * float(np.finfo(np.float32).eps) * varies
    return noise > NOISE_IN_TURN * counting(scene.solver, p_star)


def require_memory(
    comm: Comm, scene: Scene, n: tuple[int, int], sizes: tuple[float, ...], threads: int
) -> None:
    """Raise SceneError on all ranks if the ranks of some machine need more memory than it has.
    Collective."""
    need = memory_of(scene, n, sizes, comm.size, threads, comm.rank, comm.node.size).total
    most, own = float(comm.max([need])[0]), float(comm.min([limit_gib()])[0])
    if most > own:
        raise SceneError(
            f"surface: {n[0]} x {n[1]} points need {most:.2f} GiB on each of {comm.size} ranks, a"
            f" process may have {max(own, 0.0):.2f} GiB more (ulimit -v): raise the limit, use more"
            " ranks, fewer points or single precision"
        )
    together, error = float(comm.machine.sum([need])[0]), None
    there = scene.machine.memory_gib or float(comm.machine.min([available_gib()])[0])
    if together > there:
        error = SceneError(
            f"surface: {n[0]} x {n[1]} points need {together:.2f} GiB on {comm.machine.size} of"
            f" {comm.size} ranks, {platform.node()} has {there:.2f} GiB: use more machines,"
            " fewer points or single precision"
        )
    agree(comm, error)
