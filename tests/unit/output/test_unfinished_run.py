"""A run that dies, is disturbed or meets another one: its file is complete or not there, and
nothing finished is lost."""

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
        assert run.notes == ["resuming an interrupted run: 1 load is finished"]
        run.write_step(1, STEP | {"p": 0.2}, {"gap": FIELD + 1})
        run.finish("converged")
    result = read_result(path)
    assert [step["p"] for step in result.steps] == [0.1, 0.2]
    assert np.array_equal(result.fields[1]["gap"].read(0, 6), FIELD + 1)


def contents(folder):
    return {file: file.read_bytes() for file in folder.glob("*.h5")}


@pytest.mark.parametrize(
    ("whose", "how"),
    [
        ("of another scene", {"identity": "other"}),
        ("of this scene", {"resume": False}),
        ("that cannot be read", {}),
    ],
)
def test_finished_loads_are_not_removed_unasked(path, whose, how):
    """Those of another scene, by a whole result in memory, damaged ones."""
    folder = interrupted(path, 1)
    if not how:
        for file in folder.glob("*.h5"):
            file.write_bytes(b"lost")
    before = contents(folder)
    with refused(f"holds 1 finished loads {whose}, allowed: .* --force"):
        begin(path, **how)
    assert before == contents(folder)
    with begin(path, force=True, **how) as run:
        assert run.notes == [f"removed an interrupted run {whose} (1 finished loads)"]
        assert list(run.finished) == []


@pytest.mark.parametrize("left", ["step-0001.h5.tmp", "head.h5.tmp", "checkpoint.h5.tmp"])
def test_dying_while_writing_leaves_nothing_readable(path, left):
    with begin(path) as run:
        run.write_step(0, STEP)
    (run.partial / left).write_bytes(b"half")
    path.with_name("out.h5.tmp").write_bytes(b"half")
    assert read_result(path).steps == [STEP]
    with begin(path) as run:
        assert list(run.finished) == [0]
        run.finish("converged")
    assert names(path.parent) == ["out.h5"]


def test_dying_between_the_rename_and_the_clean_up(path):
    complete(path, 1)
    whole = path.read_bytes()
    with begin(path) as run:
        run.write_step(0, STEP | {"p": 9.0})
    assert path.read_bytes() == whole
    assert read_result(path).steps == [STEP]
    with begin(path) as run:
        run.finish("converged")
    assert read_result(path).steps[0]["p"] == 9.0


def test_dying_during_the_clean_up(path):
    """A restart says that the file is complete, and removes the rest of the folder."""
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


def test_output_that_cannot_be_written_is_refused_at_once(tmp_path):
    """Nor on a disk that is read-only: tests/faults/test_disk.py."""
    with refused("is a folder"):
        begin(tmp_path)
    (tmp_path / "taken.h5.partial").write_text("")
    with refused(r"cannot write to .*File exists"):
        begin(tmp_path / "taken.h5")


def test_a_step_that_is_damaged_before_the_end_is_never_left_out(path):
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
