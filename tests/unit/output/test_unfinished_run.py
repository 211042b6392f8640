"""Runs that die or are disturbed: the file is complete or absent, and no finished load is lost."""

import fcntl
import shutil
from math import prod

import numpy as np
import pytest
from contacts import rough
from refusal import refused
from result_files import FIELD, STEP, begin, complete, interrupted, names

from hpc_gfmd.output.folder import partial_folder
from hpc_gfmd.output.read import read_result
from hpc_gfmd.parallel.committed import committed_file
from hpc_gfmd.parallel.h5 import SLACK
from hpc_gfmd.runs.simulation import restart, run_scene
from hpc_gfmd.scene import Scene


def test_an_interrupted_run_can_be_read_and_resumed(path):
    with begin(path) as run:
        run.update(height_field=-FIELD)
        run.write_step(0, STEP, {"gap": FIELD})
        assert read_result(path).status == "running"
    result = read_result(path)
    assert (result.status, result.steps, result.indices) == ("interrupted", [STEP], [0])
    with begin(path) as run:
        assert list(run.finished) == [0]
        (note,) = run.notes
        assert all(words in note for words in ("resuming", "1 load "))
        run.update(height_field=-FIELD)
        run.write_step(1, STEP | {"p": 0.2}, {"gap": FIELD + 1})
        run.finish("converged")
    result = read_result(path)
    assert [step["p"] for step in result.steps] == [0.1, 0.2]
    assert np.array_equal(result.fields[1]["gap"].read(0, 6), FIELD + 1)
    assert np.array_equal(result.fields[1]["heights"].read(), -FIELD)


def contents(folder):
    return {file: file.read_bytes() for file in folder.glob("*.h5")}


@pytest.mark.parametrize(
    ("owner", "options"),
    [
        ("1 finished loads of another scene", {"identity": "other"}),
        ("1 finished loads of this scene", {"resume": False}),
        ("an interrupted run that cannot be read", {}),
    ],
)
def test_finished_loads_are_only_removed_with_force(path, owner, options):
    """Loads of another scene, of a scene whose result is saved from memory, and damaged loads."""
    folder = interrupted(path, 1)
    if not options:
        for file in folder.glob("*.h5*"):
            file.write_bytes(b"lost")
    before = contents(folder)
    with refused(f"holds {owner}, allowed: .* --force"):
        begin(path, **options)
    assert before == contents(folder)
    with begin(path, force=True, **options) as run:
        (note,) = run.notes
        assert all(words in note for words in ("removed", owner))
        assert list(run.finished) == []


@pytest.mark.parametrize("left", ["result.h5.committed.tmp", "checkpoint.h5.tmp"])
def test_half_written_files_are_ignored(path, left):
    with begin(path) as run:
        run.write_step(0, STEP)
    (run.partial / left).write_bytes(b"half")
    assert read_result(path).steps == [STEP]
    with begin(path) as run:
        assert list(run.finished) == [0]
        run.finish("converged")
    assert names(path.parent) == ["out.h5"]


def test_death_between_rename_and_clean_up(path):
    complete(path, 1)
    whole = path.read_bytes()
    with begin(path) as run:
        run.write_step(0, STEP | {"p": 9.0})
    assert path.read_bytes() == whole
    assert read_result(path).steps == [STEP]
    with begin(path) as run:
        run.finish("converged")
    assert read_result(path).steps[0]["p"] == 9.0


def test_death_during_clean_up(path):
    """A restart reports that the file is complete and removes the remaining folder."""
    complete(path, 1)
    partial_folder(path).mkdir()
    (partial_folder(path) / "result.h5.committed").write_bytes(b"")
    (partial_folder(path) / "lock").write_bytes(b"")
    with refused("is complete already"):
        restart(path)
    assert names(path.parent) == ["out.h5"]


def test_file_systems_without_locks_are_accepted(path, monkeypatch):
    def flock(*_):
        raise OSError(38, "Function not implemented")

    monkeypatch.setattr(fcntl, "flock", flock)
    complete(path, 1)
    assert read_result(path).steps == [STEP]


def test_unwritable_output_is_refused_at_once(tmp_path):
    """Read-only disks are in tests/faults/test_disk.py."""
    with refused("is a folder"):
        begin(tmp_path)
    (tmp_path / "taken.h5.partial").write_text("")
    with refused(r"cannot write to .*File exists"):
        begin(tmp_path / "taken.h5")


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("last", ["write_step", "finish"])
def test_what_is_cut_short_leaves_the_finished_loads(path, monkeypatch, last, compressed):
    """Every byte that is not committed may be anything, and the file of any length."""
    interrupted(path, 2, compressed=compressed)
    monkeypatch.setattr("hpc_gfmd.output.record.recover", lambda _: None)  # as if killed

    def killed(*_):
        raise KeyboardInterrupt

    run = begin(path, compressed=compressed).__enter__()
    committed = committed_file(run.growing).read_bytes()
    for name in ("commit", "sync"):
        monkeypatch.setattr(f"hpc_gfmd.output.record.{name}", killed)
    arguments = ("converged",) if last == "finish" else (2, STEP, {"gap": FIELD + 2})
    with pytest.raises(KeyboardInterrupt):
        getattr(run, last)(*arguments)
    run.close()
    monkeypatch.undo()
    assert committed_file(run.growing).read_bytes() == committed
    assert not path.exists()
    with open(run.growing, "r+b") as file:
        file.write(b"\xaa" * 96)  # where HDF5 says how large the file is
    for _ in range(2):
        partial = read_result(path)
        assert (partial.status, partial.indices) == ("interrupted", [0, 1])
        for index, fields in enumerate(partial.fields):
            assert np.array_equal(fields["gap"].read(), FIELD + index)
    with begin(path, compressed=compressed) as run:
        run.write_step(2, STEP, {"gap": FIELD + 2})
        run.finish("converged")
    result = read_result(path)
    assert result.indices == [0, 1, 2]
    assert np.array_equal(result.fields[2]["gap"].read(), FIELD + 2)
    assert names(path.parent) == ["out.h5"]


def leave(free, monkeypatch):
    """Make disks seem to have `free` bytes left."""
    usage = shutil.disk_usage(".")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=free))


def test_a_disk_that_is_too_small_is_refused(path, monkeypatch):
    leave(SLACK + 5 * 30 * 4, monkeypatch)
    with begin(path) as run:
        run.require_space(3, 3 * [np.float32] + [np.float64])
        with refused(r"output\.fields: .* needed for 4 loads"):
            run.require_space(4, 4 * [np.float32] + [np.float64])


@pytest.mark.parametrize(
    ("load", "size"), [({"p_star": [0.1, 0.2]}, 4), ({"gap_over_h_rms": [1, 0.5]}, 8)]
)
def test_the_disk_must_hold_what_a_load_in_double_precision_writes(load, size, path, monkeypatch):
    """A load may need it, with "auto", unless it is known beforehand that it does not."""
    tables = {"surface": rough(), "load": load, "solver": {"accuracy": 0.02}}
    output = {"path": str(path), "fields": ["gap"]}
    scene = Scene.from_dict(tables | {"output": output})
    needed = SLACK + 2 * prod(scene.surface.n) * size
    leave(needed - 1, monkeypatch)
    with refused(r"output\.fields: .* needed for 2 loads"):
        run_scene(scene, quiet=True)
    leave(needed, monkeypatch)
    assert run_scene(scene, quiet=True).status == "converged"
