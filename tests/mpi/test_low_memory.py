"""Low memory at small loads: rounding errors of the heights' transforms are not taken for pressure
out of contact."""

from dataclasses import replace

import numpy as np
import pytest
from contacts import rough, sweep_of

from hpc_gfmd.driver import working_surface
from hpc_gfmd.parallel import grid
from hpc_gfmd.parallel.comm import SerialComm

pytestmark = pytest.mark.mpi
P_STAR = 0.002
RESIDUAL = 2e-4


def solved(comm):
    """The sweep and its step at a small load, in single precision and low memory."""
    how = {"residual": RESIDUAL, "precision": "single", "low_memory": True, "max_iterations": 60}
    sweep = sweep_of(rough((2, 32, 2)), comm=comm, **how)
    return sweep, sweep.solve(P_STAR * sweep.surface.g_rms)


def test_small_loads(comm):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(grid, "SMALL", 0)  # transforms are given back, small or not
        sweep, step = solved(comm)
    assert (step.status, step.certificate.precision) == ("converged", "float64")
    assert step.certificate.residual < RESIDUAL
    # those of the certificate have given their memory back
    assert [fft.dtype for fft in sweep.surface.grid.planned()] == [np.float32]
    assert step.contact_points == solved(SerialComm())[1].contact_points


def test_single_precision_alone_does_not_get_there(monkeypatch):
    blind = replace(working_surface.CALIBRATION, noise=np.inf)
    monkeypatch.setattr(working_surface, "CALIBRATION", blind)
    _, step = solved(SerialComm())
    assert step.status != "converged"
    assert step.certificate.residual > RESIDUAL
