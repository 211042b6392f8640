"""The memory of a plan, against what runs really take."""

import json
import os
from pathlib import Path

import mpi_harness
import pytest
from contacts import rough

from hpc_gfmd.runs.memory import memory_of
from hpc_gfmd.scene import Scene

PEAK = Path(__file__).with_name("peak.py")
WITHIN = 0.1  # of the estimate
LIBRARIES_GIB = 0.1  # of files in the estimate, which peak.py leaves out


def scene(n, p_star=(0.1,), threads=1, fields=(), observables=None, boundary="periodic", **solver):
    output = {"fields": list(fields)} | ({"observables": observables} if observables else {})
    return {
        "surface": rough((2, n // 4, 2)) | {"boundary": boundary},
        "load": {"p_star": list(p_star)},
        "solver": solver,
        "machine": {"threads": threads},
        "output": output,
    }


def measured(table, ranks, folder):
    """GiB on the rank that takes most, and the precisions of the loads."""
    found = mpi_harness.found(
        ranks if ranks > 1 else None, [PEAK, json.dumps(table), folder / f"{ranks}.h5"], timeout=600
    )
    return found["gib"], found["precisions"]


def planned(table, ranks, threads=1):
    """GiB, by the plan."""
    asked = Scene.from_dict(table)
    return memory_of(asked, asked.surface.n, (1.0, 1.0), ranks, threads).total


def less_than_planned(table, ranks, folder):
    """GiB that interpreter and compiled kernels take less here than any plan has for them, by the
    same loads on hardly any points, periodic. Compiling takes memory of its own, once per
    installation."""
    for boundary in (table["surface"]["boundary"], "periodic", "periodic"):
        tiny = table | {"surface": scene(64, boundary=boundary)["surface"]}
        tiny |= {"machine": {"threads": 1}}
        found, _ = measured(tiny, ranks, folder)
    less = planned(tiny, ranks) - found
    assert less > 0
    return less


def check(table, ranks, folder, precision):
    """Not more than planned; nor less than what as many threads need as run at once."""
    if ranks > 1 and mpi_harness.missing():
        pytest.skip(f"{mpi_harness.missing()} is missing")
    threads = table["machine"]["threads"]
    at_once = min(threads, max(1, len(os.sched_getaffinity(0)) // ranks))
    most = planned(table, ranks, threads) - LIBRARIES_GIB
    least = planned(table, ranks, at_once) - less_than_planned(table, ranks, folder)
    found, precisions = measured(table, ranks, folder)
    assert precisions[-1] == precision
    assert (1 - WITHIN) * least < found < (1 + WITHIN) * most


FREE = {"boundary": "free", "low_memory": True, "precision": "single"}
# where single precision cannot tell so few points apart, all is in double; making the table of the
# stiffness takes no more than what is solved with it
WAYS = {
    "quick, few points": (scene(1024, [1e-4]), "float64"),
    "quick, free edges": (scene(1024, accuracy=1e-2, **FREE), "float32"),
    "small": (scene(1024), "float32"),
    "few points": (scene(2048, [1e-4]), "float64"),
    "small, few points, threads": (scene(1024, [1e-4], 4), "float64"),
    "4 threads": (scene(2048, threads=4), "float32"),
    "16 threads": (scene(2048, threads=16), "float32"),
    "two loads": (scene(2048, [0.1, 0.3]), "float32"),
    "two loads, double": (scene(2048, [0.1, 0.3], precision="double"), "float64"),
    "few points later": (scene(2048, [0.1, 1e-4], 4), "float64"),
    "low memory": (scene(2048, low_memory=True), "float32"),
    "field": (scene(2048, fields=["gap"]), "float32"),
    "stiffness": (scene(2048, observables=["stiffness"]), "float32"),
    "large, double": (scene(4096, precision="double"), "float64"),
    "large, low memory": (scene(4096, [0.1, 0.3], low_memory=True), "float32"),
    "large, low memory, certified in double": (
        scene(4096, [0.002], low_memory=True, precision="single", accuracy=4e-4),
        "float32",
    ),
    "free edges, low memory": (scene(2048, **FREE), "float32"),
    "free edges": (scene(2048, boundary="free"), "float32"),
}


@pytest.mark.parametrize(
    ("name", "ranks"),
    [
        pytest.param(
            name, ranks, marks=() if name[:5] == "quick" and ranks == 1 else pytest.mark.slow
        )
        for name in WAYS
        for ranks in (1, 2)
    ],
)
def test_memory(name, ranks, tmp_path):
    table, precision = WAYS[name]
    check(table, ranks, tmp_path, precision)
