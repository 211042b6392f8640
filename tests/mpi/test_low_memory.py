"""Low memory at small loads, where rounding errors of the heights' transforms must not be mistaken
for pressure out of contact."""

import numpy as np
import pytest
from contacts import rough, sweep_of

from hpc_gfmd.parallel import grid
from hpc_gfmd.parallel.comm import SerialComm

pytestmark = [pytest.mark.mpi, pytest.mark.two_ranks]
P_STAR = 0.002
RESIDUAL = 2e-4


def solve(comm):
    """Return a sweep and its contact at a small load, in single precision and low memory."""
    solver = {"residual": RESIDUAL, "precision": "single", "low_memory": True}
    sweep = sweep_of(rough((2, 32, 2)), comm=comm, max_iterations=60, **solver)
    return sweep, sweep.solve(P_STAR * sweep.surface.g_rms)


def test_small_loads(comm):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(grid, "SMALL", 0)  # plans are released even on small grids
        sweep, step = solve(comm)
    assert (step.status, step.certificate.precision) == ("converged", "float64")
    assert step.certificate.residual < RESIDUAL
    # the plans of the certificate are released
    assert [fft.dtype for fft in sweep.surface.grid.planned()] == [np.float32]
    assert step.contact_points == solve(SerialComm())[1].contact_points
