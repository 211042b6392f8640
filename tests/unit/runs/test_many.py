"""solve_many: results and their order, errors, and no processes left behind."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from contacts import random_heights, rough_wall
from refusal import refused

import hpc_gfmd

LOADS = [0.05, 0.1]
# No `if __name__ == "__main__"`.
ENDLESS = """
import itertools, numpy as np, hpc_gfmd
wall = hpc_gfmd.make_surface("wave", n=(16, 16), amplitude=0.01)
for found in hpc_gfmd.solve_many(itertools.repeat(wall), 0.01, processes=2):
    print(found[0].status, flush=True)
"""


def workers(program):
    """Command lines of the worker processes of a program."""
    lines = [path.read_bytes() for path in Path("/proc").glob("[0-9]*/cmdline") if path.exists()]
    return [line for line in lines if b"runs.many" in line and str(program).encode() in line]


def test_results_agree_with_single_solves():
    """Results and errors are in the order of surfaces, of which few are made ahead."""
    walls = [rough_wall((1, 8, 2), seed=seed) for seed in range(7)]
    walls[2] = np.full((8, 8), np.nan)
    made = []
    several = hpc_gfmd.solve_many(
        (made.append(wall) or wall for wall in walls), p_star=LOADS, processes=1, accuracy=1e-2
    )
    assert made == []
    for k, (result, wall) in enumerate(zip(several, walls, strict=True)):
        assert len(made) <= k + 3
        if k == 2:
            assert isinstance(result, hpc_gfmd.SceneError)
            assert "found nan at (0, 0)" in str(result)
        else:
            wanted = hpc_gfmd.solve(wall, p_star=LOADS, accuracy=1e-2)
            assert result.values("a_r").tolist() == wanted.values("a_r").tolist()


def test_dying_and_unconverged_surfaces(monkeypatch):
    class Deadly(np.ndarray):
        def __reduce__(self):
            return os._exit, (3,)

    surfaces = [random_heights((8, 8)) for _ in range(3)]
    surfaces[1] = surfaces[1].view(Deadly)
    several = hpc_gfmd.solve_many(surfaces, 0.1, processes=1, max_iterations=1, accuracy=1e-9)
    with pytest.warns(hpc_gfmd.NotConverged, match="surface [02]: not converged") as warned:
        results = list(several)
    assert sum(item.category is hpc_gfmd.NotConverged for item in warned) == 2
    assert [type(item).__name__ for item in results] == ["Solutions", "GfmdError", "Solutions"]
    assert "3" in str(results[1])  # exit code of the process


def test_a_single_surface_is_refused():
    wall = rough_wall((1, 8, 2))
    for surface in (wall, wall.heights, "scene.toml", Path("scene.toml")):
        with refused("surfaces: found one .*, allowed: several"):
            hpc_gfmd.solve_many(surface, 0.1)


def test_bad_arguments_are_refused():
    for options in ({"processes": 0}, {"processes": "all"}, {"threads": 2}, {"pressure": 0.2}):
        name = next(iter(options))
        with refused(f"{name}: found"):
            hpc_gfmd.solve_many([], 0.1, **options)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_no_workers_survive_a_stopped_program(tmp_path, number):
    (tmp_path / "endless.py").write_text(ENDLESS)
    with subprocess.Popen(
        [sys.executable, "endless.py"], cwd=tmp_path, stdout=subprocess.PIPE, stderr=-3, text=True
    ) as program:
        assert program.stdout.readline() == "converged\n"
        assert len(workers(tmp_path)) == 2
        program.send_signal(number)
        assert program.wait(60) != 0
    for _ in range(200):
        if not workers(tmp_path):
            return
        signal.sigtimedwait([], 0.05)
    assert workers(tmp_path) == []
