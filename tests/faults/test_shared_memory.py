"""If MPI-IO cannot open a file, rank 0 writes for all with a note, and the result is the same."""

import os
import shutil

import pytest
from faults.jobs import needs_mpi, run, write_scene
from result_files import assert_same_steps

from hpc_gfmd.output.read import read_result
from hpc_gfmd.parallel.committed import reading

pytestmark = needs_mpi
RANKS = 2
# what the processes of the job see as /dev/shm
PLACES = {
    "full": "size=64k tmpfs /dev/shm; head -c 64k /dev/zero >/dev/shm/full",
    "read-only": "ro tmpfs /dev/shm",
}


def is_written_by_rank_0(path):
    with reading(path) as file:
        return file.attrs["io"] == "serial"


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES)
def test_without_shared_memory(place, undisturbed):
    """As in containers, where Open MPI cannot open files but MPICH can."""
    if os.getuid() != 0 or not shutil.which("unshare"):
        pytest.skip("only root can mount another /dev/shm")
    script = f'mount -t tmpfs -o {PLACES[place]}; exec "$@"'
    path = write_scene()
    job = run(
        "run scene.toml",
        RANKS,
        wrapped=["unshare", "-m", "--propagation", "private", "bash", "-c", script, "-"],
    )
    assert job.code == 0, job.err
    assert_same_steps(read_result(path), undisturbed(RANKS))
    if is_written_by_rank_0(path):
        assert "MPI-IO" in job.out


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ufs:out.h5", "2026-01-01T12:30:00.h5"])
def test_a_colon_in_the_path(name, undisturbed, tmp_path):
    """ROMIO takes the text before it as the type of a file system and would write another file."""
    write_scene()
    job = run(f"run scene.toml -o {name}", RANKS)
    assert job.code == 0, job.err
    assert is_written_by_rank_0(tmp_path / name)
    assert "MPI-IO" in job.out
    assert_same_steps(read_result(tmp_path / name), undisturbed(RANKS))
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([name, "scene.toml"])
