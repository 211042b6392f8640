"""Full, read-only or missing disks: one line, a nonzero exit code, and a restart afterwards."""

import subprocess

import pytest
from faults.jobs import assert_resumes, call, needs_mpi, run, write_scene
from result_files import names

SEVERAL = pytest.param(2, id="two ranks", marks=[pytest.mark.slow, needs_mpi])
FULL = {  # when: (KiB of the disk, arguments of write_scene, fault, words of the message)
    "at start": (4, {}, None, r"output.path: cannot write to|writing .*out\.h5: No space left"),
    "before the first load": (300, {}, None, "output.fields: .* needed for 5 loads"),
    "during a field write": (300, {}, "unforeseen -1", r"writing .*out\.h5: No space.*needed"),
    # if the space cannot be reserved, HDF5 and MPI meet the full disk
    "in the middle of a write": (300, {}, "unreserved -1", r"writing .*out\.h5: "),
}


@pytest.mark.parametrize(
    ("when", "ranks"),
    [
        pytest.param("at start", None, marks=pytest.mark.quick),
        pytest.param("during a field write", None, marks=pytest.mark.quick),
        *[pytest.param(when, 2, marks=needs_mpi) for when in FULL],
        pytest.param("before the first load", None),
        pytest.param("in the middle of a write", None),
    ],
)
def test_full(small_disk, undisturbed, when, ranks):
    """No result and no partial files are left; with more space the run resumes."""
    size, settings, fault, message = FULL[when]
    disk = small_disk(size * 1024)
    path = write_scene(disk, **settings)
    command = "run scene.toml -q", ranks, disk
    job = run(*command, fault=fault) if fault else call(*command)
    assert job.code == 1 or (job.code == 2 and when in ("at start", "before the first load"))
    job.says(message)
    assert not path.exists()
    assert not list(disk.rglob("*.tmp"))
    subprocess.run(["mount", "-o", "remount,size=64m", disk], check=True)
    assert_resumes(path, undisturbed(ranks, **settings), ranks)


@pytest.mark.slow
def test_export(small_disk, undisturbed):
    disk = small_disk("4k")
    job = call(f"export {undisturbed(None).path} --to gwy -o {disk}/x")
    assert job.code == 1
    job.says("No space left on device")
    assert not names(disk)


@pytest.mark.parametrize("ranks", [None, SEVERAL])
def test_read_only(small_disk, ranks):
    disk = small_disk("4m")
    write_scene(disk)
    subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
    job = call("run scene.toml -q", ranks, disk)
    assert job.code == 2
    job.says("output.path: cannot write to .*: Read-only file system")
