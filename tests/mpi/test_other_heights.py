"""A restart needs the heights with which the run began, and is refused with others."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
import tomli_w
from contacts import random_heights

from hpc_gfmd.commands.cli import main
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.parallel.interrupt import Interrupt
from hpc_gfmd.surface.heights import checksum, sums_of_rows

pytestmark = [pytest.mark.mpi, pytest.mark.two_ranks]
SCENE = tomli_w.dumps(
    {
        "surface": {"kind": "file", "physical_sizes": [1.0, 1.0], "path": "z.npy"},
        "load": {"pressure": [0.2, 0.3]},
        "solver": {"accuracy": 1e-4},
        "machine": {"wall_seconds": 1e-9},
    }
)
RESTART = "restart contact.h5 --set machine.wall_seconds=1000"
PARTIAL = "contact.h5.partial"


def checksum_of(z, comm, sizes=(1.0, 1.0)):
    grid = Grid(z.shape, comm=comm, threads=2)
    return checksum(comm, sums_of_rows(z[slice(*grid.rows)]), z.shape, sizes)


def test_one_checksum_for_any_number_of_ranks(comm):
    z = random_heights((9, 8))
    whole = checksum_of(z, SerialComm())
    assert checksum_of(z, comm) == whole
    lifted = z.copy()
    swapped = z[::-1].copy()
    lifted[-1, -1] = np.nextafter(lifted[-1, -1], 9)
    changed = [checksum_of(x, comm) for x in (lifted, swapped, z.reshape(8, 9))]
    changed.append(checksum_of(z, comm, (1.0, 2.0)))
    assert len({whole, *changed}) == 5


@pytest.fixture
def begun(comm, shared_path, monkeypatch, capfd):
    """begun(z, words) runs a command with heights z and returns its exit code and stderr.

    The time limit of the scene stops the run in its first load.
    """
    monkeypatch.setattr(Interrupt, "require_time", lambda self: None)

    def call(z, words):
        comm.barrier()
        if comm.rank == 0:
            np.save("z.npy", z)
            (shared_path / "scene.toml").write_text(SCENE)
        comm.barrier()
        capfd.readouterr()
        code = main(words.split())
        comm.barrier()
        return code, capfd.readouterr().err

    return call


@pytest.mark.parametrize(
    ("change", "checkpoint"),
    [
        (lambda z: 2 * z, True),
        (lambda z: 2 * z, False),  # only head.h5 has a checksum
        (lambda z: z[:-1], False),
        (lambda z: z.reshape(8, 18), True),
    ],
)
def test_other_heights_are_refused_and_the_right_ones_resume(comm, begun, change, checkpoint):
    z = random_heights((12, 12))
    z[0, 0] += 0.1
    assert begun(z, "run scene.toml -q")[0] == 143
    if comm.rank == 0 and not checkpoint:
        Path(PARTIAL, "checkpoint.h5").unlink()
    code, err = begun(change(z), RESTART)
    assert code == 2
    assert err.count("\n") == (comm.rank == 0)
    assert comm.rank or "other heights" in err
    assert_resumes(begun, z)


def assert_resumes(begun, z):
    """Resume the run and compare its gaps with those of an uninterrupted run."""
    words = "run scene.toml -q -o whole.h5 --set machine.wall_seconds=1000"
    assert begun(z, RESTART)[0] == begun(z, words)[0] == 0
    gaps = []
    for name in ("contact.h5", "whole.h5"):
        with h5py.File(name) as file:
            gaps.append([step.attrs["gap_mean"] for step in file["steps"].values()])
    assert gaps[0] == pytest.approx(gaps[1], rel=2e-3)


def test_the_gap_of_other_heights_does_no_harm(comm, begun):
    """It is only a start for the solver."""
    z = random_heights((12, 12))
    for heights, name in ((2 * z, "other.partial"), (z, PARTIAL)):
        assert begun(heights, "run scene.toml -q")[0] == 143
        if comm.rank == 0 and name != PARTIAL:
            shutil.move(PARTIAL, name)
    if comm.rank == 0:
        shutil.copy("other.partial/checkpoint.h5", PARTIAL)
    assert_resumes(begun, z)
