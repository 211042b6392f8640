"""Misplaced files in the folder of a run, and results in the way."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from refusal import refused
from result_files import FIELD, UNFINISHED, begin, complete, interrupted, names

from hpc_gfmd.output.folder import partial_folder
from hpc_gfmd.output.read import CHECKPOINT, read_partial, read_result
from hpc_gfmd.parallel.comm import SerialComm


def test_checkpoints_of_other_scenes_are_refused(path, tmp_path):
    other_folder = interrupted(tmp_path / "other.h5", identity="xyz")
    with begin(path) as run:
        assert run.state(CHECKPOINT, 3) is None
        run.write_state(CHECKPOINT, 3, {"gap": FIELD}, UNFINISHED)
        stored = run.state(CHECKPOINT, 3)
        assert (stored.indices, stored.steps) == ([3], [UNFINISHED])
        assert np.array_equal(stored.fields[0]["gap"].slab(SerialComm(), (0, 6)), FIELD)
        run.write_state(CHECKPOINT, 3, {"gap": FIELD}, {"p": 0.1})
        with refused("of another version"):
            run.state(CHECKPOINT, 3)
        shutil.copy(run.partial / "checkpoint.h5", other_folder)
        with begin(tmp_path / "other.h5", "xyz") as run_of_other, refused("of another scene"):
            run_of_other.state(CHECKPOINT, 3)
        shutil.copy(complete(tmp_path / "third.h5"), run.partial / "checkpoint.h5")
        with refused("not a checkpoint"):
            run.state(CHECKPOINT, 3)


def test_loads_are_ordered_by_number(path):
    """9,999 comes before 10,000 in the folder, in the file and in ParaView."""
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


def test_symbolic_links_are_followed(tmp_path):
    """Before the file exists, while it is written, and at a restart."""
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


@pytest.mark.parametrize("content", [b"my thesis", None])
def test_files_that_are_no_results_are_not_replaced(path, content):
    """A text, or a height map in HDF5 under the name of the result."""
    if content is None:
        with h5py.File(path, "w") as file:
            file["surface"] = FIELD
    else:
        path.write_bytes(content)
    whole = path.read_bytes()
    with refused(r"out\.h5.* no result .*--force"):
        begin(path)
    assert path.read_bytes() == whole


def test_results_of_other_scenes_need_force(cli):
    """A result is only overwritten with --force; a run's folder is refused as a result."""
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
    command_of_other_load = "run scene.toml --set load.pressure=0.2"
    message = cli.refused(command_of_other_load)
    assert all(words in message for words in ("another scene", "allowed: ", "--force"))
    assert Path("out.h5").read_bytes() == whole
    assert names(Path()) == ["out.h5", "scene.toml"]
    run = cli(command_of_other_load, "--force")
    assert run.code in (0, 3)
    assert "overwritten" in run.out
    assert read_result("out.h5").steps[0]["p"] == 0.2
    interrupted(Path("x.h5"))
    for command in ("restart", "show"):
        err = cli.refused(command, "x.h5.partial")
        assert "folder of a run" in err
        assert "x.h5" in err.replace("x.h5.partial", "")
