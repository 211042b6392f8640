"""Run a scene (JSON, argument 1) into a file (argument 2) and print the largest memory of any rank in GiB, and the precisions used.

Without pages of files, such as libraries: how many of them count as the process's own is the system's affair (62 or 129 MB were seen
for the same libraries), and they are given back when memory is short.
"""

import json
import resource
import sys

from hpc_gfmd.parallel.comm import world
from hpc_gfmd.scene import Scene
from hpc_gfmd.simulation import run_scene

if __name__ == "__main__":
    comm = world()
    run = run_scene(Scene.from_dict(json.loads(sys.argv[1])), out=sys.argv[2], quiet=True, comm=comm)
    with open("/proc/self/status") as file:
        pages_of_files = next(int(line.split()[1]) for line in file if line.startswith("RssFile"))
    peak = float(comm.max([(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - pages_of_files) / 2**20])[0])
    if comm.rank == 0:
        print(json.dumps({"gib": peak, "precisions": [step["precision"] for step in run.steps]}))
