"""Stopped and killed runs that are resumed: finished loads are not solved again, a stopped load
continues from its gap, and results agree with an uninterrupted run."""

import numpy as np
import pytest
from pieces import LOADS, Died, Pieces, scene

from hpc_gfmd.driver.history import History
from hpc_gfmd.driver.sweep import Sweep
from hpc_gfmd.output.folder import partial_folder
from hpc_gfmd.output.read import read_partial, read_result
from hpc_gfmd.output.record import RunFile
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.runs.simulation import run_scene
from hpc_gfmd.solvers import solver_names

TIGHT = {"accuracy": None, "residual": 1e-9}


@pytest.fixture
def pieces(monkeypatch, tmp_path):
    return Pieces(monkeypatch, SerialComm(), tmp_path)


@pytest.mark.parametrize("solver", sorted(solver_names()))
def test_stopped_and_killed_runs(pieces, solver):
    """Stopped at once and in the middle of loads, and killed without notice."""
    stopped_scene = scene(solver, **TIGHT)
    count = pieces.undisturbed(stopped_scene)
    part = count // 4
    for plan in (
        [(1, False), (1, False), (part, False), (part + 1, False)],
        [(count - 2, True)],
        [(2 * part, True), (part, True)],
    ):
        pieces.run(stopped_scene, *plan)
        pieces.compare(rel=1e-6)


def sticky(loads, **settings):
    """A branch of an adhesive contact; a load of -0.2 pulls the bodies apart."""
    adhesion = {"adhesion": {"work": 0.0024, "range": 0.0125}}
    return scene("bpx", loads, material=adhesion, **settings or TIGHT)


SWEEPS = {
    "each load": (scene("auto", **TIGHT), 1e-6),
    "full contact with free edges": (
        scene("auto", {"gap_over_h_rms": [1e-5, 0, 0.1]}, boundary=["free", "periodic"]),
        2e-2,
    ),
    "low memory": (scene("bpx", [0.05, 0.06, 0.3], ["gap"], low_memory=True, **TIGHT), 1e-6),
    "prescribed": (scene("auto", {"gap_over_h_rms": [0.3, 0.32, 1.2, 0.0, 0.4]}), 2e-2),
    "prescribed areas": (scene("bpx", {"a_r": [0.1, 0.5]}, ["gap"], low_memory=True), 4e-2),
    "dents that stay": (
        scene(
            "auto",
            {"p_star": [0.05, 0.2, 0.0, 0.04, 0.25], "history": True},
            ["gap", "pressure", "dent"],
            material={"hardness": 0.6},
            **TIGHT,
        ),
        1e-6,
    ),
    "a solid that relaxes": (
        scene(
            "auto",
            {"gap_over_h_rms": [0.6, 0.6, 1.0, 2.9, 0.5], "time": [0.0, 1.0, 1.5, 1.5, 4.0]},
            material={"relaxation": [[0.6, 1.0], [0.3, 10.0]]},
            precision="auto",
            accuracy=1e-6,
        ),
        1e-5,
    ),
    "approach": (sticky({"p_star": [0.0, 0.02, 0.1], "branch": "approach"}), 1e-5),
    "retraction": (sticky({"p_star": [0.3, 0.0, -0.002, -0.2], "branch": "retraction"}), 1e-5),
    "cycle": (sticky({"p_star": [0.02, 0.3, 0.05, -0.002, 0.1], "history": True}), 1e-5),
    "held gaps": (
        sticky({"gap_over_h_rms": [0.5, 1.0, 1.5], "branch": "retraction"}, accuracy=1e-6),
        1e-2,
    ),
    "single until a load with few points": (
        scene("auto", [0.3, 1e-4, 1.2e-4, 1.3e-4], precision="auto", accuracy=1e-3),
        2e-3,
    ),
}


@pytest.mark.parametrize("name", SWEEPS)
def test_stops_at_any_point(pieces, name):
    """At three points at least."""
    stopped_scene, rel = SWEEPS[name]
    count = pieces.undisturbed(stopped_scene)
    for point in range(1, count, max(1, count // 3)):
        pieces.run(stopped_scene, (point, False))
        pieces.compare(rel)


def test_finished_loads_are_not_solved_again(pieces, monkeypatch):
    stopped_scene = scene("bpx")
    pieces.interrupt.after = pieces.undisturbed(stopped_scene) // 2
    pieces.interrupt.polled = 0
    assert run_scene(stopped_scene, out=pieces.path, quiet=True).status == "interrupted"
    finished = read_partial(pieces.path).indices
    assert 0 < len(finished) < len(LOADS)
    solve = Sweep.solve
    solved = []

    def counted(sweep, load, *more):
        solved.append(load.value)
        return solve(sweep, load, *more)

    monkeypatch.setattr(Sweep, "solve", counted)
    pieces.interrupt.after = 10**9
    assert run_scene(stopped_scene, out=pieces.path, quiet=True).status == "converged"
    assert len(solved) == len(LOADS) - len(finished)


@pytest.mark.parametrize("lost", ["nothing", "memory", "load"])
def test_a_history_goes_on_from_its_memory(pieces, monkeypatch, lost):
    """Finished loads are solved again only if what they have left is lost. Killed after that was
    written, but not the load (lost), the memory of the load before is still there."""
    stopped_scene = scene(
        "auto",
        {"p_star": [0.2, 0.04, 0.1, 0.25], "history": True},
        material={"hardness": 0.6},
        **TIGHT,
    )
    pieces.undisturbed(stopped_scene)
    write = RunFile.write_step

    def dies(file, index, *more):
        if index == 2:
            raise Died
        write(file, index, *more)

    with monkeypatch.context() as patch:
        patch.setattr(RunFile, "write_step", dies)
        with pytest.raises(Died):
            run_scene(stopped_scene, out=pieces.path, quiet=True)
    folder = partial_folder(pieces.path)
    assert [path.name for path in sorted(folder.glob("memory*"))] == [
        "memory-0001.h5",
        "memory-0002.h5",
    ]
    if lost != "load":
        (folder / "memory-0002.h5").unlink()
    if lost == "memory":
        (folder / "memory-0001.h5").write_bytes(b"no file")
    solved = []
    solve = History.solve

    def counted(history, load, *more):
        solved.append(load.value)
        return solve(history, load, *more)

    monkeypatch.setattr(History, "solve", counted)
    assert run_scene(stopped_scene, out=pieces.path, quiet=True).status == "converged"
    assert len(solved) == (4 if lost == "memory" else 2)
    pieces.compare(rel=1e-6)


def test_a_stopped_load_continues_from_its_gap(pieces):
    """Iterations and pairs of both runs are counted; coarser grids are not solved again."""
    stopped_scene = scene("bpx", [0.05], **TIGHT)
    pieces.undisturbed(stopped_scene)
    (whole,) = read_result(pieces.whole).steps
    pieces.run(stopped_scene, (whole["iterations"] // 2, False))
    (step,) = read_result(pieces.path).steps
    # one pair for the certificate of the stopped load, one for the first pressure, a few since the
    # search direction is lost
    assert whole["fft_pairs"] < step["fft_pairs"] < whole["fft_pairs"] + 12
    assert whole["iterations"] <= step["iterations"] < whole["iterations"] + 10
    assert step["gap_mean"] == pytest.approx(whole["gap_mean"], rel=1e-7)


def test_a_stopped_load_keeps_double_precision(pieces, monkeypatch):
    """A load that stagnated in single precision and was stopped in double resumes in double."""
    from hpc_gfmd.driver import sweep

    monkeypatch.setattr(sweep, "first_precision", lambda *_: np.dtype(np.float32))
    stopped_scene = scene("bpx", [0.3], precision="auto", accuracy=None, residual=1e-8)
    count = pieces.undisturbed(stopped_scene)
    assert read_result(pieces.whole).steps[0]["fft_pairs"] > 40  # of both attempts
    precisions = []
    drive = sweep.drive

    def noted(solver, *args):
        precisions.append(solver.problem.dtype.name)
        return drive(solver, *args)

    pieces.interrupt.after = count
    pieces.interrupt.polled = 0
    assert run_scene(stopped_scene, out=pieces.path, quiet=True).status == "interrupted"
    monkeypatch.setattr(sweep, "drive", noted)
    pieces.interrupt.after = 10**9
    run_scene(stopped_scene, out=pieces.path, quiet=True)
    assert precisions == ["float64"]
    pieces.compare(rel=1e-5)
