"""Loads prescribed by gap, area, force or approach: in scenes, solve and results."""

import gc
import re
import weakref

import numpy as np
import pytest
from contacts import random_heights, rough, scene_text

import hpc_gfmd
from hpc_gfmd.output.read import read_result
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.runs.loads import Run
from hpc_gfmd.runs.progress import Reporter
from hpc_gfmd.scene import Scene
from hpc_gfmd.surface import build_surface

SI = {"physical_sizes": ["1 mm", "1 mm"], "h_rms": "1 um", "boundary": "free"}


def test_run_plan_and_show(tmp_path, cli):
    """Results hold the prescribed value and the pressure; impossible values are refused."""
    (tmp_path / "scene.toml").write_text(scene_text(load={"gap_over_h_rms": [0.4, 0.3]}))
    assert cli.data("plan scene.toml")["loads"] == 2
    cli.prints("run scene.toml -q")
    steps = cli.data("show contact.h5")["steps"]
    for step, wanted in zip(steps, (0.4, 0.3), strict=True):
        assert step["target_gap_over_h_rms"] == wanted
        assert step["gap_over_h_rms"] == pytest.approx(wanted, rel=1e-3)
        assert step["p"] == pytest.approx(step["p_star"])
    assert steps[0]["p"] < steps[1]["p"]
    assert "gap/h_rms" in cli.prints("show contact.h5")
    error = cli.refused("run scene.toml --set", "load={gap_over_h_rms = 30}", "-o", "never.h5")
    assert "load.gap_over_h_rms: found 30, allowed: below " in error
    assert not list(tmp_path.glob("never*"))


@pytest.mark.parametrize("load", [{"p_star": [1e-3, 0.1]}, {"pressure": 1e-3}])
def test_light_first_load_makes_its_surface_once(load):
    """In double precision, which it needs, from the beginning; the solution is that of double."""
    table = {"surface": rough(g_rms=1.0), "load": load}
    scene = Scene.from_dict(table)
    made = []

    def make(precision):
        made.append(build_surface(scene.surface, SerialComm(), precision))
        return made[-1]

    run = Run(scene, make, Reporter(SerialComm(), scene.solver, quiet=True))
    solved = next(run.solve())
    assert [surface.gap.dtype for surface in made] == [np.float64]
    in_double = hpc_gfmd.solve(Scene.from_dict(table | {"solver": {"precision": "double"}}))
    assert solved.numbers["gap_mean"] == in_double[0].gap_mean


def test_units_of_a_height_map(tmp_path, cli):
    """Loads need units if the map has one; results are in SI units."""
    np.save("z.npy", random_heights((32, 32), seed=1))
    text = (
        'surface = {kind = "file", path = "z.npy", unit = "nm", physical_sizes = ["1 um", "1 um"],'
        ' boundary = "free"}\n'
    )
    (tmp_path / "s.toml").write_text(text + 'material.E_star = "1 GPa"\nload.gap_mean = "2 nm"\n')
    cli.prints("run s.toml -q")
    (step,) = read_result("contact.h5").steps
    assert step["target_gap_mean"] == pytest.approx(2e-9)
    assert step["gap_mean"] == pytest.approx(2e-9, rel=1e-3)
    again = "run s.toml -q --force --set"
    assert 'load.gap_mean: found 2, plain, allowed with this height map: "50 nm"' in cli.refused(
        again, "load={gap_mean = 2.0}"
    )
    assert re.search(
        r"load.gap_mean: found 50 um, allowed: below 0.00\d+ um,",
        cli.refused(again, 'load={gap_mean = "50 um"}'),
    )
    cli.prints(again, 'load={force = "1 uN"}')
    (step,) = read_result("contact.h5").steps
    assert (step["target_force"], step["p"]) == pytest.approx((1e-6, 1e6))


@pytest.mark.parametrize("loads", [0.1, [0.1, 0.2]])
def test_results_free_their_memory_at_once(loads):
    """Fields of a result that is dropped do not wait for the collector of cycles."""
    heights = random_heights((16, 16), seed=1)
    gc.collect()
    gc.disable()
    try:
        result = hpc_gfmd.solve(heights, p_star=loads, boundary="periodic")
        assert "converged" in repr(result)  # this reads what is made at the first look
        dropped = weakref.ref(result)
        del result
        assert dropped() is None
    finally:
        gc.enable()


def test_results_of_arrays_know_their_heights():
    """The identity of a result has the checksum of the heights, the same in both precisions."""
    identities = [
        hpc_gfmd.solve(
            scale * random_heights((128, 128), seed=1),
            p_star=0.2,
            boundary="periodic",
            precision=precision,
            fields=(),
        )
        .result.head["identity"]
        .partition(" of ")[2]
        for scale in (1.0, 2.0)
        for precision in ("single", "double")
    ]
    assert identities[0] == identities[1] != identities[2] == identities[3]
    assert all(len(checksum) == 32 for checksum in identities)
