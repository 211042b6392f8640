"""Bad scenes on any number of ranks: exit code 2, one line on stderr, once, nothing written, no
hang."""

import h5py
import numpy as np
import pytest
import tomli_w

from hpc_gfmd.commands.cli import main

pytestmark = pytest.mark.mpi
GOOD = tomli_w.dumps(
    {"surface": {"kind": "wave", "amplitude": 0.1, "n": [8, 8]}, "load": {"pressure": 0.1}}
)

MAP = 'surface={{kind = "file", physical_sizes = [1, 1], path = {}}}'
BAD = {  # name: overrides of the good scene, and what the message names
    "unknown key": (["load.presure=1"], "pressure"),
    "unknown solver": (["solver.name=bqx"], "bpx"),
    "unknown option": (["solver.options={bogus = 1}"], "bogus"),
    "unknown option of gfmd": (["solver.name=gfmd", "solver.options={bogus = 1}"], "bogus"),
    "no folder": (["output.path=missing/a.h5"], "missing"),
    "p_star of a flat wall": (["surface.amplitude=0", "load={p_star = [0.1]}"], "load.p_star"),
    "missing file": ([MAP.format('"none.npy"')], "none.npy"),
    "text as heights": ([MAP.format('"text.npy"')], "text.npy"),
    "nan in the last row": ([MAP.format('"nan.npy"')], "nan"),
    "the largest number in the last row": ([MAP.format('"missing.npy"')], "(8, 7)"),
    "numbers that differ by more than there is": ([MAP.format('"both.npy"')], "surface.path"),
    "more threads than any machine bears": (["machine.threads=65536"], "machine.threads"),
    "a pressure that the file cannot hold": (
        [
            'output={dtype = "single", fields = ["pressure"]}',
            "material.E_star=1e-50",
            "load={p_star = 0.1}",
        ],
        "output.dtype",
    ),
    "units beyond double precision": (
        [
            "material.E_star=1e-100",
            "surface.amplitude=1e-90",
            "surface.physical_sizes=[1e90, 1e90]",
        ],
        "E_star*g_rms",
    ),
    "complex heights": ([MAP.format('"complex.npy"')], "complex"),
    "three axes": ([MAP.format('"cube.npy"')], "cube.npy"),
    "no data set": ([MAP.format('"z.h5", dataset = "q"')], "height"),
    "too large": (["surface.n=[1048576, 1048576]"], "GiB"),
    "constant file, p_star": ([MAP.format('"flat.npy"'), "load={p_star = 0.1}"], "load.p_star"),
    "gone": (None, "gone.toml"),
}


@pytest.fixture
def folder(comm, shared_path):
    if comm is not None and comm.rank == 0:
        (shared_path / "scene.toml").write_text(GOOD)
        (shared_path / "text.npy").write_text("no heights")
        z = np.zeros((9, 8))
        np.save(shared_path / "flat.npy", z)
        np.save(shared_path / "complex.npy", z + 1j)
        np.save(shared_path / "cube.npy", np.zeros((2, 2, 2)))
        z[-1, -1] = 1.7e308
        np.save(shared_path / "missing.npy", z)
        z[0, 0] = -1.7e308
        np.save(shared_path / "both.npy", z)
        z[-1, -1], z[0, 0] = np.nan, 0.0
        np.save(shared_path / "nan.npy", z)
        with h5py.File(shared_path / "z.h5", "w") as file:
            file["height"] = z
    if comm is not None:
        comm.barrier()
    return shared_path


@pytest.mark.parametrize("name", BAD)
def test_refused(comm, folder, name, capfd, monkeypatch):
    monkeypatch.chdir(folder)
    overrides, named = BAD[name]
    scene = "scene.toml" if overrides is not None else "gone.toml"
    before = sorted(folder.iterdir())
    comm.barrier()
    code = main(["run", scene, *[part for o in overrides or () for part in ("--set", o)]])
    err = capfd.readouterr().err
    assert code == 2, err
    if comm.rank == 0:
        assert err.count("\n") == 1
        assert named in err
        assert "Traceback" not in err
    else:
        assert err == ""
    comm.barrier()
    assert sorted(folder.iterdir()) == before


def test_by_mpirun(mpirun, tmp_path):
    """The same from outside: what a user and a job script see."""
    (tmp_path / "scene.toml").write_text(GOOD)
    run = mpirun("run", "scene.toml", "--set", "surface.perids=[3, 3]", cwd=tmp_path)
    assert run.returncode == 2
    assert run.stdout == ""
    assert run.stderr.strip().count("\n") == 0
    assert "surface.periods" in run.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["scene.toml"]


def test_wrong_arguments_by_mpirun(mpirun, tmp_path):
    run = mpirun("run", "--sett", "a=b", cwd=tmp_path)
    assert run.returncode == 2
    assert len(run.stderr.strip().splitlines()) == 1
