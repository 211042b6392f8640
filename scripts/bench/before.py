"""What users start, by this tree and by an older one, in turn.

`python` is the older one's, by default this one's own. Small walls, near loads on one, a text file,
light contacts. `over_before` is the median of the processor time over that of the older one. All
solve the same heights at the same pressure, as `solve` finds it here for a contact area.
"""

import shutil
import sys
import tempfile
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np

import hpc_gfmd

from .contacts import RoughContact
from .light import free_heights
from .report import Report
from .timing import Process, in_turn, ratio
from .user import NEAR_LOADS, STEP

WORKER = Path(__file__).with_name("call_worker.py")


def run(args):
    """Report all calls."""
    pythons = {"before": args.python or sys.executable, "after": sys.executable}
    if shutil.which(pythons["before"]) is None:
        raise hpc_gfmd.SceneError(f"--python: found {args.python!r}, allowed: the path of a Python")
    report = Report("before", args.out)
    with tempfile.TemporaryDirectory() as folder:
        for n in args.n:
            wall = np.asarray(RoughContact(n, 0.0).surface.heights)
            path = Path(folder) / f"wall-{n}.npy"
            np.save(path, wall)
            near = [args.p_star * STEP**k for k in range(NEAR_LOADS)]
            calls = {"solve(z)": {"pressure": args.p_star}}
            calls["solve(z, 20 near loads)"] = {"pressure": near, "fields": ()}
            for what, call in calls.items():
                report.add(what=what, n=n, **_row(pythons, args.repeats, path, **call))
            path = path.with_suffix(".txt")
            np.savetxt(path, wall)
            call = {"pressure": args.p_star}
            report.add(what="run of text", n=n, **_row(pythons, args.repeats, path, **call))
        for n in args.n_light:
            for what, heights, a_r, boundary in _light(n):
                path = Path(folder) / "light.npy"
                np.save(path, heights)
                how = {"boundary": boundary}
                load = hpc_gfmd.solve(heights, a_r=a_r, fields=(), **how).p
                row = _row(pythons, args.repeats, path, pressure=load, **how)
                report.add(what=what, n=n, a_r=a_r, **row)
    report.finish()


def _light(n):
    """Yield light contacts of n x n points: name, heights, contact area, boundary."""
    for roughness in (0.02, 0.1):
        yield f"ball, roughness {roughness}", free_heights(n, roughness), 0.005, "free"
    yield "rough piece", free_heights(n, np.inf), 0.0005, "free"
    for hurst in (0.3, 0.8):
        wall = np.asarray(RoughContact(n, 0.0, hurst).surface.heights)
        yield f"wall, H = {hurst}", wall, 0.0005, "periodic"


def _row(pythons, repeats, path, **call):
    """Return times of a call by both installations; the first round warms up."""
    times = {name: [] for name in pythons}
    with ExitStack() as stack:
        workers = {}
        commits = {}
        for name, python in pythons.items():
            process = Process(name, [python, WORKER])
            workers[name] = stack.enter_context(closing(process))
            commits[name] = workers[name].ask(path=str(path), call=call)["commit"]
        for name in in_turn(pythons, repeats + 1):
            times[name].append(workers[name].ask()["cpu_seconds"])
    row = {"commit_before": commits["before"]}
    for name, seconds in times.items():
        seconds = times[name] = seconds[1:]
        row |= {f"{name}_min": min(seconds), f"{name}_median": float(np.median(seconds))}
    return row | {"over_before": ratio(times["after"], times["before"]), "repeats": repeats}
