"""`python scripts/paper`: stored runs are complete, survive damage and are not solved again."""

import errno
import gzip
import json
import os
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from paper import __main__ as command
from paper import solve
from paper.cases import Case, Store, merged
from paper.items import TEXTS
from refusal import refused
from scene_tables import rows

import hpc_gfmd
from hpc_gfmd import GfmdError

SMALL = Case(0.8, 2, 8, 2, 1, (0.05, 0.35))
CASES = [SMALL, replace(SMALL, hurst=0.3), replace(SMALL, lam_s_over_a=4)]
COMMITTED = Path(__file__).parents[3] / "docs/study/runs.jsonl.gz"
ALL = {*json.loads(gzip.decompress(COMMITTED.read_bytes()).splitlines()[0])} - {"contact_points"}


def solved(cases, store):
    """The exit code and the messages of run_missing on one process."""
    messages = []
    return solve.run_missing(cases, store, hpc_gfmd.world(), say=messages.append), messages


@pytest.fixture(scope="module")
def three(tmp_path_factory):
    store = Store(tmp_path_factory.mktemp("paper"))
    assert solved(CASES, store)[0] == 0
    return store


def test_stored_runs(three):
    runs = list(three.stored().values())
    assert len(runs) == 6
    for run in runs:
        assert set(run) == ALL
        assert run["status"] == "converged"
        assert run["a_r"] == pytest.approx(run["kappa"] * run["p_star"])
        assert 0 < run["a_r_edge"] < run["a_r"]
        assert run["gap_over_h_rms"] * run["h_rms"] == pytest.approx(
            run["gap_over_g_rms_lam_s"] * run["g_rms"] * run["lam_s"]
        )
        assert run["n"] == round(16 * run["lam_s_over_a"])


def test_stored_runs_are_not_solved_again(three, tmp_path):
    before = three.path.read_bytes()
    code, messages = solved([*CASES, *CASES], three)
    assert (code, "6 of them stored" in messages[0], three.path.read_bytes()) == (0, True, before)
    for changed in (replace(SMALL, seed=2), replace(SMALL, accuracy=1e-4)):
        assert three.missing([changed]) == [changed]
    assert {run["lam_s_over_a"] for run in three.runs_of(CASES[2:])} == {4}
    extended = replace(
        SMALL, p_star=(0.05,), observables=("perimeter",), distributions=("pressure",)
    )
    store = Store(tmp_path)
    store.append(three.runs_of([SMALL]))
    assert (store.missing([SMALL]), store.missing([extended])) == ([], [extended])
    assert solved([SMALL, extended], store)[0] == 0
    (run,) = store.runs_of([extended])
    assert set(run) == ALL | {"perimeter", "pressure_distribution"}
    density = run["pressure_distribution"]
    assert np.sum(np.diff(density["edges"]) * density["density"]) == pytest.approx(1)


@pytest.mark.parametrize("torn", [b'{"hurst": 0.8, "L_', b'{"n": 3}\n', b"\x00\xff\n", b"7\n\n"])
def test_store_survives_a_torn_line(tmp_path, torn):
    store = Store(tmp_path)
    store.append([SMALL.surface | {"p_star": 0.05, "a_r": 0.1}])
    with open(store.path, "ab") as file:
        file.write(torn)
    store.append([SMALL.surface | {"p_star": 0.35, "a_r": 0.5}])
    assert [run["a_r"] for run in store.stored().values()] == [0.1, 0.5]


def test_exit_codes(tmp_path, monkeypatch):
    """A failed case does not stop the others; a signal and a full disk do."""
    code, messages = solved([replace(SMALL, lam_s_over_a=1.5), SMALL], Store(tmp_path / "bad"))
    assert (code, len(list(Store(tmp_path / "bad").stored().values()))) == (1, 2)
    assert any(text.startswith("FAILED") and "lam_s_over_a" in text for text in messages)
    assert solved([replace(SMALL, accuracy=1e-300)], Store(tmp_path / "poor"))[0] == 3
    (tmp_path / "file").write_text("")
    with refused(r"making .*file", GfmdError):
        solved([SMALL], Store(tmp_path / "file"))

    def full(self, runs):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(Store, "append", full)
        with refused(r"runs\.jsonl: No space", GfmdError):
            solved(CASES, Store(tmp_path / "full"))
    stopped = SimpleNamespace(path=tmp_path, exit_code=143)
    monkeypatch.setattr(hpc_gfmd, "run", lambda *args, **how: stopped)
    assert solved(CASES, Store(tmp_path / "stopped"))[0] == 143
    assert list(Store(tmp_path / "stopped").stored().values()) == []


def test_loads_of_a_surface_are_one_sweep():
    loads = [replace(SMALL, p_star=p) for p in ((0.1,), (0.2, 0.05))]
    sweeps = merged([loads[0], CASES[2], SMALL, loads[1]])
    assert [case.p_star for case in sweeps] == [(0.05, 0.1, 0.2, 0.35), (0.05, 0.35)]


@pytest.fixture
def paper(cli):
    """`cli` for the command line of scripts/paper."""
    cli.script = command.make_parser
    return cli


WRONG = rows("""
fig14 | ITEM: found fig14
 | ITEM: not given
fig1 --level big | desk
fig1 --threads 0 | --threads: found '0'
""")


def test_wrong_arguments_are_refused(paper):
    for args, words in WRONG:
        assert words in paper.refused(args)


@pytest.mark.slow
def test_command(paper, tmp_path):
    lines = paper.prints("--list").splitlines()
    assert [line.split()[0] for line in lines] == list(TEXTS)
    assert "nothing stored yet" in paper.prints("fig13 --no-run -o empty")
    assert not list(tmp_path.iterdir())
    assert "to solve" in paper.prints("fig13 -o made")
    assert "to solve" not in paper.prints("fig13 -o made")
    assert (tmp_path / "made/fig13.csv").read_text().count("\n") > 10
    assert (tmp_path / "made/fig13.png").stat().st_size > 10_000
