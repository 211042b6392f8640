"""The result file on one process: complete or not there, whatever dies; unreadable files are refused."""

import fcntl
import json
import os
import signal
import subprocess
import sys
from argparse import Namespace

import h5py
import numpy as np
import pytest

from hpc_gfmd.commands import show
from hpc_gfmd.errors import GfmdError, SceneError
from hpc_gfmd.output.folder import partial_folder
from hpc_gfmd.output.read import FORMAT_VERSION, read_partial, read_result
from hpc_gfmd.output.record import RunFile
from hpc_gfmd.output.table import table, with_error
from hpc_gfmd.parallel import h5
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.simulation import restart

N = (6, 5)
HEAD = {"scene": "title = 'x'", "identity": "abc", "versions": {"numpy": "2"}, "setup_seconds": 0.1}
SURFACE = {"n": list(N), "physical_sizes": [1.0, 2.0], "h_rms": 0.5, "g_rms": 1.0}
STEP = {"p": 0.1, "p_star": 0.1, "a_r": 0.25, "a_r_error": 1e-3, "iterations": 7, "status": "converged"}
FIELD = np.arange(30.0).reshape(N)


def begin(path, **how):
    return RunFile(SerialComm(), path, N, (0, N[0]), HEAD, SURFACE, **how)


def complete(path, **how):
    with begin(path, **how) as run:
        run.write_step(0, STEP, {"gap": FIELD})
        run.finish("converged")
    return path


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture
def path(tmp_path):
    return tmp_path / "out.h5"


def test_a_finished_file_holds_everything(path):
    complete(path)
    result = read_result(path)
    assert (result.status, result.scene_toml, result.head["versions"]) == ("converged", "title = 'x'", '{"numpy": "2"}')
    assert result.surface == SURFACE
    assert result.steps == [STEP]
    assert result.head["format"] == "hpc-gfmd"
    assert result.head["start_time"] <= result.head["end_time"]
    assert np.array_equal(result.fields[0]["gap"].read(2, 4), FIELD[2:4])
    assert names(path.parent) == ["out.h5"]


def test_the_layout_is_the_documented_one(path):
    complete(path)
    with h5py.File(path) as file:
        assert file.attrs["format_version"] == FORMAT_VERSION
        assert list(file["steps"]) == ["0000"]
        assert file["steps/0000"].attrs["a_r"] == 0.25
        assert file["steps/0000/gap"].shape == N
        assert list(file["surface"].attrs["n"]) == list(N)


@pytest.mark.parametrize(("dtype", "compressed"), [(None, True), ("single", False), ("single", True)])
def test_down_conversion_and_compression(path, dtype, compressed):
    complete(path, dtype=dtype, compressed=compressed)
    stored = read_result(path).fields[0]["gap"]
    assert stored.dtype == np.dtype(dtype or "double")
    with h5py.File(path) as file:
        assert (file[stored.dataset].compression == "gzip") == compressed
    assert np.array_equal(stored.read(0, N[0]), FIELD)


def test_attributes_of_all_kinds_survive(path):
    step = {"p": 1, "flag": True, "text": "mu \u03bc", "list": [1.0, 2.0], "nothing": None, "nan": float("nan"),
            "numpy": np.float32(0.5), "words": ["a", "b"]}
    with begin(path) as run:
        run.write_step(0, step)
        run.finish("x")
    (found,) = read_result(path).steps
    assert np.isnan(found.pop("nan"))
    assert found == {"p": 1, "flag": True, "text": "mu \u03bc", "list": [1.0, 2.0], "numpy": 0.5, "words": ["a", "b"]}
    assert type(found["flag"]) is bool


def test_an_interrupted_run_can_be_read_and_resumed(path):
    with begin(path) as run:
        run.write_step(0, STEP, {"gap": FIELD})
        assert read_result(path).status == "running"
    result = read_result(path)
    assert (result.status, result.steps, result.indices) == ("interrupted", [STEP], [0])
    with begin(path, resume=True) as run:
        assert run.finished == [0]
        assert "1 finished" in run.notes[0]
        run.write_step(1, STEP | {"p": 0.2}, {"gap": FIELD + 1})
        run.finish("converged")
    result = read_result(path)
    assert [step["p"] for step in result.steps] == [0.1, 0.2]
    assert np.array_equal(result.fields[1]["gap"].read(0, 6), FIELD + 1)


def test_a_fresh_run_removes_what_was_left_and_says_so(path):
    with begin(path) as run:
        run.write_step(0, STEP)
    with begin(path) as run:
        assert run.finished == []
        assert "removed an interrupted run of the same scene (1 files of load steps" in run.notes[0]


def test_resuming_needs_the_same_scene(path):
    begin(path).close()
    with pytest.raises(SceneError, match="another scene"):
        RunFile(SerialComm(), path, N, (0, 6), HEAD | {"identity": "z"}, SURFACE, resume=True)
    assert read_partial(path).status == "interrupted"


def test_steps_that_were_damaged_count_as_not_done(path):
    with begin(path) as run:
        for index in range(2):
            run.write_step(index, STEP)
    step = run.partial / "step-0001.h5"
    step.write_bytes(step.read_bytes()[:500])
    with begin(path, resume=True) as run:
        assert run.finished == [0]


@pytest.mark.parametrize("left", ["step-0001.h5.tmp", "head.h5.tmp", "checkpoint.h5.tmp"])
def test_dying_while_writing_leaves_nothing_readable(path, left):
    with begin(path) as run:
        run.write_step(0, STEP)
    (run.partial / left).write_bytes(b"half")
    path.with_name("out.h5.tmp").write_bytes(b"half")
    assert read_result(path).steps == [STEP]
    with begin(path, resume=True) as run:
        assert run.finished == [0]
        run.finish("converged")
    assert names(path.parent) == ["out.h5"]


def test_dying_before_the_head_was_written(path):
    partial_folder(path).mkdir()
    (partial_folder(path) / "head.h5.tmp").write_bytes(b"")
    with pytest.raises(SceneError, match="no such file, and no interrupted run"):
        read_result(path)
    with begin(path, resume=True) as run:
        assert run.finished == []


def test_dying_between_the_rename_and_the_clean_up(path):
    complete(path)
    whole = path.read_bytes()
    with begin(path) as run:
        run.write_step(0, STEP | {"p": 9.0})
    assert path.read_bytes() == whole
    assert read_result(path).steps == [STEP]
    with begin(path, resume=True) as run:
        run.finish("converged")
    assert read_result(path).steps[0]["p"] == 9.0


def test_dying_during_the_clean_up(path):
    """A restart says that the file is complete, and removes the rest of the folder."""
    complete(path)
    partial_folder(path).mkdir()
    (partial_folder(path) / "step-0000.h5").write_bytes(b"")
    (partial_folder(path) / "lock").write_bytes(b"")
    with pytest.raises(SceneError, match="is complete already"):
        restart(path)
    assert names(path.parent) == ["out.h5"]


def test_foreign_files_in_the_folder_are_kept(path):
    folder = partial_folder(path)
    folder.mkdir()
    (folder / "letter.txt").write_text("dear reader")
    complete(path)
    assert names(folder) == ["letter.txt"]


def test_two_runs_cannot_write_the_same_file(path):
    with begin(path), pytest.raises(SceneError, match=r"out\.h5: another run is writing this file \(process \d+ on"):
        begin(path)
    begin(path).close()


def test_a_killed_run_gives_the_lock_back(path):
    code = (
        "import sys, time; from hpc_gfmd.output.record import RunFile; "
        "from hpc_gfmd.parallel.comm import SerialComm; "
        f"run = RunFile(SerialComm(), {str(path)!r}, (2, 2), (0, 2), {{'identity': 'abc'}}, {{}}); "
        "run.write_step(0, {'status': 'converged'}); print('ready', flush=True); time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE) as child:
        assert child.stdout.readline() == b"ready\n"
        with pytest.raises(SceneError, match=f"process {child.pid} on"):
            begin(path)
        child.send_signal(signal.SIGKILL)
    assert read_result(path).status == "interrupted"
    with begin(path, resume=True) as run:
        assert run.finished == [0]


def test_file_systems_without_locks_are_accepted(path, monkeypatch):
    def flock(*_):
        raise OSError(38, "Function not implemented")

    monkeypatch.setattr(fcntl, "flock", flock)
    complete(path)
    assert read_result(path).steps == [STEP]


def test_output_that_cannot_be_written_is_refused_at_once(tmp_path, monkeypatch):
    with pytest.raises(SceneError, match=r"output\.path: the folder .*missing does not exist"):
        begin(tmp_path / "missing" / "out.h5")
    with pytest.raises(SceneError, match="is a folder"):
        begin(tmp_path)
    (tmp_path / "taken.h5.partial").write_text("")
    with pytest.raises(SceneError, match=r"cannot write to .*File exists"):
        begin(tmp_path / "taken.h5")

    def mkdir(*_, **__):
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr(type(tmp_path), "mkdir", mkdir)
    with pytest.raises(SceneError, match=r"cannot write to .*: Read-only file system"):
        begin(tmp_path / "out.h5")


def test_a_full_disk_keeps_what_is_there(path, monkeypatch):
    complete(path)
    whole = path.read_bytes()
    run = begin(path)
    run.write_step(0, STEP, {"gap": FIELD})

    def posix_fallocate(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "posix_fallocate", posix_fallocate)
    with pytest.raises(GfmdError, match=r"step-0001\.h5: No space left on device"):
        run.write_step(1, STEP, {"gap": FIELD})
    with pytest.raises(GfmdError, match=r"No space left on device .*; the finished steps are safe in"):
        run.finish("converged")
    run.close()
    assert path.read_bytes() == whole
    assert names(path.parent) == ["out.h5", "out.h5.partial"]
    assert read_partial(path).indices == [0]


def test_a_step_that_is_damaged_before_the_end_is_never_left_out(path):
    run = begin(path)
    for index in range(2):
        run.write_step(index, STEP, {"gap": FIELD})
    step = run.partial / "step-0001.h5"
    whole = step.read_bytes()
    place = whole.index(FIELD.tobytes())
    for damaged, match in ((whole[:500], "load steps 1 have been damaged"),
                           (whole[:place] + b"\1" + whole[place + 1 :], r"step-0001\.h5: the numbers of steps/0001/gap are damaged")):
        step.write_bytes(damaged)
        with pytest.raises(GfmdError, match=match):
            run.finish("converged")
        assert not path.exists()
    step.write_bytes(whole)
    run.finish("converged")
    assert len(read_result(path).steps) == 2


def test_fields_of_the_wrong_shape_are_refused(path):
    with begin(path) as run, pytest.raises(GfmdError, match=r"step-0000\.h5: \(5, 6\) points in rows 0:6 of \(6, 5\)"):
        run.write_step(0, STEP, {"gap": FIELD.T})


def refused(path, match):
    with pytest.raises(SceneError, match=match) as caught:
        read_result(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def test_what_is_no_result_is_refused(tmp_path, path):
    refused(path, "no such file")
    refused(tmp_path, "is a folder")
    path.write_text("hello")
    refused(path, "not an HDF5 file")
    path.write_bytes(b"")
    refused(path, "not an HDF5 file")
    with h5py.File(path, "w") as file:
        file["x"] = 1
    refused(path, "not a result of hpc-gfmd")


def test_newer_versions_are_refused(path):
    complete(path)
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = FORMAT_VERSION + 1
    refused(path, f"format_version is {FORMAT_VERSION + 1}, this program reads {FORMAT_VERSION}")


def test_one_wrong_number_is_noticed(path):
    whole = complete(path).read_bytes()
    a_r = np.float64(0.25).tobytes()
    assert whole.count(a_r) == 1
    path.write_bytes(whole.replace(a_r, np.float64(0.26).tobytes()))
    refused(path, "damaged")


def test_copies_made_by_h5py_are_read(path, tmp_path):
    complete(path)
    copy = tmp_path / "copy.h5"
    with h5py.File(path) as old, h5py.File(copy, "w") as new:
        new.attrs.update(old.attrs)
        old.copy("surface", new)
        old.copy("steps", new)
    assert read_result(copy).steps == [STEP]


def test_files_without_a_surface_are_damaged(path):
    complete(path)
    with h5py.File(path, "r+") as file:
        del file["surface"]
    refused(path, "damaged")


def test_truncated_files_are_refused(path):
    whole = complete(path).read_bytes()
    for size in (9, 511, 512, 600, 2000, len(whole) - 1):
        path.write_bytes(whole[:size])
        refused(path, "damaged|not an HDF5 file")


def test_garbled_files_are_refused(path):
    """Where that is not in what nobody reads (coordinates, texts for other programs)."""
    whole, refusals = complete(path).read_bytes(), 0
    random = np.random.default_rng(0)
    for place in range(50, len(whole) - 100, 97):
        garbled = bytearray(whole)
        garbled[place : place + 100] = random.bytes(100)
        path.write_bytes(garbled)
        try:
            said = read_result(path).steps
        except SceneError as error:
            said, refusals = str(error), refusals + 1
        assert said == [STEP] or "damaged" in said or "not a result" in said
        assert "\n" not in said
    assert refusals > 10


def test_write_file_leaves_no_trace_of_a_failure(tmp_path):
    target = tmp_path / "state.h5"
    h5.write_file(SerialComm(), target, N, (0, N[0]), {"u": FIELD}, lambda file: file.attrs.update(dt=1.0))
    with pytest.raises(GfmdError):
        h5.write_file(SerialComm(), target, N, (0, N[0]), {}, lambda file: file.attrs.update(dt=object()))
    with h5py.File(target) as file:
        assert file.attrs["dt"] == 1.0
    assert names(tmp_path) == ["state.h5"]


def test_table_marks_what_did_not_converge():
    text = table([STEP, STEP | {"status": "stagnated", "note": "fewer than 100 points touch"}])
    header, units, first, second, *remarks = text.splitlines()
    assert header.split() == ["step", "p*", "p", "a_r", "iter.", "status"]
    assert "[unit of E*]" in units
    assert first.split() == ["0", "0.1", "0.1", "25.00", "+-", "0.03", "7", "converged"]
    assert second.split()[:2] == ["!", "1"]
    assert remarks == [
        "! step 1: NOT CONVERGED (stagnated), less accurate than asked",
        "  step 1: fewer than 100 points touch",
    ]


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.016049, 1.2e-3, "0.01605 +- 0.00002"),
        (3.2e-5, 1e-2, "(3.20 +- 0.03)e-05"),
        (2.27, None, "2.27"),
        (2.27, float("nan"), "2.27 +- ?"),
        (0.0, 1e-3, "0"),
        (1.0, 0.0, "1 +- 0"),
        (float("nan"), 1e-3, "nan"),
        (0.5, 3.0, "0.5 +- 1.5"),
        (0.016049, 1e-9, "0.0160490 +- 2e-11"),
    ],
)
def test_numbers_have_as_many_digits_as_they_deserve(value, error, text):
    assert with_error(value, error) == text


def test_show_prints_table_and_json(path, capsys):
    with begin(path) as run:
        run.write_step(0, STEP | {"gap_mean": float("inf"), "status": "max_iterations"})
        run.finish("max_iterations")
    assert show.main(Namespace(file=str(path), json=False, tfc=None)) == 0
    text = capsys.readouterr().out
    assert "6 x 5 points, L = 1 x 2, h_rms = 0.5" in text
    assert "NOT CONVERGED (max_iterations)" in text
    assert show.main(Namespace(file=str(path), json=True, tfc=None)) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found) == {"surface", "steps", "status"}
    assert found["steps"][0]["gap_mean"] is None
    assert found["surface"] == SURFACE


def test_show_tells_an_interrupted_run(path, capsys):
    begin(path).close()
    show.main(Namespace(file=str(path), json=False, tfc=None))
    text = capsys.readouterr().out
    assert "interrupted" in text
    assert "no finished load step yet" in text


def test_reading_starts_neither_mpi_nor_numba(path):
    complete(path)
    code = (
        "import sys; from hpc_gfmd.cli import main; "
        f"assert main(['show', {str(path)!r}]) == main(['plot', {str(path)!r}]) == 0; "
        "assert not {'mpi4py', 'numba'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)
