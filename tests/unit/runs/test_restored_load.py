"""What a restored load is solved for: the load that is asked for, on the heights that were read."""

from dataclasses import replace

import numpy as np
import pytest
from contacts import random_heights, rough, sweep_of
from refusal import refused

from hpc_gfmd.driver.load import Load
from hpc_gfmd.scene import Load as SceneLoad


def sweep(accuracy=1e-6, **material):
    return sweep_of(rough((2, 8, 2)), layer=material, accuracy=accuracy)


def stopped(load, **how):
    """Arrays and numbers of a sweep that is stopped in the middle of a load."""
    one = sweep(**how)
    one.solve(load, watch=lambda iterations, _: iterations == 3)
    arrays, numbers = one.state()
    return {name: np.array(data) for name, data in arrays.items()}, numbers


def test_the_state_of_another_load_is_refused():
    p = 0.1 * sweep().surface.g_rms
    held, numbers = stopped(p)
    with refused(r"a state at p\* = 0\.1, allowed: at 0\.2"):
        sweep().restore(lambda _: held, numbers, 2 * p)
    again = sweep()
    asked = p * (1 + 1e-13)  # as with another number of ranks
    again.restore(lambda _: held, numbers, asked)
    assert again.solver.p0 == asked / again.surface.g_rms != numbers["p0"]
    found, wanted = again.solve(asked, midway=True), sweep().solve(p)
    assert found.gap_mean == pytest.approx(wanted.gap_mean, rel=1e-10)
    assert found.iterations == wanted.iterations


def test_the_state_of_another_version_is_refused():
    load = Load("a_r", 0.2)
    held, numbers = stopped(load)
    search = numbers["search"]
    for other in (
        search | {"guesses": 0},
        {key: value for key, value in search.items() if key != "finest"},
    ):
        with refused("of another version"):
            sweep().restore(lambda _: held, numbers | {"search": other}, load)
    again = sweep()
    again.restore(lambda _: held, numbers, load)
    assert again.solve(load, midway=True).status == "converged"


def test_the_load_that_closes_the_gap_goes_on_as_such():
    """With a hardness it takes iterations."""
    load, hard = Load("a_r", 1.0), {"accuracy": 1e-2, "hardness": 2.0}
    held, numbers = stopped(load, **hard)
    again = sweep(**hard)
    again.restore(lambda _: held, numbers, load)
    found, wanted = again.solve(load, midway=True), sweep(**hard).solve(load)
    assert (found.status, found.iterations) == ("converged", wanted.iterations)


@pytest.mark.parametrize("loads", [{"pressure": [0.1, 0.11]}, {"a_r": [0.1, 0.12]}])
def test_after_a_load_that_failed_the_next_one_starts_afresh(loads):
    one = sweep()
    failing, fine = one.loads(SceneLoad(**loads))
    one.target, wanted = replace(one.target, max_iterations=1), one.target
    assert one.solve(failing).status == "max_iterations"
    one.target = wanted
    assert not one.state(fine)[0]  # nothing to start from
    found, expected = one.solve(fine), sweep().solve(fine)
    assert found.certificate == expected.certificate
    assert (found.iterations, found.pairs) == (expected.iterations, expected.pairs)


def test_heights_that_change_while_a_run_goes_on(tmp_path):
    """They are read again where a load needs more than single precision."""
    path, z = tmp_path / "z.npy", random_heights((32, 32))
    np.save(path, z)
    surface = {"kind": "file", "path": str(path), "physical_sizes": [1, 1]}
    one = sweep_of(surface, accuracy=1e-2)
    assert one.solve(0.4 * one.surface.g_rms).g.dtype == np.float32
    np.save(path, 2 * z)
    with refused("heights have changed"):
        one.solve(1e-4 * one.surface.g_rms)
