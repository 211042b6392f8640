"""Hostile files of every kind: a single line, exit code 2, no files written, no code executed.

Other defects are found by random changes of bytes (test_readers.py).
"""

import pickle
from functools import partial

import h5py
import numpy as np
import pytest
import tomli_w
from contacts import rough
from faults.seeds import FIELD, seeds

Z = np.arange(48.0).reshape(8, 6)
HUGE = 10**6


class Trap:
    """An object that creates a file when it is unpickled."""

    def __init__(self, path):
        self.path = str(path)

    def __reduce__(self):
        return open, (self.path, "w")


def cut(path, data, keep):
    """Write the first part of some data."""
    path.write_bytes(data[: int(keep * len(data))])


def claims(path, shape):
    """Make a .npy file with `shape` in its header and 48 numbers."""
    with open(path, "wb") as file:
        np.lib.format.write_array_header_1_0(
            file, {"descr": "<f8", "fortran_order": False, "shape": shape}
        )
        file.write(Z.tobytes())


def trap(path):
    """Make a pickle with the name of an array."""
    path.write_bytes(pickle.dumps(Trap(path.with_name("trapped"))))


def linked(path):
    """Make a file whose map is a link to another file, which no reader may open."""
    foreign(path.with_name("elsewhere.h5"))
    with h5py.File(path, "w") as file:
        file["surface"] = h5py.ExternalLink("elsewhere.h5", "/surface")


def half_a_netcdf(path):
    """Make a truncated map."""
    cut(path, seeds("netcdf", path.parent)[0].read_bytes(), 0.67)


HEIGHT_MAPS = {  # name: (extension, function that makes it, words of the message)
    "pickle as .npy": (".npy", trap, "magic string"),
    ".npy claiming 1e12 points": (".npy", partial(claims, shape=(HUGE, HUGE)), "cannot be read"),
    "empty .npy": (".npy", lambda path: path.write_bytes(b""), "empty"),
    "external link": (".h5", linked, "link to another"),
    "truncated NetCDF map": (".nc", half_a_netcdf, "netcdf"),
}


def sound(path):
    """Make a sound result file and return its bytes."""
    plain, compressed = seeds("result", path.parent)
    data = plain.read_bytes()
    plain.unlink()
    compressed.unlink()
    path.write_bytes(data)
    return data


def edit(path, change):
    """Make a sound result and change it with change(file)."""
    sound(path)
    with h5py.File(path, "r+", locking=False) as file:
        change(file)


def foreign(path):
    """Make an HDF5 file of another program."""
    with h5py.File(path, "w") as file:
        file["surface"] = Z


def one_bit(path):
    """Make a result with one bit of a number flipped."""
    data = sound(path)
    place = data.index(np.float64(0.25).tobytes()) + 3
    path.write_bytes(data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :])


def moved_out(file):
    """Move the gap to another file."""
    with h5py.File("elsewhere.h5", "w") as elsewhere:
        elsewhere["surface"] = FIELD
    del file["steps/0000/gap"]
    file["steps/0000/gap"] = h5py.ExternalLink("elsewhere.h5", "/surface")


def huge(file):
    """Replace the gap by a field of 1e6 x 1e6 points without numbers."""
    file["surface"].attrs.modify("n", [HUGE, HUGE])
    del file["steps/0000/gap"]
    file["steps/0000"].create_dataset("gap", (HUGE, HUGE), "f4")


RESULTS = {  # name: (function that makes it, words of the message)
    "truncated": (lambda path: cut(path, sound(path), 0.5), "truncated file"),
    "HDF5 of another program": (foreign, "hpc-gfmd"),
    "one bit of a number": (one_bit, "damaged"),
    "a huge field without numbers": (partial(edit, change=huge), "gap"),
    "a link out of it": (partial(edit, change=moved_out), "link"),
}


@pytest.fixture
def refused(tmp_path, cli):
    """refused(*args, code=2) runs a command and returns its line on stderr; it writes no files."""

    def run(*args, code=2):
        before = sorted(tmp_path.rglob("*"))
        line = cli.refused(*args, code=code)
        assert len(line) < 1000
        assert sorted(tmp_path.rglob("*")) == before
        return line

    return run


@pytest.mark.parametrize("fault", HEIGHT_MAPS)
def test_height_map(fault, tmp_path, refused):
    extension, make, words = HEIGHT_MAPS[fault]
    path = tmp_path / f"z{extension}"
    make(path)
    scene = {
        "surface": {"kind": "file", "physical_sizes": [1, 1], "path": path.name},
        "load": {"pressure": 0.1},
    }
    (tmp_path / "scene.toml").write_text(tomli_w.dumps(scene | {"solver": {"max_iterations": 1}}))
    line = refused("run", "scene.toml")
    assert words in line
    assert path.name in line or "GiB" in line
    assert not (tmp_path / "trapped").exists()


@pytest.mark.parametrize("fault", RESULTS)
def test_result_file(fault, tmp_path, refused):
    make, words = RESULTS[fault]
    path = tmp_path / "out.h5"
    make(path)
    assert words in refused("show", "out.h5")
    for command in (["plot", "out.h5"], ["restart", "out.h5"], ["export", "out.h5", "--to", "csv"]):
        refused(*command)


@pytest.fixture
def stopped_run(tmp_path, monkeypatch):
    """(the steps of an undisturbed run, the checkpoint of one that was stopped: out.h5)."""
    from hpc_gfmd.parallel.interrupt import Interrupt
    from hpc_gfmd.runs.simulation import run_scene
    from hpc_gfmd.scene import Scene

    monkeypatch.setattr(Interrupt, "require_time", lambda self: None)
    tables = {"surface": rough((1, 16, 2)), "load": {"p_star": 0.1}}
    whole = run_scene(Scene.from_dict(tables), out="whole.h5", quiet=True)
    stopped = Scene.from_dict(tables | {"machine": {"wall_seconds": 1e-9}})
    assert run_scene(stopped, out="out.h5", quiet=True).status == "interrupted"
    return whole.steps, tmp_path / "out.h5.partial" / "checkpoint.h5"


@pytest.mark.parametrize("damage", ["cut", "garbled"])
def test_a_bad_checkpoint_is_never_used(damage, stopped_run, capfd):
    """The load starts again, and ends as if there had been no checkpoint."""
    from hpc_gfmd.runs.simulation import restart

    steps, path = stopped_run
    data = path.read_bytes()
    if damage == "cut":
        cut(path, data, 0.7)
    else:
        place = data.index(b"OHDR") + 30
        path.write_bytes(data[:place] + b"\x55" * 64 + data[place + 64 :])
    capfd.readouterr()
    run = restart("out.h5", ["machine.wall_seconds=1e9"])
    (line,) = (line for line in capfd.readouterr().out.splitlines() if "damaged" in line)
    assert line.endswith("load 1 begins anew")
    assert run.exit_code == 0
    assert [step["a_r"] for step in run.steps] == [step["a_r"] for step in steps]
    assert [step["iterations"] for step in run.steps] == [step["iterations"] for step in steps]
