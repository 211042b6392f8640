"""Run a scene (JSON, argument 1) into a file (argument 2) and print the largest memory of any rank
in GiB, and the precisions used.

Pages of files, such as libraries, are left out: their share of the process varies (62 or 129 MB for
the same libraries), and the system reclaims them if memory is short. ru_maxrss of getrusage would
include the parent process. Memory shared by ranks is counted for its owner only.
"""

import json
import sys
import weakref

from hpc_gfmd.parallel import fft, shared
from hpc_gfmd.parallel.world import world
from hpc_gfmd.runs.simulation import run_scene
from hpc_gfmd.scene import Scene


class SharedMemory:
    """Bytes of other ranks that this rank has mapped and touched: currently, and at most."""

    current = largest = 0

    def common_memory(self, node, nbytes):
        memory, offsets = shared.common_memory(node, nbytes)
        touched = (memory.nbytes - nbytes) // node.size
        self.current += touched
        self.largest = max(self.largest, self.current)
        weakref.finalize(memory, self._release, touched)
        return memory, offsets

    def _release(self, touched):
        self.current -= touched


if __name__ == "__main__":
    comm = world()
    of_other_ranks = SharedMemory()
    fft.common_memory = of_other_ranks.common_memory
    run = run_scene(
        Scene.from_dict(json.loads(sys.argv[1])), out=sys.argv[2], quiet=True, force=True, comm=comm
    )
    with open("/proc/self/status") as file:
        kib = {
            key: int(value.split()[0])
            for key, value in (line.split(":") for line in file)
            if key in ("VmHWM", "RssFile")
        }
    gib = (kib["VmHWM"] - kib["RssFile"]) / 2**20 - of_other_ranks.largest / 2**30
    peak = float(comm.max([gib])[0])
    if comm.rank == 0:
        print(json.dumps({"gib": peak, "precisions": [step["precision"] for step in run.steps]}))
