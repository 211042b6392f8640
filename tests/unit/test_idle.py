"""The instrument of `scripts/bench process`: times in which all threads of a process work."""

import sys
import time

import numpy as np
import pytest
from bench.idle import IdleWatch, seconds_at_work

import hpc_gfmd
from hpc_gfmd.operators.coarsest import CoarsestLevels
from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.parallel import grid, threads
from hpc_gfmd.solvers import solver_class


def test_seconds_at_work():
    """Two threads work at the same time from 1 to 2 and from 4 to 5."""
    pieces = [(0, 2), (1, 3), (4, 6), (3, 5)]
    ends = [(time, change) for piece in pieces for time, change in zip(piece, (1, -1))]
    assert [seconds_at_work(ends, count) for count in (1, 2, 3)] == [6, 2, 0]
    assert seconds_at_work([], 2) == 0


@pytest.fixture
def watch(monkeypatch):
    """An IdleWatch whose wrappers around functions of the package are removed after the test."""
    watched = (solver_class("auto"), "step"), (Multilevel, "sweep"), (CoarsestLevels, "_do")
    for owner, name in watched:
        monkeypatch.setattr(owner, name, getattr(owner, name))
    for module in (grid, threads):
        monkeypatch.setattr(module, "on_threads", module.on_threads)
    for name, module in list(sys.modules.items()):
        if name.startswith("hpc_gfmd.") and hasattr(module, "on_threads"):
            monkeypatch.setattr(module, "on_threads", module.on_threads)
    return IdleWatch()


@pytest.mark.slow
def test_parts_sum_to_the_time_of_a_solve(watch):
    wall = np.random.default_rng(1).standard_normal((64, 64)) * 1e-3
    outer_begin = time.perf_counter()
    watch.take()
    begin = time.perf_counter()
    hpc_gfmd.solve(wall, p_star=0.1, threads=2)
    inner = time.perf_counter() - begin
    seconds = watch.take()
    outer = time.perf_counter() - outer_begin
    assert inner <= sum(seconds.values()) <= outer
    assert min(seconds.values()) >= 0
    assert seconds["coarse_levels"] > 0
    assert seconds["set_up"] > 0
