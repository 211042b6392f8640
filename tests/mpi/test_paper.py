"""An item of the paper on several ranks stores what it stores alone."""

import pytest
from paper.cases import Case, Store
from paper.solve import run_missing

from hpc_gfmd.parallel.comm import SerialComm

pytestmark = pytest.mark.mpi
CASES = [
    Case(0.8, 2, 16, 2, 1, (0.05, 0.35)),
    Case(0.3, 2, 8, 3, 2, (0.02,)),
    Case(0.3, 2, 8, 1.5, 2, (0.02,)),
]
PERSONAL = {"wall_seconds", "ranks", "a_r_error", "gap_error", "pressure_error"}


def test_same_lines(comm, shared_path):
    assert run_missing(CASES, Store(shared_path / "ranks"), comm, say=lambda text: None) == 1
    comm.barrier()
    found = list(Store(shared_path / "ranks").stored().values())
    own = Store(shared_path / f"alone-{comm.rank}")
    run_missing(CASES, own, SerialComm(), say=lambda text: None)
    wanted = list(own.stored().values())
    assert len(found) == len(wanted) == 3
    for ours, alone in zip(found, wanted, strict=True):
        assert ours["ranks"] == comm.size
        for name in alone.keys() - PERSONAL:
            assert ours[name] == (
                pytest.approx(alone[name], rel=2e-5)
                if isinstance(alone[name], float)
                else alone[name]
            ), name
