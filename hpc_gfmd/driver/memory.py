"""How much memory a scene takes on each rank, and whether it is there."""

import os
from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from ..parallel.fft import row_starts
from .sweep import first_precision

FIELDS = 4  # h, g, p, d; in low memory h is not kept
LEVELS = 3 / 4 + 2 / 16 + 2 / 64 + 1 / 24  # coarse levels of the preconditioner, in fields
NESTED = 2 / 3 + (3 + LEVELS) / 4 + 1 / 4  # transforms and gaps of all coarser grids, a solver and a displacement on the next one
PIECE_GIB = 1 / 16  # of a field that is written at a time
PROCESS_GIB = 0.25  # interpreter, libraries, compiled kernels, MPI buffers
GIB = 2**30


@dataclass(frozen=True)
class Memory:
    """GiB on the rank with most rows: fields and levels, transforms of the solver, of the certificate, the process; and the sum."""

    fields: float
    transforms: float
    certificate: float
    process: float

    @property
    def total(self):
        """GiB per rank."""
        return self.fields + self.transforms + self.certificate + self.process


def memory_of(scene, n, ranks):
    """The Memory of a scene on a number of ranks."""
    itemsize = first_precision(scene.solver).itemsize
    points = int(np.diff(row_starts(n[0], ranks)).max()) * n[1] / GIB
    spectrum = points * (1 + 2 / n[1])
    low = scene.solver.low_memory
    fields = points * itemsize * (FIELDS - low + LEVELS)
    loads = len(scene.load.p_star or scene.load.pressure)
    extra = min(points * itemsize, PIECE_GIB) if scene.output.fields else 0.0
    if not low and scene.solver.nested is not False:
        extra = max(extra, points * itemsize * NESTED) if loads > 1 else extra + points * itemsize / 3
    fields += extra
    certificate = 0.0 if low or itemsize == 8 else spectrum * 8
    return Memory(fields, spectrum * itemsize, certificate, PROCESS_GIB)


def available_gib():
    """Memory of this machine that a new process can get, of its control group if that is less."""
    gib = float("inf")
    try:
        with open("/proc/meminfo") as file:
            gib = next(int(line.split()[1]) for line in file if line.startswith("MemAvailable")) / 2**20
    except (OSError, StopIteration, ValueError):
        gib = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / GIB
    for limit, used in (("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),):
        try:
            with open(limit) as a, open(used) as b:
                gib = min(gib, (int(a.read()) - int(b.read())) / GIB)
        except (OSError, ValueError):
            pass
    return gib


def require_memory(comm, scene, n, threads):
    """Raise SceneError on all ranks if the ranks of some machine need more memory than it has. Collective."""
    need = memory_of(scene, n, comm.size).total
    here = comm.allgather((os.uname().nodename, available_gib()))
    for node in {name for name, _ in here}:
        count = sum(name == node for name, _ in here)
        there = scene.machine.memory_gib or min(gib for name, gib in here if name == node)
        if need * count > there:
            raise SceneError(f"surface: {n[0]} x {n[1]} points need {need:.2f} GiB on each of {count} ranks, {node} has "
                             f"{there:.2f} GiB: use more machines, fewer points or single precision")
