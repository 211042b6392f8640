"""An item of the paper stores the same runs on several ranks as on one."""

import pytest
from paper.cases import Case, Store
from paper.solve import run_missing

from hpc_gfmd.parallel.comm import SerialComm

pytestmark = pytest.mark.mpi
CASES = [
    Case(0.8, 2, 8, 2, 1, (0.05, 0.35)),
    Case(0.3, 2, 8, 3, 2, (0.02,)),
    Case(0.3, 2, 8, 1.5, 2, (0.02,)),
]
DIFFERENT = {"wall_seconds", "ranks", "a_r_error", "gap_error", "pressure_error"}


def test_same_lines(comm, shared_path):
    assert run_missing(CASES, Store(shared_path / "ranks"), comm, say=lambda text: None) == 1
    comm.barrier()
    runs = list(Store(shared_path / "ranks").stored().values())
    store_alone = Store(shared_path / f"alone-{comm.rank}")
    run_missing(CASES, store_alone, SerialComm(), say=lambda text: None)
    runs_alone = list(store_alone.stored().values())
    assert len(runs) == len(runs_alone) == 3
    for run, run_alone in zip(runs, runs_alone, strict=True):
        assert run["ranks"] == comm.size
        for name in run_alone.keys() - DIFFERENT:
            expected = run_alone[name]
            if isinstance(expected, float):
                expected = pytest.approx(expected, rel=2e-5)
            assert run[name] == expected, name
