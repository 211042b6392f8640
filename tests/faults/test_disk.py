"""Full, read-only or missing disks: one line, a nonzero exit code, and a restart afterwards."""

import subprocess
from pathlib import Path

import pytest
from faults.jobs import assert_resumes, call, needs_mpi, run, write_scene
from result_files import names

SEVERAL = pytest.param(2, id="two ranks", marks=[pytest.mark.slow, needs_mpi])
FIELDS = {"fields": ["gap", "pressure", "displacement"]}
FULL = {  # when: (KiB of the disk, arguments of write_scene, fault, words of the message)
    "at start": (4, {}, None, "output.path: cannot write to|writing .*head.h5: No space left"),
    "during a field write": (300, FIELDS, None, r"step-0000\.h5: No space"),
    # if the space cannot be reserved, HDF5 and MPI meet the full disk, on several ranks in a
    # collective write
    "in the middle of a write": (
        300,
        FIELDS,
        "unreserved -1",
        r"writing .*step-0000\.h5: (No space left on device|.*write failed)",
    ),
    "while the result is assembled": (
        1568,
        {},
        None,
        r"out\.h5: No space left.*the finished steps are safe in",
    ),
}


@pytest.mark.parametrize(
    ("when", "ranks"),
    [
        pytest.param("at start", None, marks=pytest.mark.quick),
        pytest.param("during a field write", 2, marks=[needs_mpi, pytest.mark.quick]),
        *[pytest.param(when, None) for when in FULL if when != "at start"],
        *[
            pytest.param(when, 2, marks=needs_mpi)
            for when in FULL
            if when != "during a field write"
        ],
    ],
)
def test_full(small_disk, undisturbed, when, ranks):
    """No result and no partial files are left; with more space the run resumes."""
    size, settings, fault, message = FULL[when]
    at_the_end = when == "while the result is assembled"
    disk = small_disk(size * 1024)
    path = write_scene(disk, **settings)
    command = "run scene.toml -q", ranks, disk
    # In a new process at the end, because this one may have FFTW plans of other tests.
    job = run(*command, fault=fault) if fault or at_the_end else call(*command)
    assert job.code == 1 or (job.code, when) == (2, "at start"), job.err
    job.says(message)
    assert not path.exists()
    assert not list(disk.rglob("*.tmp"))
    subprocess.run(["mount", "-o", "remount,size=64m", disk], check=True)
    assert_resumes(path, undisturbed(ranks, **settings), ranks)


@pytest.mark.slow
def test_export(small_disk, undisturbed):
    disk = small_disk("4k")
    job = call(f"export {undisturbed(None, **FIELDS).path} --to gwy -o {disk}/x")
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


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [None, SEVERAL])
@pytest.mark.parametrize("folder", ["folder/out.h5.partial", "folder"])
def test_folder_vanished(folder, ranks):
    """It vanishes when the third load is about to be written: the run ends and does not hang."""
    Path("folder").mkdir()
    path = write_scene(Path("folder"))
    words = f"run {path.parent}/scene.toml -q -o {path}"
    job = run(words, ranks, fault=f"vanish 0 {folder}")
    assert job.code == 1
    job.says(r"step-0002\.h5: No such file or directory")
    assert not path.exists()
