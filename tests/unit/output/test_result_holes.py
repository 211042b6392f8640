"""Files in wrong places, damaged ones beside sound ones, and results that stand in the way: nothing
finished is lost without a word."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from refusal import refused
from result_files import FIELD, UNFINISHED, N, begin, complete, interrupted, names

from hpc_gfmd.output.folder import partial_folder
from hpc_gfmd.output.read import read_partial, read_result
from hpc_gfmd.parallel.comm import SerialComm

GRID = type("Grid", (), {"n": N, "rows": (0, N[0]), "comm": SerialComm()})


def flipped(file, bit):
    """Write a file again and again, each time with this bit of another of its bytes flipped."""
    whole = file.read_bytes()
    for place in range(bit, len(whole), 41):
        file.write_bytes(whole[:place] + bytes([whole[place] ^ 1 << bit]) + whole[place + 1 :])
        yield


@pytest.mark.parametrize("bit", [0, 3])
def test_any_flipped_bit_of_the_head_loses_no_load(path, bit):
    """Wherever it is: the steps say themselves what they belong to."""
    head = interrupted(path) / "head.h5"
    for _ in flipped(head, bit):
        found = read_partial(path)
        assert found.indices == [0, 1, 2]
        assert found.head["identity"] == "abc"
    head.write_bytes(b"nothing of this")
    with begin(path) as run:
        assert list(run.finished) == [0, 1, 2]
        assert any("head.h5: not an HDF5 file" in note for note in run.notes)
        run.finish("converged")
    assert np.array_equal(read_result(path).fields[2]["gap"].read(0, 6), FIELD + 2)


@pytest.mark.parametrize("bit", [0, 3])
def test_any_flipped_bit_of_a_step_is_noticed_or_means_nothing(path, bit):
    step = interrupted(path, 2) / "step-0001.h5"
    seen = set()
    wanted = read_partial(path).steps
    for _ in flipped(step, bit):
        found = read_partial(path)
        seen.add(len(found.notes))
        assert found.steps == wanted[: len(found.steps)]
        assert len(found.steps) + len(found.notes) == 2
    assert seen == {0, 1}


def test_what_lies_in_the_place_of_a_step_is_left_out(path, tmp_path, cli):
    """Another step, a head, a checkpoint, a step of another scene: refused, named, solved again."""
    folder = interrupted(path)
    with begin(path) as run:
        run.write_checkpoint(GRID, 0, FIELD, UNFINISHED)
    other = interrupted(tmp_path / "other.h5", identity="xyz") / "step-0001.h5"
    for source, words in (
        (folder / "step-0000.h5", "holds no load step 1"),
        (folder / "head.h5", "holds no load step 1"),
        (folder / "checkpoint.h5", "not a result"),
        (other, "belongs to another scene"),
    ):
        shutil.copy(source, folder / "step-0001.h5")
        found = read_partial(path)
        assert found.indices == [0, 2]
        assert len(found.notes) == 1
        assert "step-0001.h5" in found.notes[0]
        assert words in found.notes[0]
        cli.prints("show", path)
    with begin(path) as run:
        assert list(run.finished) == [0, 2]
        assert any("step-0001.h5" in note for note in run.notes)


def test_a_checkpoint_belongs_to_its_scene(path, tmp_path):
    other = interrupted(tmp_path / "other.h5", identity="xyz")
    with begin(path) as run:
        assert run.checkpoint() is None
        run.write_checkpoint(GRID, 3, FIELD, UNFINISHED)
        found = run.checkpoint()
        assert (found.indices, found.steps) == ([3], [UNFINISHED])
        assert np.array_equal(found.fields[0]["gap"].slab(SerialComm(), (0, 6)), FIELD)
        run.write_checkpoint(GRID, 3, FIELD, {"p": 0.1})
        with refused("of another version"):
            run.checkpoint()
        shutil.copy(run.partial / "checkpoint.h5", other)
        with begin(tmp_path / "other.h5", "xyz") as run_of_other, refused("of another scene"):
            run_of_other.checkpoint()
        shutil.copy(other / "step-0000.h5", run.partial / "checkpoint.h5")
        with refused("not a checkpoint"):
            run.checkpoint()


def test_loads_are_in_the_order_of_their_numbers(path):
    """9,999 is before 10,000 in the folder, in the file, and for ParaView."""
    with begin(path) as run:
        for index in (10000, 9999, 10001):
            run.write_step(
                index, {"p": float(index), "status": "converged"}, {"gap": FIELD + index}
            )
        assert read_partial(path).indices == [9999, 10000, 10001]
        run.finish("converged")
    assert read_result(path).indices == [9999, 10000, 10001]
    with h5py.File(path) as file:
        assert list(file["load"]) == list(file["VTKHDF/Steps/Values"]) == [9999, 10000, 10001]
        assert np.array_equal(file["VTKHDF/PointData/gap"][:, 0, 0], [9999, 10000, 10001])


def test_a_link_is_followed(tmp_path):
    """Also to a file that is not there yet, while it is written, and at a restart."""
    (tmp_path / "data").mkdir()
    link = tmp_path / "link.h5"
    real = tmp_path / "data" / "real.h5"
    link.symlink_to(Path("data") / "real.h5")
    interrupted(link)
    assert partial_folder(link) == partial_folder(real)
    assert read_result(link).indices == [0, 1, 2]
    with begin(link) as run:
        run.finish("converged")
    assert link.is_symlink()
    assert sorted(p.name for p in tmp_path.rglob("*.h5*")) == ["link.h5", "real.h5"]
    assert read_result(link).status == "converged"


def test_a_newer_run_beside_a_result_is_mentioned(path, cli):
    complete(path)
    assert read_result(path).notes == ()
    interrupted(path, 2)
    for arguments in ((), ("--json",)):
        told = cli("show", path, *arguments)
        assert (
            "note: a newer run was interrupted, or is running: 2 finished load steps in"
            f" {path}.partial" in told.out + told.err
        )
        assert told.code == 0


@pytest.mark.parametrize("content", [b"my thesis", None])
def test_what_is_no_result_is_not_replaced(path, content):
    """A text, or a height map in HDF5 under the name of the result."""
    if content is None:
        with h5py.File(path, "w") as file:
            file["surface"] = FIELD
    else:
        path.write_bytes(content)
    whole = path.read_bytes()
    with refused(r"is no result that can be read .* --force"):
        begin(path)
    assert path.read_bytes() == whole


def test_the_command_line(cli):
    """A result of another scene stays without --force; the folder of a run in place of its
    file."""
    Path("scene.toml").write_text(
        '[surface]\nkind = "wave"\namplitude = 0.1\nn = [8, 8]\n[load]\npressure = 0.1\n'
        '[output]\npath = "out.h5"\nfields = ["gap", "displacement", "heights"]\n'
    )
    assert cli("run scene.toml -q").code in (0, 3)
    with h5py.File("out.h5") as file:
        assert file.attrs["io"] == "serial"
        step = file["steps/0000"]
        assert np.allclose(step["gap"], step["displacement"][:] - step["heights"][:])
        assert np.max(step["heights"]) == 0
        assert step["heights"] == file["surface/heights"]
    whole = Path("out.h5").read_bytes()
    other = "run scene.toml --set load.pressure=0.2"
    said = "holds the result of another scene, allowed: another path, or --force"
    assert said in cli.refused(other)
    assert Path("out.h5").read_bytes() == whole
    assert names(Path()) == ["out.h5", "scene.toml"]
    run = cli(other, "--force")
    assert run.code in (0, 3)
    assert "overwritten" in run.out
    assert read_result("out.h5").steps[0]["p"] == 0.2
    interrupted(Path("x.h5"))
    for command in ("restart", "show"):
        err = cli.refused(command, "x.h5.partial")
        assert "folder of a run" in err
        assert "x.h5" in err.replace("x.h5.partial", "")
