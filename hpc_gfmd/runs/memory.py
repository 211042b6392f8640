"""How much memory a scene takes on each rank, and whether it is there."""

import math
import platform
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike

from ..bodies import body_of
from ..bodies.halfspace import HALF_SPACE
from ..driver.precision import (
    CALIBRATION,
    counting,
    few_points,
    first_precision,
    known_heights,
    known_p_stars,
    precisions,
)
from ..operators.problem import TRANSFORMED
from ..parallel.comm import Comm
from ..parallel.grid import SMALL, Grid
from ..parallel.guard import raise_on_all
from ..scene import Scene
from ..scene.surface import AnySurface
from ..surface import cell_of
from ..util.errors import SceneError
from ..util.machine import GIB, available_gib, limit_gib
from .decomposition import share_of


@dataclass(frozen=True)
class Needs:
    """What a rank takes, as measured on resident memory.

    Attributes
    ----------
    fields, step : float
        Fields as long as the slab: g and p; d, which has half the width.
    solver : float
        And a copy of the gap: what a coarse solution takes while it becomes that of the next grid.
    tangent : float
        What the stiffness takes.
    stability : float
        What the search for the stability takes, with an attraction.
    piece_gib, modes_gib : float
        Of a field that is written at a time; of the modes that free edges couple, on all grids.
    process_gib : float
        Interpreter, libraries, compiled kernels, MPI buffers.
    threads_gib, thread_gib : float
        What threads keep for themselves, however many; each of them.
    longest_axis : int
        Points: for more, which no machine holds, not even the tables of an axis are worth making.
    """

    fields: float = 2.0
    step: float = 0.5
    solver: float = 4.0
    tangent: float = 4.0
    stability: float = 11.0
    piece_gib: float = 1 / 16
    modes_gib: float = 0.04
    process_gib: float = 0.21
    threads_gib: float = 0.01
    thread_gib: float = 0.0015
    longest_axis: int = 2**26


NEEDS = Needs()


@dataclass(frozen=True)
class Memory:
    """GiB on one rank: fields and levels, the process, heights, transforms of the solver (with all
    threads' scratch), of the certificate; and the sum. all_heights: those of all ranks, which
    with free edges are not spread evenly."""

    fields: float
    process: float
    heights: float = 0.0
    transforms: float = 0.0
    certificate: float = 0.0
    all_heights: float = 0.0

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
    """Work out the Memory of a scene, whose surface has n points and these sizes, on one of a
    number of ranks with so many threads each, so many on each node; rank 0 has a part in
    everything. unknown: precision of the loads of which it is not known beforehand, without it the
    first one."""
    usual = first_precision(scene.solver)
    each = [np.dtype(dtype) for dtype in precisions(scene, n, unknown or usual)]
    dtype = max(each, key=lambda dtype: dtype.itemsize)
    itemsize, free = dtype.itemsize, scene.surface.free
    cell = cell_of(n, free, sizes)
    if max(cell) > NEEDS.longest_axis:
        points = np.prod(cell, dtype=float) / ranks
        return Memory(NEEDS.fields * points * itemsize / GIB, NEEDS.process_gib)
    low, nested = scene.solver.low_memory, scene.solver.nested is not False
    share = share_of(cell, dtype, ranks, rank, nominal=n, nested=nested, per_node=per_node)
    field = share.points * itemsize / GIB
    kept = itemsize if any(free) or not low else 0  # of a height
    loads = each.count(dtype)  # in the largest precision: before it nothing is kept

    levels, coarse = share.level_bytes / GIB, share.nested_points * itemsize / GIB
    # of the next grid, over this one
    first = np.prod(share.grids[0].shape) / share.points if share.grids else 0.0
    passing = [0.0]
    if scene.output.fields:
        passing.append(2 * min(field, NEEDS.piece_gib))  # as it is, and as it is written
    if not low and loads > 1:
        passing.append(coarse + first * (NEEDS.solver * field + levels))
    if "stiffness" in (scene.output.observables or ()):
        passing.append(field * NEEDS.tangent + levels)
    if scene.material.adhesion is not None:
        passing.append(field * NEEDS.stability)

    def spectra(precision: DTypeLike, grids: Iterable[Grid]) -> float:
        return sum(share.layout_of(grid, precision).bytes for grid in grids) / GIB

    def scratch(precision: DTypeLike, grids: Iterable[Grid]) -> float:
        return threads * sum(share.layout_of(grid, precision).scratch_bytes for grid in grids) / GIB

    kept_grids = [g for g in share.grids if not low or share.layout_of(g, dtype).bytes <= SMALL]
    grids = [share.grid, *kept_grids]
    with_table = 1 + body_of(scene.material, free).table_share
    transforms = spectra(dtype, grids[:1]) * with_table + spectra(dtype, grids[1:])
    transforms += sum(scratch(precision, grids) for precision in {dtype, usual})
    certificate = 0.0
    # heights that do not end are made in its transforms; ranks touch them as they plan
    touched = not any(free) or ranks > 1
    if not low and itemsize == 4 and (touched or _in_double(scene, n, cell)):
        certificate = spectra(np.float64, grids[:1]) * with_table + scratch(np.float64, grids[:1])
    elif itemsize == 4 and with_table == 1 and _in_double(scene, n, cell):
        # in turn with the solver's transforms, half as large, and d
        certificate = NEEDS.step * field
    flat = field if any(free) and _closes(scene) else 0.0
    levels += NEEDS.modes_gib * all(free)
    of_threads = (NEEDS.threads_gib + NEEDS.thread_gib * threads) * (threads > 1)
    fields = (NEEDS.fields + NEEDS.step) * field + levels + flat
    heights = share.grid.inside[0] * n[1] * kept / GIB
    passing.append(
        _resampling(scene.surface, n, ranks) - (fields + heights + transforms + certificate)
    )
    return Memory(
        fields + max(passing),
        NEEDS.process_gib + of_threads,
        heights,
        transforms,
        certificate,
        n[0] * n[1] * kept / GIB,
    )


def _resampling(surface: AnySurface, n: tuple[int, int], ranks: int) -> float:
    """Return the GiB that a height map of n points takes while it is resampled, before there are
    fields: along y, then along x, and what is sent of these two."""
    if surface.kind != "file":
        return 0.0
    one, sent = surface.downsample / surface.refine, 1 - 1 / ranks
    return 8 * n[0] * n[1] / ranks / GIB * max(one * (1 + sent), one + 1 + sent)


def _closes(scene: Scene) -> bool:
    """Tell whether a load is to be full contact, for which a flat surface that ends is solved for
    and kept."""
    name, values = scene.load.given
    return any(value == (name == "a_r") for value in values)


def _in_double(scene: Scene, n: tuple[int, int], cell: tuple[int, int]) -> bool:
    """Tell whether a solution in single precision may be certified in double, see start.py and
    lowmemory.py."""
    g_rms, h_rms = known_heights(scene, n)
    known = [p_star for p_star in known_p_stars(scene, g_rms) if p_star is not None]
    p_star = min(known, default=0.0)
    varies = p_star * math.prod(n) / math.sqrt(math.prod(cell)) if n != cell else h_rms
    if varies is None or not known:
        return True
    noise = TRANSFORMED * float(np.finfo(np.float32).eps) * varies
    if noise > CALIBRATION.noise * counting(scene.solver, p_star):
        return True
    few = few_points(math.prod(n), p_star, scene.solver.accuracy)
    full = scene.load.found or max(known) >= HALF_SPACE.full_p_star
    return (few or full) and not scene.solver.low_memory


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
    raise_on_all(comm, error)
