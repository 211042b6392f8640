"""Commands as a user or a job script runs them: exit codes, files, messages."""

import contextlib
import errno
import re

import h5py
import numpy as np
import pytest
from contacts import scene_text
from faults.jobs import call
from mpi_harness import printed
from scene_tables import rows

import hpc_gfmd
from hpc_gfmd.commands.cli import COMMANDS, main
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.parallel.interrupt import Interrupt
from hpc_gfmd.scene import load_scene
from hpc_gfmd.surface import build_surface

SCENE = scene_text(output={"fields": ["pressure", "gap"]})
STEP = {
    *("p", "p_star", "a_r", "kappa", "gap_mean", "gap_over_h_rms", "a_r_error", "gap_error"),
    *("pressure_error", "iterations", "fft_pairs", "wall_seconds", "status"),
}
SURFACE = {"n", "physical_sizes", "h_rms", "g_rms", "eps_t", "eps_f", "eps_c", "seed"}
HEAD = {"format_version", "scene", "versions", "start_time", "end_time", "ranks", "setup_seconds"}


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    folder = tmp_path_factory.mktemp("solved")
    (folder / "scene.toml").write_text(SCENE)
    run = call("run scene.toml -o out.h5", cwd=folder)
    assert run.code == 0, run.err
    return folder, run


def test_run(solved):
    folder, run = solved
    assert sorted(p.name for p in folder.iterdir()) == ["out.h5", "scene.toml"]
    assert "kappa" in run.out
    assert not run.err
    with h5py.File(folder / "out.h5") as file:
        assert file.attrs["format"] == "hpc-gfmd"
        assert file.attrs["status"] == "converged"
        assert set(file.attrs) >= HEAD
        assert set(file["surface"].attrs) >= SURFACE
        assert list(file["steps"]) == ["0000", "0001"]
        for step in file["steps"].values():
            assert set(step.attrs) >= STEP
            assert step.attrs["status"] == "converged"
            assert set(step) == {"pressure", "gap", "x", "y", "p"}
            pressure = step["pressure"][:]
            gap = step["gap"][:]
            assert pressure.shape == (32, 32)
            assert pressure.mean() == pytest.approx(step.attrs["p"], rel=1e-3)
            assert gap.mean() == pytest.approx(step.attrs["gap_mean"], rel=1e-3)
            assert np.mean(pressure > 0) == pytest.approx(step.attrs["a_r"])


def test_run_with_plot_saves_the_pictures_of_plot(solved, tmp_path):
    folder, _ = solved
    (tmp_path / "scene.toml").write_text(SCENE)
    run = call("run scene.toml -o out.h5 --plot", cwd=tmp_path)
    assert run.code == 0, run.err
    plot = call(f"plot {folder / 'out.h5'} -o pictures", cwd=tmp_path)
    assert plot.code == 0, plot.err
    saved, drawn = (
        {path.name: path.stat().st_size for path in (tmp_path / name).iterdir()}
        for name in ("out_plots", "pictures")
    )
    assert saved.keys() == drawn.keys() != set()
    assert min(saved.values()) > 0


def test_show(cli, solved):
    path = solved[0] / "out.h5"
    assert "converged" in cli.prints("show", path)
    shown = cli.data("show", path)
    assert set(shown) == {"surface", "steps", "status"}
    assert set(shown["surface"]) >= SURFACE
    assert shown["surface"]["n"] == [32, 32]
    assert all(set(step) >= STEP for step in shown["steps"])
    assert [step["p_star"] for step in shown["steps"]] == pytest.approx([0.05, 0.1], rel=1e-6)
    program, *papers = hpc_gfmd.load(path).references()
    assert program.startswith("hpc-gfmd ")
    assert len(papers) > 4
    assert all(re.search(r"\(\d{4}\).*, doi:10\.\d+/\S+$", paper) for paper in papers)
    assert cli.prints("show --references", path).endswith("\n".join(["", program, *papers, ""]))
    assert cli.data("show --references", path)["references"][1:] == papers


@pytest.mark.parametrize(
    ("statement", "absent"),
    rows("""
import hpc_gfmd | numpy pydantic numba mpi4py h5py matplotlib typing
import hpc_gfmd.commands.cli | pydantic_core numba mpi4py matplotlib
import hpc_gfmd.scene | numba mpi4py matplotlib
import hpc_gfmd.output.read | numba mpi4py matplotlib
import hpc_gfmd.theory.persson | numba mpi4py matplotlib
import hpc_gfmd; hpc_gfmd.reference.contact_area(0.1, 0.8, 1 / 256) | numba mpi4py h5py
"""),
)
def test_imports_are_light(statement, absent):
    code = f"import sys; {statement}; print([m for m in {absent.split()} if m in sys.modules])"
    assert printed("-c", code) == "[]\n"


def test_interrupted_runs_are_resumed(cli, folder, monkeypatch):
    """Exit code 143; the same command and `restart` resume. A wall time too short for any load is
    refused."""
    in_no_time = "run scene.toml --set machine.wall_seconds=1e-9"
    assert "machine.wall_seconds" in cli.refused(in_no_time)
    assert not (folder / "contact.h5.partial").exists()
    with monkeypatch.context() as patched:
        patched.setattr(Interrupt, "require_time", lambda self: None)
        run = cli(in_no_time)
        assert run.code == 143
        assert "restart" in run.out + run.err
        assert cli.data("show contact.h5")["status"] == "interrupted"
        shown = cli.prints("show contact.h5")
        assert "interrupted" in shown
        assert "no finished load step yet" in shown
        assert cli("restart contact.h5").code == 143  # the wall time is part of the stored scene
    assert "machine.wall_seconds" in cli.refused("restart contact.h5")
    assert (folder / "contact.h5.partial" / "checkpoint.h5").exists()
    log = cli.prints("run scene.toml")
    assert all(words in log for words in ("resuming", "0 loads"))
    assert cli("restart contact.h5").code == 2  # complete


WRONG = rows("""
run scene.toml --set load.p_sta=1 | load.p_star
run scene.toml --set solver.accuracy=0 | solver.accuracy
run gone.toml | gone.toml
walk scene.toml | walk
plam scene.toml | plan
run scene.toml --foo | hpc-gfmd run --help
plan --rank 3 scene.toml --foo=1 | hpc-gfmd plan --help
show gone.h5 | gone.h5
show scene.toml | scene.toml
plan scene.toml --set surface.lam_l_over_lam_s=262144 | GiB
persson --hurst 2 --eps-f 0.1 --p-star 0.1 | urst
run scene.toml --set surface.boundary=free --set 'output.distributions=["gap_spectrum"]' | spectrum
 | COMMAND
run scene.toml --set machine.memory_gib=1e-6 | GiB
""")


def test_wrong_input_is_refused(cli, folder):
    """The error is one line that names the key; nothing is written."""
    for args, named in WRONG:
        assert named in cli.refused(args)
        assert [p.name for p in folder.iterdir()] == ["scene.toml"]


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_prints_its_help(capsys, command):
    with contextlib.suppress(SystemExit):
        main([command, "--help"])
    printed_help = capsys.readouterr()
    assert printed_help.out.startswith("usage: hpc-gfmd")
    assert not printed_help.err


def test_plan(cli, folder):
    plan = cli.data("plan scene.toml --ranks 3")
    assert (plan["n"], plan["ranks"], plan["idle_ranks"]) == ([32, 32], 3, 0)
    assert plan["gib_per_rank"] > 0
    assert plan["seconds"] > 0
    assert "GiB per rank" in cli.prints("plan scene.toml")
    assert [p.name for p in folder.iterdir()] == ["scene.toml"]


def test_plan_is_of_the_ranks_that_were_started(cli, folder, monkeypatch):
    monkeypatch.setattr("hpc_gfmd.parallel.launcher.launched", lambda: (True, 3))
    monkeypatch.setattr("hpc_gfmd.parallel.world.launched", lambda: (False, None))
    assert cli.data("plan scene.toml")["ranks"] == 3
    assert cli.data("plan scene.toml --ranks 2")["ranks"] == 2


@pytest.mark.parametrize(
    "keys", ['unit = "um"', "physical_sizes = [1.0, 3.0]\ncrop = [0.0, 0.0, 0.5, 3.0]"]
)
def test_plan_of_a_map_with_free_edges(cli, tmp_path, keys):
    """The cell follows from the sizes after cropping, from the file or the scene."""
    np.savez("z.npz", surface=np.random.default_rng(0).random((40, 20)), physical_sizes=[1.0, 3.0])
    scene = (
        f'[surface]\nkind = "file"\npath = "z.npz"\nboundary = "free"\n{keys}\n[load]\np_star ='
        " 0.1\n"
    )
    (tmp_path / "scene.toml").write_text(scene)
    plan = cli.data("plan scene.toml")
    made = build_surface(load_scene("scene.toml").surface, SerialComm(), np.float64)
    assert (plan["n"], plan["cell"]) == (list(made.n), list(made.grid.n))


def test_info(cli):
    text = cli.prints("info")
    assert all(word in text for word in ("numpy", "FFT", "MPI", "HDF5", "cores"))


OF_THE_SYSTEM = [
    (MemoryError("Unable to allocate 7 TiB"), 1, "memory 7 TiB"),
    (OSError(errno.ENOMEM, "Cannot allocate memory"), 1, "memory"),
    (OSError(errno.ENOSPC, "No space left on device", "out.h5"), 1, "out.h5 space"),
    (PermissionError(errno.EACCES, "Permission denied", "out.h5"), 2, "out.h5 denied"),
    (PermissionError("locked"), 2, "show locked"),
    (ImportError("libblas"), 1, "show libblas"),
    (ModuleNotFoundError("No module named 'gwyfile'", name="gwyfile"), 1, "show gwyfile"),
]


def test_errors_of_the_system_are_one_line(monkeypatch, cli):
    """Too little memory, noticed by NumPy or the system; missing permissions; broken libraries."""
    for error, code, words in OF_THE_SYSTEM:

        def fail(_, error=error):
            raise error

        monkeypatch.setattr("hpc_gfmd.commands.show.main", fail)
        message = cli.refused("show out.h5", code=code)
        assert all(word in message for word in words.split())
