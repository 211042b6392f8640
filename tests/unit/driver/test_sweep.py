"""Which way a load of a sweep takes: from the load before, from coarser grids, closed at once, or
from a gap that is stored; and what is known from the loads before."""

from dataclasses import replace

import numpy as np
import pytest
from contacts import EXACT, field, random_heights, rough, sweep_of, sweep_over
from refusal import refused

from hpc_gfmd.driver.load import Load
from hpc_gfmd.driver.nested import Nested
from hpc_gfmd.driver.starter import WARM_DOWN, WARM_UP
from hpc_gfmd.driver.sweep import Unfinished
from hpc_gfmd.scene import LoadTable

SURFACE = rough((2, 8, 2))
P = 0.05  # p*


@pytest.fixture
def nested_starts(monkeypatch):
    """How often a contact is started from coarser grids."""
    starts, start = [], Nested.start

    def counted(nested, problem, *more):
        if problem.grid.n == (32, 32):  # the finest
            starts.append(problem.p0)
        return start(nested, problem, *more)

    monkeypatch.setattr(Nested, "start", counted)
    return starts


@pytest.mark.parametrize(
    ("ratio", "is_near"),
    [
        (0.99 * WARM_UP, True),
        (1.01 * WARM_UP, False),
        (1.01 / WARM_DOWN, True),
        (0.99 / WARM_DOWN, False),
    ],
)
def test_a_load_that_is_near_starts_from_the_one_before(nested_starts, ratio, is_near):
    sweep = sweep_of(SURFACE, **EXACT)
    g_rms = sweep.surface.g_rms
    sweep.solve(P * g_rms)
    assert len(nested_starts) == 1
    contact = sweep.solve(ratio * P * g_rms)
    assert len(nested_starts) == (1 if is_near else 2)
    alone = sweep_of(SURFACE, **EXACT).solve(ratio * P * g_rms)
    assert contact.gap_mean == pytest.approx(alone.gap_mean, rel=1e-9)
    assert contact.contact_points == alone.contact_points


@pytest.mark.parametrize("asked", [{"pressure": [0.1, 0.11]}, {"a_r": [0.1, 0.12]}])
def test_after_a_load_that_failed_the_next_one_starts_afresh(asked):
    sweep = sweep_of(SURFACE, accuracy=1e-6)
    failing, fine = sweep.loads(LoadTable(**asked))
    criterion = sweep.starter.criterion
    sweep.starter.criterion = replace(criterion, max_iterations=1)
    assert sweep.solve(failing).status == "max_iterations"
    sweep.starter.criterion = criterion
    contact, alone = sweep.solve(fine), sweep_of(SURFACE, accuracy=1e-6).solve(fine)
    assert contact.certificate == alone.certificate
    assert (contact.iterations, contact.pairs) == (alone.iterations, alone.pairs)


def test_full_contact_takes_no_iteration():
    sweep = sweep_of(SURFACE, **EXACT)
    closes = sweep.solve(Load("a_r", 1.0))
    assert (closes.iterations, closes.contact_points) == (0, closes.N)
    above = sweep.solve(1.1 * closes.p_mean)
    assert (above.iterations, above.contact_points) == (0, above.N)
    assert above.gap_mean == 0
    below = sweep.solve(0.9 * closes.p_mean)
    assert below.contact_points < below.N
    # p = p0 + K u, u = -h: nothing but the mean pressure is different
    change = field(above, "pressure") - field(closes, "pressure")
    assert np.ptp(change) < 1e-12 * above.p_mean


def test_a_stored_gap_is_a_start(nested_starts):
    """In any precision; iterations and pairs of before count."""
    sweep = sweep_of(SURFACE, **EXACT)
    p_mean = P * sweep.surface.g_rms
    stopped = sweep.solve(p_mean, lambda iterations, progress: iterations == 3)
    assert stopped.status == "interrupted"
    gap = stopped.g.copy()
    unfinished = Unfinished(gap, stopped.p_mean, stopped.iterations, stopped.pairs)
    whole = sweep_of(SURFACE, **EXACT).solve(p_mean)
    del nested_starts[:]
    contact = sweep_of(SURFACE, **EXACT).solve(p_mean, unfinished=unfinished)
    assert nested_starts == []
    assert contact.status == "converged"
    assert contact.gap_mean == pytest.approx(whole.gap_mean, rel=1e-10)
    assert contact.iterations > stopped.iterations
    assert contact.pairs > stopped.pairs
    single = sweep_of(SURFACE, accuracy=1e-3).solve(p_mean, unfinished=unfinished)
    assert single.g.dtype == np.float64  # as the run that was stopped


@pytest.mark.parametrize("quantity", ["a_r", "gap_mean", "approach"])
def test_a_search_goes_on_at_its_load(quantity):
    """The pressure that was nearly found is not searched for anew."""
    boundary = "free" if quantity == "approach" else "periodic"
    make = lambda: sweep_of(rough((2, 8, 2), boundary=boundary), accuracy=1e-4)  # noqa: E731
    given = make().solve(P)
    value = {
        "a_r": given.contact_points / given.N,
        "gap_mean": given.gap_mean,
        "approach": given.approach,
    }[quantity]
    load = Load(quantity, value)
    whole = make().solve(load)
    unfinished = Unfinished(whole.g.copy(), whole.p_mean, whole.iterations, 0.0)
    again = make().solve(load, unfinished=unfinished)
    assert again.status == "converged"
    assert again.p_mean == pytest.approx(whole.p_mean, rel=1e-3)
    assert again.pairs < 0.7 * whole.pairs


def test_once_in_double_always_in_double():
    sweep = sweep_of(rough((2, 16, 2)), accuracy=4e-3)
    g_rms = sweep.surface.g_rms
    dtypes = [sweep.solve(p * g_rms).g.dtype for p in (0.3, 1e-4, 0.3)]
    assert dtypes == [np.float32, np.float64, np.float64]


def test_heights_that_change_while_a_run_goes_on(tmp_path):
    """They are read again where a load needs more than single precision."""
    path, z = tmp_path / "z.npy", random_heights((32, 32))
    np.save(path, z)
    surface = {"kind": "file", "path": str(path), "physical_sizes": [1, 1]}
    sweep = sweep_of(surface, accuracy=1e-2)
    assert sweep.solve(0.4 * sweep.surface.g_rms).g.dtype == np.float32
    np.save(path, 2 * z)
    with refused("heights have changed"):
        sweep.solve(1e-4 * sweep.surface.g_rms)


def test_a_load_is_solved_again_as_it_was():
    """What is asked for is not changed by solving it."""
    sweep = sweep_over(random_heights((32, 32)), accuracy=1e-4)
    load = Load("gap_mean", 0.5 * sweep.surface.h_rms)
    first, second = sweep.solve(load).p_mean, sweep.solve(load).p_mean
    assert load.search is None
    assert first == pytest.approx(second, rel=1e-2)  # 204.8 points are met to one point


def test_low_memory_refuses_other_solvers():
    with refused('solver.low_memory: .*allowed: .*"bpx"'):
        sweep_of(SURFACE, name="gfmd", low_memory=True, accuracy=1e-3)
