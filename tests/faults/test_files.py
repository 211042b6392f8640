"""Bad files of every kind: a single line, exit code 2, no files written, no code executed."""

import zipfile

import h5py
import numpy as np
import pytest
import tomli_w
from contacts import rough
from faults.bad_files import HEIGHT_MAPS, RESULTS, Z, archive, cut, h5

from hpc_gfmd.scene import File
from hpc_gfmd.surface.topography import open_topography


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


def test_a_large_map_in_one_chunk_is_unpacked_once(tmp_path):
    """Rows are read a few at a time from the unpacked chunk, even if the file changes."""
    z = np.arange(2048.0 * 640).reshape(2048, 640)
    path = tmp_path / "z.h5"
    h5(
        path,
        lambda file: file.create_dataset(
            "surface", data=z, chunks=z.shape, compression="gzip", compression_opts=1
        ),
    )
    topography = open_topography(File(kind="file", path=str(path)))
    assert np.array_equal(topography.rows(0, 64), z[:64])
    with open(path, "r+b") as file:  # the chunk cannot be unpacked again
        file.seek(4000)
        file.write(bytes(path.stat().st_size - 5000))
    for i in range(64, 2048, 64):
        assert np.array_equal(topography.rows(i, i + 64), z[i : i + 64])


@pytest.mark.parametrize(
    "array",
    [Z.astype(">f4"), np.asfortranarray(Z), Z.astype("i2"), Z.astype("u1"), Z.astype("f2"), Z[::2]],
)
def test_sound_height_maps_of_every_kind(array, tmp_path):
    np.save("z.npy", array)
    h5(tmp_path / "z.h5", lambda file: file.create_dataset("surface", data=array))
    for path in (tmp_path / "z.npy", tmp_path / "z.h5"):
        topography = open_topography(File(kind="file", path=str(path)))
        assert topography.n == array.shape
        assert np.array_equal(topography.rows(1, 4), np.asarray(array, dtype=float)[1:4])


def test_one_array_of_an_archive_is_unpacked(tmp_path):
    """Other arrays may claim any size."""
    archive(tmp_path / "z.npz", unit=(10**9,), other=(10**6, 10**6))
    with zipfile.ZipFile(tmp_path / "z.npz", "a") as file, file.open("z.npy", "w") as array:
        np.save(array, Z)
    topography = open_topography(File(kind="file", path=str(tmp_path / "z.npz"), dataset="z"))
    assert np.array_equal(topography.rows(1, 4), Z[1:4])


def test_soft_links_within_the_file_are_followed(tmp_path):
    def fill(file):
        file["a/b/heights"] = Z
        file["a/link"] = h5py.SoftLink("b")
        file["surface"] = h5py.SoftLink("a/link/heights")

    h5(tmp_path / "z.h5", fill)
    assert np.array_equal(open_topography(File(kind="file", path="z.h5")).rows(0, 8), Z)


def test_packed_netcdf_and_missing_points():
    """By the conventions of NetCDF height = scale_factor * number + add_offset; _FillValue marks
    missing points."""
    from scipy.io import netcdf_file

    from hpc_gfmd.util.errors import SceneError

    def write(path, **attributes):
        with netcdf_file(path, "w") as file:
            for name, size in zip("xy", Z.shape, strict=True):
                file.createDimension(name, size)
            z = file.createVariable("z", "i2", ("x", "y"))
            z[:] = Z
            for name, value in attributes.items():
                setattr(z, name, value)
        return open_topography(File(kind="file", path=str(path)))

    topography = write("z.nc", scale_factor=0.25, add_offset=-3.0, _FillValue=np.int16(99))
    assert np.array_equal(topography.rows(2, 5), 0.25 * Z[2:5] - 3)
    assert np.argwhere(
        np.isnan(write("holes.nc", missing_value=np.int16(5)).rows(0, 3))
    ).tolist() == [[0, 5]]
    with pytest.raises(SceneError, match="scale_factor is no number"):
        write("odd.nc", scale_factor="much")


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


def test_wrong_numbers_in_a_checkpoint_change_no_result(stopped_run):
    """The load starts from another gap; what comes out is certified all the same."""
    from hpc_gfmd.runs.simulation import restart

    steps, path = stopped_run
    with h5py.File(path, "r+") as file:
        file["steps/0000/gap"][3:5] = 7.0
    run = restart("out.h5", ["machine.wall_seconds=1e9"])
    assert run.exit_code == 0
    for step, right in zip(run.steps, steps, strict=True):
        assert step["status"] == "converged"
        assert step["a_r"] == pytest.approx(right["a_r"], rel=2e-3)
        assert step["gap_mean"] == pytest.approx(right["gap_mean"], rel=2e-3)
