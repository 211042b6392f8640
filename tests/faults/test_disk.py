"""Disks that are full, read-only or gone: one line, a code that is not 0, and what was finished
before is continued afterwards."""

import subprocess
from pathlib import Path

import pytest
from faults.jobs import call, goes_on, needs_mpi, run, write_scene
from result_files import names

SEVERAL = pytest.param(2, id="two ranks", marks=[pytest.mark.slow, needs_mpi])
FIELDS = {"fields": ["gap", "pressure", "displacement"]}
FULL = {  # when: KiB of the disk, of the scene, fault, what the message names
    "at start": (4, {}, None, "output.path: cannot write to|writing .*head.h5: No space left"),
    "during a field write": (300, FIELDS, None, r"step-0000\.h5: No space"),
    # where the space could not be reserved: HDF5 and MPI meet the full disk, on several ranks in a
    # collective write
    "in the middle of a write": (
        300,
        FIELDS,
        "unreserved -1",
        r"writing .*step-0000\.h5: (No space left on device|.*write failed)",
    ),
    "while the result is put together": (
        1568,
        {},
        None,
        r"out\.h5: No space left.*the finished steps are safe in",
    ),
}


@pytest.mark.parametrize(
    ("when", "ranks"),
    [
        pytest.param(when, ranks, id=f"{when}-{ranks or 'alone'}", marks=marks)
        for when in FULL
        for ranks, marks in (
            (None, ()),
            (2, [needs_mpi, *[pytest.mark.slow] * (when != "during a field write")]),
        )
    ],
)
def test_full(small_disk, undisturbed, when, ranks):
    """No result, nothing half-written; with more space all goes on."""
    size, how, fault, message = FULL[when]
    to_the_end = when == "while the result is put together"
    disk = small_disk(size * 1024)
    path = write_scene(disk, **how)
    asked = "run scene.toml -q", ranks, disk
    # this process may know plans of other tests
    job = run(*asked, fault=fault) if fault or to_the_end else call(*asked)
    assert job.code == 1 or (job.code, when) == (2, "at start"), job.err
    job.says(message)
    assert not path.exists()
    assert not list(disk.rglob("*.tmp"))
    subprocess.run(["mount", "-o", "remount,size=64m", disk], check=True)
    goes_on(path, undisturbed(ranks, **how), ranks)


def test_export(small_disk, undisturbed):
    disk = small_disk("4k")
    job = call(f"export {undisturbed(None, **FIELDS).path} --to netcdf -o {disk}/x")
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


@pytest.mark.parametrize("ranks", [None, SEVERAL])
@pytest.mark.parametrize("what", ["folder/out.h5.partial", "folder"])
def test_folder_vanished(what, ranks):
    """When the third load is about to be written; nothing can be left then, but nothing hangs."""
    Path("folder").mkdir()
    path = write_scene(Path("folder"))
    words = f"run {path.parent}/scene.toml -q -o {path}"
    job = run(words, ranks, fault=f"vanish 0 {what}")
    assert job.code == 1
    job.says(r"step-0002\.h5: No such file or directory")
    assert not path.exists()
