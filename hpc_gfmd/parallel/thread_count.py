"""How many threads each rank gets, and whether the machine has cores for them."""

import os

from ..util.errors import SceneError
from ..util.machine import cores
from .comm import Comm
from .launcher import environment_number, idle_tasks, tasks_per_node

THREADS_PER_CORE = 8  # more are a mistake
THREADED_POINTS = 2**20  # of a surface; two threads take as long as one for a quarter of them


def threads_of(comm: Comm, wanted: int | str, points: int) -> int:
    """Return the threads of each rank; "auto": Slurm's --cpus-per-task up to the cores of this
    process, else `auto_threads`. Collective; SceneError above THREADS_PER_CORE a core.
    """
    if wanted != "auto":
        wanted = int(wanted)
        limit = int(comm.min([THREADS_PER_CORE * (os.cpu_count() or 1)])[0])
        if wanted > limit:
            raise SceneError(
                f"machine.threads: found {wanted}, allowed on this machine: up to {limit}"
                f" ({THREADS_PER_CORE} per core)"
            )
        return wanted
    usable = len(cores())
    by_slurm = int(comm.min([environment_number("SLURM_CPUS_PER_TASK") or 0])[0])
    return min(by_slurm, usable) or auto_threads(points, comm.size, usable)


def auto_threads(points: int, ranks: int, cores: int) -> int:
    """Return all cores for a single process with at least THREADED_POINTS points, else 1."""
    return cores if ranks == 1 and points >= THREADED_POINTS else 1


def ranks_per_node(ranks: int, threads: int) -> int:
    """Guess how many ranks share a node: Slurm's tasks, or as many as there are cores for."""
    return min(ranks, tasks_per_node() or max(1, len(cores()) // threads))


def oversubscription(comm: Comm, threads: int) -> str:
    """Return a note if cores run several threads each, or a job's tasks none. Collective."""
    if comm.size == 1 and (note := idle_tasks()):
        return note
    usable = cores()
    machine = comm.machine
    shared = {core for of_rank in machine.allgather(usable) for core in of_rank}
    beyond = [threads - len(usable), threads * machine.size - len(shared)]
    of_one_rank, of_a_machine = comm.max(beyond)
    if of_one_rank > 0:
        fewest = int(comm.min([len(usable)])[0])
        text = f"{threads} threads on {fewest} core{'s' * (fewest > 1)}"
        if comm.size == 1:
            return f"{text}: they take turns; machine.threads = {fewest} is as fast"
        return (
            f"{text} that a rank may use: they take turns (mpirun --map-by slot:PE={threads},"
            f" srun --cpus-per-task={threads}, or machine.threads = {fewest})"
        )
    if of_a_machine > 0:
        ranks, count = (int(number) for number in comm.max([machine.size, -len(shared)]))
        return (
            f"{ranks} ranks of {threads} thread{'s' * (threads > 1)} share {-count} cores of a"
            " machine: they take turns"
        )
    return ""
