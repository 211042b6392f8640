"""Comparisons of a load on all ranks with the same load on one process."""

import numpy as np
import pytest
from contacts import EXACT, field, rough, sweep_of

from hpc_gfmd.contact import all_observables
from hpc_gfmd.parallel.comm import SerialComm

every_size = pytest.mark.parametrize(
    "surface",
    [
        rough(),
        rough((1, 31, 2.0), seed=3),
        rough((2, 8, 3), hurst=0.3, physical_sizes=[1.0, 0.5]),
        rough((1, 97, 2), hurst=1.0),
    ],
)


def assert_same(comm, step, serial, tolerance=1e-10):
    """Compare all numbers, and this rank's rows of all fields, with those of one process."""
    observables = {k: (f(step), f(serial)) for k, f in all_observables().items()}
    for name, (number, expected) in observables.items():
        assert (number is None) == (expected is None), name
        assert number is None or number == pytest.approx(expected, rel=tolerance), name
    assert step.status == serial.status
    mine = slice(*step.surface.rows)
    names = ["pressure", "gap"]
    if serial.surface.h is not None:  # low memory has no displacement
        names.append("displacement")
    for name in names:
        slab = field(step, name)
        whole = field(serial, name)
        assert slab.shape == whole[mine].shape
        assert np.abs(slab - whole[mine]).max(initial=0) <= tolerance * np.abs(whole).max()
    assert all(s == observables["a_r"][0] for s in comm.allgather(observables["a_r"][0]))


def sweeps(comm, surface, **solver):
    """Return a sweep on all ranks and one on this process."""
    return [sweep_of(surface, comm=world, **solver) for world in (comm, SerialComm())]


def compare(comm, surface, pressure, tolerance=1e-10, **solver):
    """Solve one load on all ranks and on one process, and compare."""
    steps = [sweep.solve(pressure) for sweep in sweeps(comm, surface, **EXACT | solver)]
    assert_same(comm, *steps, tolerance)
