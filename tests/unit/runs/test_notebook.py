"""Solutions as used in notebooks: lists of loads, files and pickles, further observables, plots."""

import pickle
import signal
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from contacts import random_heights, rough, scene_text
from mpi_harness import printed
from refusal import refused
from result_files import begin

import hpc_gfmd
from hpc_gfmd.contact import all_distributions, all_observables, observable_names, response
from hpc_gfmd.driver.sweep import Sweep
from hpc_gfmd.output.folder import partial_folder
from hpc_gfmd.output.read import read_result
from hpc_gfmd.parallel import h5
from hpc_gfmd.runs.simulation import run_scene
from hpc_gfmd.runs.solution import LOST
from hpc_gfmd.scene import Scene

N = (24, 20)
SIZES = ("12 um", "10 um")
Z = 2e-8 * random_heights(N, 3)
LOADS = ["10 MPa", "30 MPa", "200 MPa"]
ROUGH = rough((2, 8, 4), physical_sizes=["1 um", "1 um"], g_rms=0.1)


def solve(loads, z=Z, **options):
    """Solutions of a small map in SI units; options: of hpc_gfmd.solve."""
    return hpc_gfmd.solve(z, loads, "5 GPa", SIZES, **options)


@pytest.fixture(scope="module")
def sweep():
    return solve(LOADS, distributions=["pressure"], observables=["perimeter"])


@pytest.fixture
def saved(sweep):
    sweep.save("saved.h5")
    return hpc_gfmd.load("saved.h5")


def assert_same(solution, expected):
    """Compare numbers and fields of two solutions to the last bit."""
    assert {k: v for k, v in solution.result.steps[0].items() if v is not None} == {
        k: v for k, v in expected.result.steps[0].items() if v is not None
    }
    assert repr(solution.result.surface) == repr(expected.result.surface)  # may contain nan
    for name in ("pressure", "gap", "heights", "contact"):
        assert np.array_equal(getattr(solution, name), getattr(expected, name)), name


def test_numbers_and_fields_of_a_list_of_loads(sweep):
    assert [solution.p for solution in sweep] == [1e7, 3e7, 2e8]
    areas = sweep.a_r.tolist()
    assert areas == sweep.values("a_r").tolist() == [solution.a_r for solution in sweep]
    assert areas == sorted(set(areas))
    assert (sweep.unit, sweep.h_rms, len(sweep.perimeter)) == ("m", sweep[0].h_rms, 3)
    assert {"a_r", "gap_error", "perimeter"} <= {*dir(sweep)} & {*dir(sweep[0])}
    assert sweep[0].distribution("pressure").units == {"edges": "Pa", "density": "1/Pa"}
    with pytest.raises(AttributeError, match=r"stiffness: .*observable"):
        _ = sweep.stiffness
    for solution in sweep:
        assert solution.pressure.mean() == pytest.approx(solution.p, rel=1e-3)
        assert np.count_nonzero(solution.contact) == solution.a_r * Z.size
        assert solution.gap.mean() == pytest.approx(solution.gap_mean)
        assert np.allclose(solution.displacement, solution.gap + solution.heights, atol=1e-15)
        assert np.allclose(solution.heights, Z - Z.max(), atol=1e-14)
    alone = solve(LOADS[1])
    assert isinstance(alone, hpc_gfmd.Solution)
    assert alone.a_r == sweep[1].a_r
    assert len(hpc_gfmd.solve(Z, np.array([1e7]), 5e9, (12e-6, 10e-6))) == 1


def stop_at(monkeypatch, number):
    """Raise KeyboardInterrupt at the start of a load (counted from 1)."""
    usual = Sweep.solve
    calls = []

    def stopping(self, *arguments):
        calls.append(1)
        if len(calls) == number:
            raise KeyboardInterrupt
        return usual(self, *arguments)

    monkeypatch.setattr(Sweep, "solve", stopping)


@pytest.mark.parametrize("fields", [("pressure", "gap", "heights"), ()])
def test_finished_loads_survive_ctrl_c(monkeypatch, sweep, fields):
    stop_at(monkeypatch, 3)
    with pytest.raises(KeyboardInterrupt) as caught:
        solve(LOADS, fields=fields)
    assert isinstance(caught.value, hpc_gfmd.Interrupted)
    finished = pickle.loads(pickle.dumps(caught.value)).solutions
    assert [solution.a_r for solution in finished] == [solution.a_r for solution in sweep[:2]]
    assert finished.status == "interrupted"
    (note,) = finished.notes
    assert all(words in note for words in ("interrupted", "pressure = 200 MPa"))
    if fields:
        for solution, uninterrupted in zip(finished, sweep):
            assert np.array_equal(solution.gap, uninterrupted.gap)
        loaded = hpc_gfmd.load(finished.save("some.h5"))
        assert (len(loaded), loaded.status) == (2, "interrupted")


def test_ctrl_c_before_any_load_is_finished(monkeypatch):
    for loads in (LOADS, LOADS[0]):
        stop_at(monkeypatch, 1)
        with pytest.raises(KeyboardInterrupt) as caught:
            solve(loads)
        assert type(caught.value) is KeyboardInterrupt
        monkeypatch.undo()


def test_solve_agrees_with_a_run():
    """A run, solve of its surface and solve of the scene give the same result and head."""
    wall = hpc_gfmd.make_surface(**ROUGH)
    fields = ["pressure", "gap", "heights"]
    scene = {
        "surface": ROUGH,
        "load": {"p_star": [0.02, 0.3]},
        "material": {"E_star": "5 GPa"},
        "output": {"fields": fields, "observables": ["perimeter"]},
    }
    ran = run_scene(Scene.from_dict(scene), out="run.h5", quiet=True)
    hpc_gfmd.solve(Scene.from_dict(scene)).save("scene.h5")
    hpc_gfmd.solve(
        wall, p_star=[0.02, 0.3], E_star="5 GPa", fields=fields, observables=["perimeter"]
    ).save("memory.h5")
    run, *in_memory = (hpc_gfmd.load(f"{name}.h5") for name in ("run", "memory", "scene"))
    assert (ran.path, ran.exit_code, ran.converged) == (Path("run.h5"), 0, True)
    assert ran.steps == run.steps
    assert np.array_equal(ran[1].pressure, run[1].pressure)
    for memory in in_memory:
        assert run.result.head["identity"] == memory.result.head["identity"]
        assert set(run.result.head) == set(memory.result.head)
        assert set(run.result.surface) == set(memory.result.surface)
        for a, b in zip(run, memory, strict=True):
            assert (a.a_r, a.status, a.converged) == (b.a_r, b.status, True)
            assert a.observable("perimeter") == b.observable("perimeter")
            assert np.allclose(a.pressure, b.pressure, atol=1e-3 * a.p)
            assert np.allclose(a.gap, b.gap, atol=1e-3 * a.gap_mean)
            assert np.allclose(a.heights, b.heights, atol=1e-6 * a.h_rms)


def test_solve_takes_a_scene(tmp_path):
    """Keywords replace its keys; fields are kept even if it names none; no file is written."""
    Path("scene.toml").write_text(scene_text(solver={"residual": 1e-6}))
    solutions = hpc_gfmd.solve("scene.toml")
    assert solutions.p_star == pytest.approx([0.05, 0.1])
    assert solutions[0].pressure.mean() == pytest.approx(solutions[0].p)
    one = hpc_gfmd.solve("scene.toml", a_r=0.1, accuracy=1e-2, max_iterations=1, fields=())
    assert (one.status, one.converged) == ("max_iterations", False)
    assert one.result.scene.solver.residual is None
    with refused("shift: unknown key"):
        hpc_gfmd.solve("scene.toml", shift=1)
    with refused("none.toml: no such file"):
        hpc_gfmd.solve("none.toml")
    assert [path.name for path in tmp_path.iterdir()] == ["scene.toml"]


def test_files_and_pickles_of_solutions(sweep, saved):
    assert saved.status == "converged"
    for solution, *copies in zip(sweep, saved, pickle.loads(pickle.dumps(sweep)), strict=True):
        for copy in copies:
            assert_same(solution, copy)
            assert solution.distributions.keys() == copy.distributions.keys() == {"pressure"}
            assert copy.displacement == pytest.approx(solution.displacement, abs=1e-15)
    again = pickle.loads(pickle.dumps(sweep[2]))
    assert again.observable("patches") == sweep[2].observable("patches")
    with refused("another version"):
        pickle.loads(pickle.dumps(replace(again.result, version=2)))


@pytest.mark.parametrize("of_file", [False, True])
def test_observables_computed_later(sweep, saved, of_file):
    """They agree with those computed during the solve."""
    names = sorted(observable_names() - {"error_bounds", *response.DUALITY})
    spreads = sorted(all_distributions())
    requested = solve(LOADS, observables=names, distributions=spreads)
    for solution, with_request in zip(saved if of_file else sweep, requested, strict=True):
        for name, value in with_request.observables.items():
            if not (of_file and name in LOST and value is None):
                number = solution.observable(name)
                number = number[name] if isinstance(number, dict) else number
                assert number == (value if value is None else pytest.approx(value, rel=1e-6)), name
        assert solution.observable("patches") == with_request.observables["patches"]
        assert solution.observable("spanning") == {
            name: with_request.observables[name] for name in ("gap_spans_x", "gap_spans_y")
        }
        for name in spreads:
            computed = solution.distribution(name)
            wanted = with_request.distributions[name]
            assert computed.keys() == wanted.keys()
            for key in wanted:
                atol = 1e-9 * np.abs(wanted[key]).max()
                assert np.allclose(computed[key], wanted[key], rtol=1e-4, atol=atol), (name, key)
    assert set(all_observables()) <= set(requested[0].observables)
    assert set(requested[0].distributions) == set(all_distributions())


@pytest.mark.parametrize("boundary", ["periodic", ["free", "periodic"]])
def test_patch_table(boundary):
    """Sums agree with observables; a square across the corner of the cell is one patch, centred on
    the corner."""
    solution = solve("30 MPa", boundary=boundary, observables=["patches", "perimeter"])
    table = solution.patch_table()
    observables = solution.observables
    assert len(table) == observables["patches"]
    assert table.area[0] == observables["patch_largest"] == table.area.max()
    assert table.area.sum() == pytest.approx(solution.a_r * 120e-12)
    assert table.load.sum() == pytest.approx(solution.pressure.mean() * 120e-12, rel=1e-6)
    assert table.perimeter.sum() == pytest.approx(observables["perimeter"])
    assert table.attrs["units"]["load"] == "N"
    z = np.zeros((16, 16))
    z[np.ix_([-1, 0, 1], [-1, 0, 1])] = 1
    table = hpc_gfmd.solve(z, 0.001).patch_table()
    assert list(table.periodic) == [True]
    assert min(table.x[0], 1 - table.x[0]) + min(table.y[0], 1 - table.y[0]) < 1e-9


def test_missing_fields_and_observables_are_refused(saved):
    bare = solve(LOADS, fields=())
    assert all(solution.a_r > 0 and solution.a_r_corrected > 0 for solution in bare)
    with refused(r'^pressure: not kept, allowed: fields = \["pressure", ...\]'):
        _ = bare[0].pressure
    bare.save("bare.h5")
    loaded, *_ = hpc_gfmd.load("bare.h5")
    saved[0].observable("spanning")  # follows from the stored fields
    for call, words in [
        (lambda: loaded.gap, r"^gap: not in .*bare.h5, allowed"),
        (lambda: loaded.observable("patches"), r"^pressure, gap: not in .*bare.h5, allowed"),
        (lambda: bare[0].distribution("pressure"), "^pressure, gap: not kept, allowed: fields = "),
        (lambda: loaded.observable("duality_gap"), "^duality_gap: not in"),
        (lambda: saved[0].observable("duality_gap"), "^duality_gap: not in"),
        (lambda: saved[0].plastic, "^plastic: not in"),
        (
            lambda: loaded.distribution("presure"),
            '^distribution: found .presure., nearest: "pressure"',
        ),
        (lambda: loaded.observable("pathces"), '^observable: found .pathces., nearest: "patches"'),
    ]:
        with refused(words):
            call()


def test_loading_an_interrupted_run(sweep, saved, tmp_path):
    saved.save("stopped.h5")
    result = read_result("stopped.h5")
    Path("stopped.h5").unlink()
    path = tmp_path / "stopped.h5"
    with begin(path, result.head["identity"], result.surface, result.head) as file:
        file.write_step(1, result.steps[1], {"pressure": sweep[1].pressure, "gap": sweep[1].gap})
    assert partial_folder(path).is_dir()
    with pytest.warns(
        UserWarning,
        match=r"loads 1 \(pressure = 10 MPa\), 3 \(pressure = 200 MPa\) of 3 are missing",
    ):
        left = hpc_gfmd.load("stopped.h5")
    assert (left.status, left[0].p, left.result.indices) == ("interrupted", 3e7, [1])
    assert "200 MPa" in repr(left)
    assert "200 MPa" in left._repr_html_()
    assert np.array_equal(left[0].contact, sweep[1].contact)


def test_saving_over_other_results(sweep, tmp_path):
    path = tmp_path / "out.h5"
    sweep.save(path)
    with pytest.warns(UserWarning, match=r"out\.h5.*replaces") as caught:
        sweep.save(path)
    assert [warning.filename for warning in caught] == [__file__]
    doubled = solve(LOADS, 2 * Z, distributions=["pressure"], observables=["perimeter"])
    with refused(r"another scene"):
        doubled.save(path)
    assert_same(hpc_gfmd.load(path)[0], sweep[0])
    with pytest.warns(UserWarning, match=r"overwritten"):
        doubled.save(path, force=True)
    assert_same(hpc_gfmd.load(path)[0], doubled[0])
    with refused(r"ends in .h5"):
        sweep.save("out.npz")


def test_ctrl_c_during_a_save_leaves_no_file(saved, tmp_path, monkeypatch):
    monkeypatch.setattr(h5, "_piece", lambda *_: signal.raise_signal(signal.SIGINT))
    with pytest.raises(KeyboardInterrupt):
        saved.save("other.h5")
    assert [file.name for file in tmp_path.iterdir()] == ["saved.h5"]


def test_solve_does_not_initialise_mpi():
    """FFTW is loaded from mpi4py-fft without starting MPI, which can be started later."""
    pytest.importorskip("mpi4py_fft")
    code = (
        "import sys, numpy as np, hpc_gfmd; hpc_gfmd.solve(np.random.default_rng(1).normal(size=(8,"
        " 8)), 0.1); print('mpi4py' in sys.modules); from mpi4py import MPI;"
        " print(MPI.COMM_WORLD.Get_size()); from mpi4py_fft import PFFT, fftw;"
        " print(PFFT(MPI.COMM_SELF, (8, 8)).shape(), fftw.fftw_xfftn.FFT.__name__)"
    )
    assert printed("-c", code).split("\n")[:3] == ["False", "1", "(8, 5) FFT"]


def test_progress(capsys):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solve(LOADS[:2], progress=True)
    shown = capsys.readouterr()
    assert "load 2/2" in shown.err
    assert "(wanted 1e-03)" in shown.err
    rows = [line.split() for line in shown.err.splitlines() if line.endswith("converged")]
    assert [row[:1] + row[2:3] for row in rows] == [["0", "10"], ["1", "30"]]
    assert not shown.out
    solve(LOADS[0])
    assert capsys.readouterr() == ("", "")
