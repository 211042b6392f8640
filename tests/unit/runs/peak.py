"""Run a scene (JSON, argument 1) into a file (argument 2) and print the largest memory of any rank
in GiB, and the precisions used.

Without pages of files, such as libraries: how many of them count as the process's own is the
system's affair (62 or 129 MB were seen for the same libraries), and they are given back when memory
is short. getrusage's ru_maxrss counts the process that started this one. What ranks have in common
is counted by each that has touched it: here by the one it belongs to alone.
"""

import json
import sys
import weakref

from hpc_gfmd.parallel import fft, shared
from hpc_gfmd.parallel.world import world
from hpc_gfmd.runs.simulation import run_scene
from hpc_gfmd.scene import Scene


class OfOthers:
    """Bytes that belong to other ranks and are mapped here at a time: a rank touches its columns of
    them."""

    now = most = 0

    def common_memory(self, node, nbytes):
        memory, offsets = shared.common_memory(node, nbytes)
        touched = (memory.nbytes - nbytes) // node.size
        self.now += touched
        self.most = max(self.most, self.now)
        weakref.finalize(memory, self._gone, touched)
        return memory, offsets

    def _gone(self, touched):
        self.now -= touched


if __name__ == "__main__":
    comm, others = world(), OfOthers()
    fft.common_memory = others.common_memory
    run = run_scene(
        Scene.from_dict(json.loads(sys.argv[1])), out=sys.argv[2], quiet=True, force=True, comm=comm
    )
    with open("/proc/self/status") as file:
        kib = {
            key: int(value.split()[0])
            for key, value in (line.split(":") for line in file)
            if key in ("VmHWM", "RssFile")
        }
    peak = float(comm.max([(kib["VmHWM"] - kib["RssFile"]) / 2**20 - others.most / 2**30])[0])
    if comm.rank == 0:
        print(json.dumps({"gib": peak, "precisions": [step["precision"] for step in run.steps]}))
