"""What a user types, against the solver's share of it.

Per size: `solve` of a plain array, with and without its boundary; a list of near loads; `run` of a
scene with the same heights in a text file and in a .npy file. `over_core` is the time of the whole
call over that within the solver's loads, in the same call. `over_loadtxt` is what a text file takes
beyond the .npy file, over one numpy.loadtxt of it.

Once: the import, the first solve with compiled kernels, and with none, as processes.
"""

import os
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
import tomli_w

import hpc_gfmd
from hpc_gfmd.driver.sweep import Sweep

from .contacts import RoughContact
from .report import Report
from .timing import Stopwatch, in_turn, ratio

NEAR_LOADS = 20
STEP = 1.05  # between near loads
FIRST_SOLVE = (
    "import hpc_gfmd, numpy; hpc_gfmd.solve(numpy.random.rand(64, 64), 1, boundary='periodic')"
)


def run(args):
    """Report all calls at each size, then the processes."""
    report = Report("user", args.out)
    watch = Stopwatch(time.process_time)
    watch.watch(Sweep, "solve", "core")
    with tempfile.TemporaryDirectory() as folder:
        for n in args.n:
            for row in _rows(n, args.p_star, args.repeats, Path(folder), watch):
                report.add(n=n, **row)
        for row in _processes(args.repeats, Path(folder)):
            report.add(n=0, **row)
    report.finish()


def _rows(n, p_star, repeats, folder, watch):
    """Yield a row for each call on a wall of n x n points; the calls take turns."""
    contact = RoughContact(n, p_star)
    z = np.asarray(contact.surface.heights)
    sizes = {"physical_sizes": (1.0, 1.0)}
    near = [p_star * STEP**k for k in range(NEAR_LOADS)]
    files = {"text": folder / f"{n}.txt", "npy": folder / f"{n}.npy"}
    np.savetxt(files["text"], z)
    np.save(files["npy"], z)

    def by_file(path):
        """Run a scene of a file, quietly."""
        surface = {"kind": "file", "path": str(path), "physical_sizes": [1.0, 1.0]}
        output = {"path": str(folder / "out.h5"), "fields": []}
        scene = {"surface": surface, "load": {"pressure": p_star}, "output": output}
        path.with_suffix(".toml").write_text(tomli_w.dumps(scene))
        hpc_gfmd.run(path.with_suffix(".toml"), quiet=True, force=True)

    calls = {
        "solve(z)": lambda: hpc_gfmd.solve(z, p_star, **sizes),
        "solve(z, boundary)": lambda: hpc_gfmd.solve(z, p_star, boundary="periodic", **sizes),
        "solve(z, 20 near loads)": lambda: hpc_gfmd.solve(z, near, fields=(), **sizes),
        "run of .npy": lambda: by_file(files["npy"]),
        "run of text": lambda: by_file(files["text"]),
        "numpy.loadtxt": lambda: np.loadtxt(files["text"]),
    }
    times = {name: [] for name in calls}
    cores = {name: [] for name in calls}
    for name in in_turn(calls, repeats + 1):
        watch.take()
        begin = time.process_time()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            calls[name]()
        times[name].append(time.process_time() - begin)
        cores[name].append(watch.take()["core"])
    for name in calls:  # without the first round, which plans and compiles
        seconds = times[name][1:]
        core = cores[name][1:]
        row = {"what": name, "cpu_min": min(seconds), "cpu_median": float(np.median(seconds))}
        if all(core):
            row["over_core"] = ratio(seconds, core)
        if name == "run of text":
            beyond = [a - b for a, b in zip(seconds, times["run of .npy"][1:])]
            row["over_loadtxt"] = ratio(beyond, times["numpy.loadtxt"][1:])
        yield row


def _processes(repeats, folder):
    """Yield a row for each process that starts anew."""
    cold = {"NUMBA_CACHE_DIR": str(folder / "kernels"), "HPC_GFMD_CACHE": str(folder / "cache")}
    jobs = {
        "import hpc_gfmd": ("import hpc_gfmd; hpc_gfmd.solve", {}, repeats),
        "first solve": (FIRST_SOLVE, {}, repeats),
        "first solve, nothing compiled": (FIRST_SOLVE, cold, 1),
    }
    for name, (code, environment, count) in jobs.items():
        seconds = []
        cpu_seconds = []
        for _ in range(count + (count > 1)):
            begin = time.perf_counter()
            cpu_begin = _cpu_seconds_of_children()
            subprocess.run(
                [sys.executable, "-W", "ignore", "-c", code],
                env=os.environ | {"OMP_NUM_THREADS": "1"} | environment,
                check=True,
                capture_output=True,
            )
            seconds.append(time.perf_counter() - begin)
            cpu_seconds.append(_cpu_seconds_of_children() - cpu_begin)
        counted = slice(count > 1, None)  # without the first one, unless it is the only one
        yield {
            "what": name,
            "cpu_min": min(cpu_seconds[counted]),
            "cpu_median": float(np.median(cpu_seconds[counted])),
            "seconds_min": min(seconds[counted]),
        }


def _cpu_seconds_of_children():
    """Return the processor time of all processes that have ended."""
    times = os.times()
    return times.children_user + times.children_system
