"""The forecast of memory against measurements."""

import json
import os
from pathlib import Path

import mpi_harness
import numpy as np
import pytest
from contacts import rough, rough_wall

from hpc_gfmd.runs.memory import memory_of
from hpc_gfmd.scene import Scene
from hpc_gfmd.surface import surface_size

PEAK = Path(__file__).with_name("peak.py")
ABOVE = 0.25  # largest relative excess of the forecast
LIBRARIES_GIB = 0.1  # pages of files in the forecast, which peak.py leaves out


def scene(n, p_star=(0.1,), threads=1, fields=(), observables=None, boundary="periodic", **solver):
    """Tables of a scene with n x n points; solver: keys of [solver]."""
    output = {"fields": list(fields)} | ({"observables": observables} if observables else {})
    return {
        "surface": rough((2, n // 4, 2)) | {"boundary": boundary},
        "load": {"p_star": list(p_star)},
        "solver": solver,
        "machine": {"threads": threads},
        "output": output,
    }


def measured(table, ranks, folder):
    """(GiB on the largest rank, precisions of the loads)."""
    output = mpi_harness.json_of(
        ranks if ranks > 1 else None, [PEAK, json.dumps(table), folder / f"{ranks}.h5"], timeout=600
    )
    return output["gib"], output["precisions"]


def forecast(table, ranks, precision, threads):
    """Forecast GiB on the largest rank, without pages of files."""
    scene = Scene.from_dict(table)
    itemsize = np.dtype(precision).itemsize
    return memory_of(scene, surface_size(scene.surface), itemsize, ranks, threads) - LIBRARIES_GIB


def check(table, ranks, folder, precision):
    """The forecast is at least the measured memory, and at most 25 % above it with the threads that
    run at once."""
    if ranks > 1 and mpi_harness.missing():
        pytest.skip(f"{mpi_harness.missing()} is missing")
    small = table | {"surface": rough((2, 32, 2)) | {"boundary": table["surface"]["boundary"]}}
    measured(small, ranks, folder)  # compiles kernels, which takes memory, too
    threads = table["machine"]["threads"]
    at_once = min(threads, max(1, len(os.sched_getaffinity(0)) // ranks))
    gib, precisions = measured(table, ranks, folder)
    assert precisions[-1] == precision
    assert gib < forecast(table, ranks, precision, threads)
    assert forecast(table, ranks, precision, at_once) < (1 + ABOVE) * gib


FREE = {"boundary": "free", "low_memory": True, "precision": "single"}
# few points in contact need double precision
CASES = {
    "quick, few points": (scene(1024, [1e-4]), "float64"),
    # iterations take no further memory
    "quick, free edges": (scene(1024, accuracy=1e-2, max_iterations=6, **FREE), "float32"),
    "small, few points, threads": (scene(1024, [1e-4], 4), "float64"),
    "4 threads": (scene(2048, threads=4), "float32"),
    "two loads": (scene(2048, [0.1, 0.3]), "float32"),
    "few points later": (scene(2048, [0.1, 1e-4], 4), "float64"),
    "low memory": (scene(2048, low_memory=True), "float32"),
    "large, low memory": (scene(4096, [0.1, 0.3], low_memory=True), "float32"),
    "large, low memory, certified in double": (
        scene(4096, [0.002], low_memory=True, precision="single", accuracy=4e-4),
        "float32",
    ),
    "free edges, low memory": (scene(2048, **FREE), "float32"),
    "free edges, two loads": (scene(2048, [0.1, 0.3], boundary="free"), "float32"),
    "distributions": (scene(2048) | {"output": {"distributions": ["gap", "patches"]}}, "float32"),
    "dents that stay": (
        scene(2048, [0.1, 0.3])
        | {"material": {"hardness": 0.5}, "load": {"p_star": [0.1, 0.3], "history": True}},
        "float64",
    ),
    "layer": (scene(2048) | {"material": {"thickness": 0.01, "nu1": 0.3}}, "float32"),
}

LARGE = pytest.mark.slow, pytest.mark.alone


@pytest.mark.parametrize(
    ("name", "ranks"),
    [
        pytest.param(name, ranks, marks=() if name[:5] == "quick" and ranks == 1 else LARGE)
        for name in CASES
        for ranks in (1, 2)
    ],
)
def test_memory(name, ranks, tmp_path):
    table, precision = CASES[name]
    check(table, ranks, tmp_path, precision)


def test_memory_of_a_part_of_a_map(tmp_path):
    """The whole map is read, also where a sixteenth of it is pressed."""
    path = str(tmp_path / "z.npy")
    np.save(path, np.tile(rough_wall((2, 128, 2)).heights, (8, 8)))
    table = scene(512)
    table["surface"] = {
        "kind": "file",
        "path": path,
        "physical_sizes": [8, 8],
        "crop": [0, 0, 2, 2],
        "boundary": "periodic",
    }
    check(table, 1, tmp_path, "float32")
