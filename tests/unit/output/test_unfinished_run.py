"""Runs that die or are disturbed: the file is complete or absent, and no finished load is lost."""

import fcntl

import numpy as np
import pytest
from refusal import refused
from result_files import FIELD, STEP, begin, complete, interrupted, names

from hpc_gfmd.output.folder import partial_folder
from hpc_gfmd.output.read import read_result
from hpc_gfmd.runs.simulation import restart
from hpc_gfmd.util.errors import GfmdError


def test_an_interrupted_run_can_be_read_and_resumed(path):
    with begin(path) as run:
        run.write_step(0, STEP, {"gap": FIELD})
        assert read_result(path).status == "running"
    result = read_result(path)
    assert (result.status, result.steps, result.indices) == ("interrupted", [STEP], [0])
    with begin(path) as run:
        assert list(run.finished) == [0]
        (note,) = run.notes
        assert all(words in note for words in ("resuming", "1 load "))
        run.write_step(1, STEP | {"p": 0.2}, {"gap": FIELD + 1})
        run.finish("converged")
    result = read_result(path)
    assert [step["p"] for step in result.steps] == [0.1, 0.2]
    assert np.array_equal(result.fields[1]["gap"].read(0, 6), FIELD + 1)


def contents(folder):
    return {file: file.read_bytes() for file in folder.glob("*.h5")}


@pytest.mark.parametrize(
    ("owner", "options"),
    [
        ("of another scene", {"identity": "other"}),
        ("of this scene", {"resume": False}),
        ("that cannot be read", {}),
    ],
)
def test_finished_loads_are_only_removed_with_force(path, owner, options):
    """Loads of another scene, of a scene whose result is saved from memory, and damaged loads."""
    folder = interrupted(path, 1)
    if not options:
        for file in folder.glob("*.h5"):
            file.write_bytes(b"lost")
    before = contents(folder)
    with refused(f"holds 1 finished loads {owner}, allowed: .* --force"):
        begin(path, **options)
    assert before == contents(folder)
    with begin(path, force=True, **options) as run:
        (note,) = run.notes
        assert all(words in note for words in ("removed", owner, "1 finished"))
        assert list(run.finished) == []


@pytest.mark.parametrize("left", ["step-0001.h5.tmp", "head.h5.tmp", "checkpoint.h5.tmp"])
def test_half_written_files_are_ignored(path, left):
    with begin(path) as run:
        run.write_step(0, STEP)
    (run.partial / left).write_bytes(b"half")
    path.with_name("out.h5.tmp").write_bytes(b"half")
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
    (partial_folder(path) / "step-0000.h5").write_bytes(b"")
    (partial_folder(path) / "lock").write_bytes(b"")
    with refused("is complete already"):
        restart(path)
    assert names(path.parent) == ["out.h5"]


def test_foreign_files_in_the_folder_are_kept(path):
    folder = partial_folder(path)
    folder.mkdir()
    (folder / "letter.txt").write_text("dear reader")
    complete(path, 1)
    assert names(folder) == ["letter.txt"]


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


def test_a_damaged_step_stops_the_final_assembly(path):
    run = begin(path)
    for index in range(2):
        run.write_step(index, STEP, {"gap": FIELD})
    step = run.partial / "step-0001.h5"
    whole = step.read_bytes()
    place = whole.index(FIELD.tobytes())
    for damaged, match in (
        (whole[:500], r"step-0001\.h5: Unable to .*truncated"),
        (
            whole[:place] + b"\1" + whole[place + 1 :],
            r"step-0001\.h5: the numbers of steps/0001/gap are damaged",
        ),
    ):
        step.write_bytes(damaged)
        with refused(match, GfmdError):
            run.finish("converged")
        assert not path.exists()
    step.write_bytes(whole)
    run.finish("converged")
    assert len(read_result(path).steps) == 2
