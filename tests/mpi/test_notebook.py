"""hpc_gfmd.solve with a communicator: numbers of one process, fields by rows, one file, errors on
all ranks."""

import numpy as np
import pytest
from contacts import random_heights, rough
from mpi.same import assert_same_fields, solve_twice

import hpc_gfmd
from hpc_gfmd import SceneError
from hpc_gfmd.scene import Scene

pytestmark = [pytest.mark.mpi, pytest.mark.two_ranks]
Z = random_heights((24, 20), 3) / 100
LOADS = [1e-3, 4e-3]
NAMES = ("patches", "percolation", "stiffness")


# rough, fewer rows than ranks, a profile
@pytest.mark.parametrize("heights", [Z, Z[:3], Z[:, :1] * np.ones(20)])
def test_as_one_process(comm, heights):
    together, alone = solve_twice(comm, heights, LOADS, boundary="periodic")
    for spread, alone_solution in zip(together, alone, strict=True):
        assert spread.a_r == alone_solution.a_r
        assert_same_fields(spread, alone_solution, ["pressure", "gap", "heights"], 1e-3)
        assert np.array_equal(spread.contact, alone_solution.contact[slice(*spread.rows)])
        for name in NAMES:
            assert spread.observable(name) == pytest.approx(
                alone_solution.observable(name), rel=1e-3
            ), name
        assert (
            spread.distribution("patches").keys() == alone_solution.distribution("patches").keys()
        )
    together.save("x.h5")
    for spread, alone_solution in zip(hpc_gfmd.load("x.h5"), alone, strict=True):
        assert np.array_equal(spread.contact, alone_solution.contact)
        assert spread.observables["patches"] == alone_solution.observables["patches"]


def test_wrong_arguments_on_one_rank_are_an_error_on_all(comm):
    mine = Z if comm.rank == 0 else Z[:12]
    for arguments in (
        {"heights": mine, "pressure": 1.0},
        {"heights": Z, "pressure": 1.0 + comm.rank},
        {"heights": Z if comm.rank == 0 else "z.npy", "pressure": 1.0},
        {"heights": Z, "pressure": 1.0 if comm.rank == 0 else -1.0},
    ):
        if comm.size == 1:
            hpc_gfmd.solve(**arguments, comm=comm)
        else:
            with pytest.raises(SceneError, match=r"found"):
                hpc_gfmd.solve(**arguments, comm=comm)


def test_a_communicator_of_mpi4py(comm):
    if comm.size == 1:
        pytest.skip("needs several ranks")
    solution = hpc_gfmd.solve(Z, LOADS[0], comm=comm.mpi)
    assert solution.pressure.shape == (solution.rows[1] - solution.rows[0], 20)
    for refused_call in (solution.plot, solution.__reduce__):
        with pytest.raises(SceneError, match="spread over"):
            refused_call()
    scene = Scene.from_dict({"surface": rough(), "load": {"p_star": 0.1}})
    assert hpc_gfmd.run(scene, out="run.h5", quiet=True, comm=comm.mpi).status == "converged"
    with pytest.raises(SceneError, match=r"^comm: found int, allowed"):
        hpc_gfmd.run(scene, comm=3)
