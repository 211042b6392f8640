"""Studies: what is stored is safe and complete, what is there is not solved again, shares and
surfaces are what they claim."""

import errno
import os
import signal
from dataclasses import replace

import numpy as np
import pytest
from paper import catalogue, levels, runner
from paper.case import Case
from paper.store import Store, key_of, missing

from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.surface import build_surface
from hpc_gfmd.util.errors import GfmdError, SceneError

SMALL = Case(0.8, 2, 8, 2, 1, (0.05, 0.35))
CASES = [SMALL, replace(SMALL, hurst=0.3), replace(SMALL, lam_s_over_a=4)]
SCHEMA = {
    "hurst",
    "L_over_lam_l",
    "lam_l_over_lam_s",
    "lam_s_over_a",
    "n",
    "seed",
    "p_star",
    "accuracy",
    "eps_t",
    "eps_f",
    "eps_c",
    "h_rms",
    "g_rms",
    "lam_s",
    "a_r",
    "a_r_edge",
    "kappa",
    "kappa_edge",
    "gap_over_h_rms",
    "gap_over_g_rms_lam_s",
    "contact_points",
    "a_r_error",
    "gap_error",
    "pressure_error",
    "status",
    "iterations",
    "fft_pairs",
    "wall_seconds",
    "precision",
    "ranks",
    "version",
}


def run_of(case, p_star, **more):
    """The part of a stored run that tells it from others."""
    return (
        {name: getattr(case, name) for name in (*runner.FIELDS, "accuracy")}
        | {"p_star": p_star}
        | more
    )


def has(store, case):
    """Whether every load of the case is stored."""
    return missing(case, {key_of(run): set(run) for run in store.load()}) is None


def solve(cases, store, **how):
    """run_missing on one process, and what it said."""
    said = []
    return runner.run_missing(
        cases, store, SerialComm(), say=how.pop("say", said.append), **how
    ), said


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    store = Store(tmp_path_factory.mktemp("study"))
    return store, *solve(CASES, store)


def test_stored_runs(solved):
    store, outcome, _ = solved
    runs = store.load()
    assert (outcome.solved, outcome.exit_code, len(runs)) == (6, 0, 6)
    for run in runs:
        assert set(run) == SCHEMA
        assert run["status"] == "converged"
        assert (
            run["a_r"]
            == run["contact_points"] / run["n"] ** 2
            == pytest.approx(run["kappa"] * run["p_star"])
        )
        assert 0 < run["a_r_edge"] < run["a_r"]
        assert run["gap_over_h_rms"] * run["h_rms"] == pytest.approx(
            run["gap_over_g_rms_lam_s"] * run["g_rms"] * run["lam_s"]
        )
        assert (run["n"], run["lam_s"]) == (
            round(2 * 8 * run["lam_s_over_a"]),
            pytest.approx(1 / 16),
        )


def test_finished_ones_are_skipped(solved):
    store, *_ = solved
    before = store.path.read_bytes()
    outcome, said = solve([*CASES, *CASES], store)
    assert (outcome.solved, outcome.exit_code) == (0, 0)
    assert "6 of them stored" in said[0]
    assert store.path.read_bytes() == before
    assert all(has(store, case) for case in CASES)
    assert not has(store, replace(SMALL, seed=2))
    assert not has(store, replace(SMALL, accuracy=1e-4))
    assert {run["lam_s_over_a"] for run in store.runs_of(CASES[2:])} == {4}


@pytest.mark.parametrize(
    "torn",
    [
        b'{"hurst": 0.8, "L_over_l',
        b'{"hurst": 0.8, "n": 3}\n',
        b"\x00\xff garbage\n",
        b"7\n",
        b"\n\n",
    ],
)
def test_store_survives_a_torn_line(tmp_path, torn):
    store = Store(tmp_path)
    store.append(run_of(SMALL, 0.05, a_r=0.1))
    with open(store.path, "ab") as file:
        file.write(torn)
    assert [run["a_r"] for run in store.load()] == [0.1]
    store.append(run_of(SMALL, 0.35, a_r=0.5))
    assert [run["a_r"] for run in store.load()] == [0.1, 0.5]


@pytest.mark.parametrize("sign", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_keeps_what_is_finished(tmp_path, sign):
    store = Store(tmp_path)

    def say(text):
        if text.startswith("1/"):
            os.kill(os.getpid(), sign)

    outcome, _ = solve(CASES, store, say=say)
    assert outcome.exit_code == 128 + sign
    assert outcome.solved == len(store.load()) == 2
    outcome, _ = solve(CASES, store)
    assert (outcome.solved, outcome.exit_code) == (4, 0)
    assert len(store.path.read_text().splitlines()) == 6


def test_a_failing_case_does_not_stop_the_others(tmp_path, monkeypatch):
    bad, large = replace(SMALL, lam_s_over_a=1.5), Case(0.8, 2, 1024, 8, 1, (0.05,))
    monkeypatch.setattr("hpc_gfmd.runs.memory.available_gib", lambda: 1.0)
    outcome, said = solve([bad, large, SMALL], Store(tmp_path))
    assert (outcome.solved, outcome.exit_code, len(outcome.failed)) == (2, 1, 2)
    assert "lam_s_over_a" in outcome.failed[0]
    assert "GiB" in outcome.failed[1]
    assert sum(text.startswith("FAILED") for text in said) == 2


def test_nothing_is_solved_that_cannot_be_stored(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    with pytest.raises(GfmdError, match=r"making .*file"):
        solve([SMALL], Store(tmp_path / "file"))
    calls = []

    def full(self, run):
        calls.append(run)
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Store, "append", full)
    with pytest.raises(GfmdError, match=r"runs\.jsonl: No space left"):
        solve(CASES, Store(tmp_path / "full"))
    assert len(calls) == 1


def test_unconverged_runs_are_marked(tmp_path):
    outcome, _ = solve([replace(SMALL, accuracy=1e-300)], Store(tmp_path))
    assert (outcome.unconverged, outcome.exit_code) == (2, 3)
    assert {run["status"] for run in Store(tmp_path).load()} <= {"stagnated", "max_iterations"}


def test_large_surfaces_are_solved_in_low_memory(tmp_path, monkeypatch, solved):
    """And are the same contacts."""
    monkeypatch.setattr("paper.case.LARGE", 64)
    large = replace(CASES[2])  # one that has not made its scene
    assert large.scene().solver.low_memory
    solve([large], Store(tmp_path))
    same = sorted(solved[0].runs_of([large]), key=key_of)
    for run, plain in zip(sorted(Store(tmp_path).load(), key=key_of), same, strict=True):
        assert run["status"] == "converged"
        assert run["kappa"] == pytest.approx(plain["kappa"], rel=2e-3)


def test_cheapest_first_and_each_surface_once():
    cases = runner.merged(
        [replace(SMALL, p_star=(0.1,)), CASES[2], SMALL, replace(SMALL, p_star=(0.2, 0.05))]
    )
    assert [case.p_star for case in cases] == [(0.05, 0.1, 0.2, 0.35), (0.05, 0.35)]
    assert [case.n for case in cases] == [32, 64]


@pytest.mark.parametrize("parts", [1, 3, 16])
def test_shares_are_disjoint_and_complete(parts):
    cases = [case for name in catalogue.names() for case in catalogue.study(name).cases("paper")]
    shares = [runner.share(cases, part, parts) for part in range(1, parts + 1)]
    assert sorted((c for share in shares for c in share), key=str) == sorted(
        runner.merged(cases), key=str
    )
    costs = [sum(case.cost for case in share) for share in shares]
    assert max(costs) - min(costs) <= max(case.cost for case in runner.merged(cases))


def test_same_surface_along_an_eps_c_series():
    heights = []
    for case in [
        c
        for c in levels.eps_c_series("quick")
        if c.hurst == 0.3 and c.seed == 2 and c.lam_l_over_lam_s == 16
    ][:3]:
        surface = build_surface(case.scene().surface, SerialComm(), np.float64)
        step = round(case.lam_s_over_a / 2)
        coarse = surface.h[::step, ::step] * surface.height_unit
        heights.append((coarse - coarse.mean()) / surface.h_rms)
    assert len(heights) == 3
    for other in heights[1:]:
        assert np.abs(other - heights[0]).max() < 1e-9


@pytest.mark.parametrize("level", levels.LEVELS)
def test_levels(level):
    reference = levels.REFERENCE[level]
    for series in (levels.eps_c_series, levels.eps_f_series, levels.eps_t_series):
        cases = series(level)
        assert {case.hurst for case in cases} == set(levels.HURST)
        assert {case.p_star for case in cases} == {(levels.P_LOW, levels.P_HIGH)}
        assert reference in {(c.L_over_lam_l, c.lam_l_over_lam_s, c.lam_s_over_a) for c in cases}
        for case in cases:
            assert case.scene().n == (case.n, case.n)
    assert (
        max(case.n for case in levels.eps_f_series(level))
        <= {"quick": 512, "desk": 16384, "paper": 2**17}[level]
    )


def test_catalogue():
    beyond = ["curves", "distributions", "limit", "percolation", "stiffness"]
    assert catalogue.names() == [
        *(f"fig{k}" for k in range(1, 14)),
        *(f"table{k}" for k in range(1, 6)),
        *beyond,
    ]
    for name in catalogue.names():
        study = catalogue.study(name)
        assert (study.name, bool(study.title), bool(study.paper), bool(study.question)) == (
            name,
            True,
            True,
            name in beyond,
        )
        for level in levels.LEVELS:
            assert study.cases(level)
            assert all(
                case.scene().n == (case.n, case.n) for case in study.cases(level) if name in beyond
            )
        with pytest.raises(SceneError, match="quick, desk, paper"):
            study.cases("dusk")
    with pytest.raises(SceneError, match="nearest: 'fig1'"):
        catalogue.study("figg1")


def test_more_of_a_stored_load_is_solved_for(solved, tmp_path):
    store, more = (
        Store(tmp_path),
        replace(SMALL, p_star=(0.05,), observables=("perimeter",), distributions=("pressure",)),
    )
    for run in solved[0].runs_of([SMALL]):
        store.append(run)
    assert has(store, SMALL)
    assert not has(store, more)
    assert not store.runs_of([more])
    outcome, _ = solve([SMALL, more], store)
    assert outcome.solved == 1
    (run,) = store.runs_of([more])
    assert set(run) == SCHEMA | {"perimeter", "pressure_distribution"}
    density = run["pressure_distribution"]
    assert np.sum(np.diff(density["edges"]) * density["density"]) == pytest.approx(1)
    assert has(store, more)
    assert has(store, SMALL)
    assert solve([SMALL, more], store)[0].solved == 0
