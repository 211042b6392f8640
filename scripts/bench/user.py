"""What a user types, against the solver's share of it.

`solve` of a plain array, and `run` of a scene with the same heights in a text file and in a .npy
file. `over_core` is the time of the whole call over that within the solver's loads, in the same
call. `over_loadtxt` is what a text file takes beyond the .npy file, over one numpy.loadtxt of it.
"""

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


def run(args):
    """Report all calls at each size."""
    report = Report("user", args.out)
    watch = Stopwatch(time.process_time)
    watch.watch(Sweep, "solve", "core")
    with tempfile.TemporaryDirectory() as folder:
        for n in args.n:
            for row in _rows(n, args.p_star, args.repeats, Path(folder), watch):
                report.add(n=n, **row)
    report.finish()


def _rows(n, p_star, repeats, folder, watch):
    """Yield a row for each call on a wall of n x n points; the calls take turns."""
    contact = RoughContact(n, p_star)
    z = np.asarray(contact.surface.heights)
    sizes = {"physical_sizes": (1.0, 1.0)}
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
