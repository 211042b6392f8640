"""Loads of a sweep: starts from the previous load, from coarser grids or from a stored gap."""

from dataclasses import replace

import numpy as np
import pytest
from contacts import EXACT, random_heights, rough, sweep_of, sweep_over
from refusal import refused

from hpc_gfmd.driver import precision
from hpc_gfmd.driver.load import Load, Unfinished
from hpc_gfmd.driver.nested import Nested
from hpc_gfmd.driver.starter import WARM
from hpc_gfmd.scene import LoadTable

SURFACE = rough((2, 8, 2))
P = 0.05  # p*


@pytest.fixture
def nested_starts(monkeypatch):
    """Loads p0 that were started from coarser grids."""
    starts = []
    candidate = Nested.candidate

    def counted(nested, problem, *more):
        if problem.grid.n == (32, 32):  # the finest grid
            starts.append(problem.p0)
        return candidate(nested, problem, *more)

    monkeypatch.setattr(Nested, "candidate", counted)
    return starts


@pytest.mark.parametrize(
    ("ratio", "is_near"),
    [(0.99 * WARM, True), (1.01 * WARM, False), (1.01 / WARM, True), (0.99 / WARM, False)],
)
def test_near_loads_start_from_the_previous_one(nested_starts, ratio, is_near):
    sweep = sweep_of(SURFACE, **EXACT)
    g_rms = sweep.surface.g_rms
    sweep.solve(P * g_rms)
    assert len(nested_starts) == 1
    contact = sweep.solve(ratio * P * g_rms)
    assert len(nested_starts) == (1 if is_near else 2)
    alone = sweep_of(SURFACE, **EXACT).solve(ratio * P * g_rms)
    assert contact.gap_mean == pytest.approx(alone.gap_mean, rel=1e-9)
    assert contact.contact_points == alone.contact_points


@pytest.mark.parametrize("table", [{"pressure": [0.1, 0.11]}, {"a_r": [0.1, 0.12]}])
def test_loads_after_a_failure_start_afresh(table):
    sweep = sweep_of(SURFACE, accuracy=1e-6)
    failing, fine = sweep.loads(LoadTable(**table))
    criterion = sweep.sweep.criterion
    sweep.sweep.criterion = replace(criterion, max_iterations=1)
    assert sweep.solve(failing).status == "max_iterations"
    sweep.sweep.criterion = criterion
    contact = sweep.solve(fine)
    alone = sweep_of(SURFACE, accuracy=1e-6).solve(fine)
    assert contact.certificate == alone.certificate
    assert (contact.iterations, contact.pairs) == (alone.iterations, alone.pairs)


@pytest.mark.parametrize("hardness", [None, 0.3])
def test_a_solved_gap_is_certified_and_needs_no_iterations(hardness):
    def make():
        layer = {"hardness": hardness} if hardness else None
        return sweep_of(SURFACE, layer=layer, accuracy=1e-4, precision="double")

    solved = make().solve(P)
    gap = solved.g.copy()
    sweep = make()
    again = sweep.solve(P, unfinished=Unfinished(gap, solved.p_mean, 0, 0.0))
    assert (again.status, again.iterations, again.pairs) == ("converged", 0, 1.0)
    assert np.array_equal(again.g, gap)
    assert again.certificate.errors == solved.certificate.errors
    assert sweep.solve(1.1 * P).status == "converged"  # from there


@pytest.mark.parametrize("quantity", ["a_r", "gap_mean", "approach"])
def test_stopped_searches_resume_at_their_load(quantity):
    """The pressure reached so far is the start."""
    boundary = "free" if quantity == "approach" else "periodic"
    surface = rough((2, 8, 2), boundary=boundary)

    def make():
        return sweep_of(surface, accuracy=1e-4)

    by_pressure = make().solve(P)
    value = {
        "a_r": by_pressure.contact_points / by_pressure.N,
        "gap_mean": by_pressure.gap_mean,
        "approach": by_pressure.approach,
    }[quantity]
    load = Load(quantity, value)
    whole = make().solve(load)
    unfinished = Unfinished(whole.g.copy(), whole.p_mean, whole.iterations, 0.0)
    resumed = make().solve(load, unfinished=unfinished)
    assert resumed.status == "converged"
    assert resumed.p_mean == pytest.approx(whole.p_mean, rel=1e-3)
    assert resumed.pairs < 0.7 * whole.pairs


def test_double_precision_goes_on_from_the_gap_of_single_precision(nested_starts, monkeypatch):
    """Coarse grids are solved once, and the pairs of both precisions count."""

    def solved():
        sweep = sweep_of(rough((2, 16, 2)), accuracy=2e-2)
        return sweep.solve(P * sweep.surface.g_rms)

    single = solved()
    monkeypatch.setattr(precision, "_is_spoilt", lambda *_: True)
    both = solved()
    assert len(nested_starts) == 2  # one each
    assert (single.g.dtype, both.g.dtype) == (np.float32, np.float64)
    assert both.status == "converged"
    assert both.pairs == single.pairs + 1  # its certificate


def test_heights_that_change_during_a_run_are_refused(tmp_path):
    """They are read again when a load needs double precision."""
    path = tmp_path / "z.npy"
    z = random_heights((32, 32))
    np.save(path, z)
    surface = {"kind": "file", "path": str(path), "physical_sizes": [1, 1]}
    sweep = sweep_of(surface, accuracy=1e-2)
    assert sweep.solve(0.4 * sweep.surface.g_rms).g.dtype == np.float32
    np.save(path, 2 * z)
    with refused("heights have changed"):
        sweep.solve(1e-4 * sweep.surface.g_rms)


def test_solving_a_load_does_not_change_it():
    """A Load can be solved twice."""
    sweep = sweep_over(random_heights((32, 32)), accuracy=1e-4)
    load = Load("gap_mean", 0.5 * sweep.surface.h_rms)
    first_pressure = sweep.solve(load).p_mean
    second_pressure = sweep.solve(load).p_mean
    assert first_pressure == pytest.approx(second_pressure, rel=1e-2)


def test_low_memory_refuses_other_solvers():
    with refused('solver.low_memory: .*allowed: .*"bpx"'):
        sweep_of(SURFACE, name="gfmd", low_memory=True, accuracy=1e-3)
