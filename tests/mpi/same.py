"""Comparisons of a load on all ranks with the same load on one process."""

import time
from types import SimpleNamespace

import numpy as np
import pytest
from contacts import EXACT, field, sweep_of

import hpc_gfmd
from hpc_gfmd.contact import all_observables


def from_rank_0(comm, work):
    """Return work() of rank 0, which the others wait for in their sleep: a broadcast would poll."""
    if comm.size == 1:
        return work()
    result = work() if comm.rank == 0 else None
    meeting = comm.mpi.Ibarrier()
    while not meeting.Test():
        time.sleep(0.001)
    return comm.bcast(result)


def save(comm, **arrays):
    """Write arrays to files NAME.npy in the current folder, which ranks share. Collective."""
    if comm.rank == 0:
        for name, array in arrays.items():
            np.save(f"{name}.npy", array)
    comm.barrier()


class Alone:
    """A sweep in one process, rank 0, whose loads are sent to all ranks.

    Parameters
    ----------
    comm
        All ranks.
    make : function
        make() returns the sweep, in one process.
    """

    def __init__(self, comm, make):
        self.comm = comm
        self.sweep = make() if comm.rank == 0 else None
        g_rms = from_rank_0(comm, lambda: self.sweep.surface.g_rms)
        self.surface = SimpleNamespace(g_rms=g_rms)

    def solve(self, load):
        """Return what tests compare of a load, with whole fields."""
        return from_rank_0(self.comm, lambda: compared(self.sweep.solve(load)))


def compared(step):
    """Return numbers and fields of a solved load, which can be sent to other ranks."""
    names = ["pressure", "gap"]
    if step.surface.h is not None:  # low memory has no displacement
        names.append("displacement")
    numbers = ("status", "p_mean", "contact_points", "gap_mean", "approach")
    return SimpleNamespace(
        observables={name: observable(step) for name, observable in all_observables().items()},
        fields={name: field(step, name) for name in names},
        **{name: getattr(step, name) for name in numbers},
    )


def assert_same(comm, step, alone, tolerance=1e-10):
    """Compare all numbers, and this rank's rows of all fields, with those of one process."""
    observables = {k: (f(step), alone.observables[k]) for k, f in all_observables().items()}
    for name, (number, expected) in observables.items():
        assert (number is None) == (expected is None), name
        assert number is None or number == pytest.approx(expected, rel=tolerance), name
    assert step.status == alone.status
    mine = slice(*step.surface.rows)
    for name, whole in alone.fields.items():
        slab = field(step, name)
        assert slab.shape == whole[mine].shape
        assert np.abs(slab - whole[mine]).max(initial=0) <= tolerance * np.abs(whole).max()
    assert all(s == observables["a_r"][0] for s in comm.allgather(observables["a_r"][0]))


def sweeps(comm, surface, **solver):
    """Return a sweep on all ranks and one in one process."""
    return sweep_of(surface, comm=comm, **solver), Alone(comm, lambda: sweep_of(surface, **solver))


def compare(comm, surface, pressure, tolerance=1e-10, **solver):
    """Solve one load on all ranks and on one process, and compare."""
    steps = [sweep.solve(pressure) for sweep in sweeps(comm, surface, **EXACT | solver)]
    assert_same(comm, *steps, tolerance)


def solve_twice(comm, heights, *load, **arguments):
    """Return the results of hpc_gfmd.solve on all ranks and in one process."""
    on_ranks = hpc_gfmd.solve(heights, *load, comm=comm, **arguments)
    return on_ranks, from_rank_0(comm, lambda: hpc_gfmd.solve(heights, *load, **arguments))


def assert_same_fields(on_ranks, alone, names, tolerance):
    """Compare this rank's rows of a solution with those of one process."""
    for name in names:
        whole = getattr(alone, name)
        error = np.abs(getattr(on_ranks, name) - whole[slice(*on_ranks.rows)])
        assert error.max(initial=0) <= tolerance * np.abs(whole).max(), name
