"""Disks that are full, read-only or gone: one line, a code that is not 0, and what was finished before is continued afterwards."""

import shutil
import subprocess
import time

import pytest
from faults.jobs import EIGHT, call, finish, needs_mpi, nothing_wrong, write_scene

from hpc_gfmd import simulation
from hpc_gfmd.cli import main
from hpc_gfmd.output.read import read_result
from hpc_gfmd.output.record import RunFile

ALL = '["gap", "pressure", "displacement"]'
FULL = {  # when: bytes of the disk, of the scene, what the message names
    "at start": (2**16, {}, "output.path: cannot write to|writing .*head.h5: No space left"),
    "during a checkpoint": (1300 * 1024, {}, r"checkpoint\.h5: No space left"),
    "during a field write": (1300 * 1024, {"checkpoint": 600, "fields": ALL}, r"step-0000\.h5: No space left"),
    "while the result is put together": (3400 * 1024, {"checkpoint": 600, "loads": EIGHT},
                                          r"out\.h5: No space left.*the finished steps are safe in"),
}
RANKS = [pytest.param(None, id="alone"), pytest.param(2, id="two ranks", marks=[pytest.mark.slow, needs_mpi])]


@pytest.mark.parametrize("ranks", RANKS)
@pytest.mark.parametrize("when", FULL)
def test_full(tmp_path, small_disk, undisturbed, record, when, ranks):
    size, how, message = FULL[when]
    wanted = undisturbed(ranks, **how)
    disk = tmp_path / "disk"
    disk.mkdir()
    small_disk(disk, size)
    path = write_scene(disk, **how)
    job = call(["run", "scene.toml", "-q"], ranks, disk)
    assert job.code in (1, 2)
    job.says(message)
    assert not path.exists()
    assert not list(disk.rglob("*.tmp"))
    subprocess.run(["mount", "-o", "remount,size=64m", disk], check=True)
    kept = nothing_wrong(path, wanted)
    finish(path, ranks)
    nothing_wrong(path, wanted)
    record(f"disk full {when}", f"tmpfs of {size // 1024} KiB, {ranks or 1} ranks; {kept} loads finished; made larger: restart "
           "finishes, bit-identical", job.code, job.one_line(), job.seconds)


@pytest.mark.parametrize("ranks", RANKS)
def test_read_only(tmp_path, small_disk, record, ranks):
    disk = tmp_path / "disk"
    disk.mkdir()
    small_disk(disk, "4m")
    write_scene(disk)
    subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
    job = call(["run", "scene.toml", "-q"], ranks, disk)
    assert job.code == 2
    job.says("output.path: cannot write to .*: Read-only file system")
    record("folder is read-only", f"read-only tmpfs, {ranks or 1} ranks", job.code, job.one_line(), job.seconds)


def in_the_middle(monkeypatch, happens):
    """Let it happen when the third load is about to be written."""
    def write_step(self, index, *args):
        if index == 2:
            happens()
        return before(self, index, *args)

    before = RunFile.write_step
    monkeypatch.setattr(simulation.RunFile, "write_step", write_step)


def test_read_only_in_the_middle(tmp_path, small_disk, record, monkeypatch, capfd):
    disk = tmp_path / "disk"
    disk.mkdir()
    path = write_scene(disk)
    monkeypatch.chdir(disk)

    def happens():
        small_disk(disk, "1m")
        subprocess.run(["mount", "-o", "remount,ro", disk], check=True)

    in_the_middle(monkeypatch, happens)
    begun = time.monotonic()
    assert main(["run", "scene.toml", "-q", "-o", str(path)]) == 1
    seconds = time.monotonic() - begun
    err = capfd.readouterr().err
    assert err.count("\n") == 1, err
    assert "step-0002.h5" in err
    subprocess.run(["umount", "-l", disk], check=True)
    monkeypatch.undo()
    assert len(read_result(path).steps) == 2
    finish(path)
    record("folder becomes read-only in the middle", "a read-only tmpfs mounted over it after two loads; unmounted: restart finishes",
           1, err, seconds)


@pytest.mark.parametrize("what", ["out.h5.partial", "."])
def test_folder_vanished(tmp_path, record, monkeypatch, capfd, what):
    folder = tmp_path / "folder"
    folder.mkdir()
    path = write_scene(folder)
    in_the_middle(monkeypatch, lambda: shutil.rmtree(folder / what))
    begun = time.monotonic()
    assert main(["run", str(folder / "scene.toml"), "-q", "-o", str(path)]) == 1
    seconds = time.monotonic() - begun
    err = capfd.readouterr().err
    assert err.count("\n") == 1, err
    assert "step-0002.h5: No such file or directory" in err
    assert not path.exists()
    record(f"{'the output folder' if what == '.' else what} vanished", "removed after two loads", 1, err, seconds,
           "what was removed")
