"""Any solve with several threads: as with one, area to the point, fields to rounding."""

import numpy as np
import pytest
from contacts import EXACT, field, rough

from hpc_gfmd.driver.lowmemory import LowMemorySweep
from hpc_gfmd.driver.sweep import Sweep
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.registry import all_observables, solver_names
from hpc_gfmd.scene import Scene
from hpc_gfmd.surface import build_surface


def steps_of(surface, loads, threads, low=False, **solver):
    """The contacts of a sweep (numbers, copies of fields, iterations) with so many threads."""
    scene = Scene.from_dict({"surface": surface, "load": {"p_star": loads}, "solver": solver | {"low_memory": low}})
    sweep = (LowMemorySweep if low else Sweep)(
        lambda dtype: build_surface(scene.surface, SerialComm(), dtype, threads, low), scene.solver)
    for p in sweep.pressures(scene.load):
        step = sweep.solve(p)
        assert step.contact.outcome.status == "converged"
        assert len(step.contact.surface.grid.fft(step.contact.g.dtype).row_scratch) == threads
        numbers = {name: value for name, f in all_observables().items() if (value := f(step.contact)) is not None}
        yield numbers, {name: field(step, name) for name in ("pressure", "gap")}, step.iterations, step.contact.contact_points


def assert_same(surface, loads, threads, rounding, **solver):
    for one, several in zip(*(steps_of(surface, loads, k, **solver) for k in (1, threads)), strict=True):
        assert several[2:] == one[2:]
        assert several[0] == pytest.approx(one[0], rel=rounding)
        for name, wanted in one[1].items():
            assert np.abs(several[1][name] - wanted).max() <= rounding * wanted.max()


@pytest.mark.parametrize("threads", [2, 3])
@pytest.mark.parametrize("name", solver_names())
def test_every_solver(name, threads):
    assert_same(rough((2, 16, 2), seed=2), [0.03, 0.2], threads, 1e-9, **EXACT | {"name": name, "residual": 1e-9})


@pytest.mark.parametrize("threads", [2, 3])
@pytest.mark.parametrize(("surface", "solver", "rounding"), [
    (rough((2, 32, 4), hurst=0.3), {"accuracy": 1e-3, "precision": "single"}, 1e-4),
    (rough((2, 32, 4), hurst=0.3), {"accuracy": 1e-3, "precision": "single", "low": True}, 1e-3),
    (rough((1, 31, 5.0), physical_sizes=[1.0, 2.0]), EXACT, 1e-9),
    (rough((2, 8, 2)), {"accuracy": 1e-3}, 1e-9)],
    ids=["single", "low memory", "odd, stretched", "single, then double"])
def test_every_way(surface, solver, rounding, threads):
    """More than one pass of rows and block of columns for each thread, warm and cold loads."""
    assert_same(surface, [0.05, 0.06, 0.4], threads, rounding, **solver)
