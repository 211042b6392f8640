"""`scripts/bench` with tiny contacts: rows, errors and times are consistent."""

import importlib.util
import json
import shlex
import sys
from pathlib import Path

import mpi_harness
import numpy as np
import pytest
from bench import peers, timing
from bench.cells import by_cells
from bench.command import ITEMS, make_parser
from bench.contacts import RoughContact, distance
from refusal import refused
from scene_tables import rows

from hpc_gfmd.commands.cli import main
from hpc_gfmd.util.errors import GfmdError


def read(path):
    """The rows of a file of JSON lines."""
    return [json.loads(line) for line in path.read_text().splitlines()]


@pytest.fixture
def bench(tmp_path, monkeypatch):
    """bench("item options", *options) runs a measurement: its rows."""
    for name, value in mpi_harness.environment().items():
        monkeypatch.setenv(name, value)

    def run(words, *options):
        item, *arguments = shlex.split(words)
        assert main([item, *arguments, *options, "-o", str(tmp_path)], make_parser) == 0
        path = tmp_path / f"{item}.jsonl"
        assert path.with_suffix(".txt").stat().st_size > 0
        return read(path)

    return run


@pytest.mark.parametrize(
    ("factor", "target"), [(1.0, 1e-5), (0.01, 1e-5), (30.0, 1e-4), (1.0, 1e-9)]
)
def test_loosest_tolerance_meets_the_target(factor, target):
    tolerance, row = peers._loosest(lambda t: {"error": factor * t}, target, np.inf)
    assert row["error"] == factor * tolerance
    assert 0.4 * target < row["error"] <= target
    with refused(r"found an error of 3\.0e-05", GfmdError):
        peers._loosest(lambda t: {"error": max(t, 3e-5)}, 1e-5, np.inf)


def test_timing():
    """Cases take turns; nested parts are counted once; the error of a failed process is shown."""
    assert "".join(timing.in_turn("ABC", 3)) == "ABC" + "CBA" + "ABC"
    assert timing.ratio([2.0, 3.0, 9.0], [1.0, 1.0, 1.0]) == 3.0
    made = [{"seconds": s, "cpu_seconds": s / 2, "status": "converged"} for s in (3.0, 1.0, 5.0)]
    summary = timing.summary(made)
    assert (summary["seconds_min"], summary["seconds_median"], summary["repeats"]) == (1.0, 3.0, 3)

    class Work:
        inner = staticmethod(lambda: None)

        def outer(self):
            self.inner()
            self.inner()

    reads = iter([0, 1, 3, 4, 8, 10])  # times: outer begins, inner 1-3 and 4-8, outer ends
    watch = timing.Stopwatch(lambda: next(reads))
    work = Work()
    watch.watch(work, "inner", "inner")
    watch.watch(Work, "outer", "outer")
    work.outer()
    assert watch.take() == {"inner": 6, "outer": 4}
    assert watch.take() == {"inner": 0, "outer": 0}
    with refused(r"^nonsense on 1 ranks: .*No module named bench\.nonsense", GfmdError):
        timing.run_workers("nonsense", {1: (1, {})}, 1)


@pytest.mark.slow
def test_true_errors():
    """True errors are below the requested accuracy; another discretisation of free edges differs
    slightly."""
    contact = RoughContact(64, 0.05)
    errors = [
        contact.errors(*contact.press(accuracy=accuracy, precision="double"))["error"]
        for accuracy in (1e-2, 1e-6)
    ]
    assert errors[0] < 1e-2
    assert errors[1] < 1e-6
    free = RoughContact(32, 1.0, boundary="free").at_area(0.2)
    numbers, pressure = free.reference
    assert numbers["a_r"] == pytest.approx(0.2, rel=0.03)
    assert 1e-3 < distance(by_cells(free), pressure) < 0.06


def test_rows_that_cannot_be_compared(monkeypatch):
    """The pages refuse rows of a changed tree, and rows that differ in status or tolerance."""
    path = Path(peers.__file__).parents[2] / "docs" / "_tables.py"
    spec = importlib.util.spec_from_file_location("tables_of_pages", path)
    tables = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tables)
    case = {"kind": "periodic", "n": 64, "a_r": 0.1, "asked": 1e-3, "code": "aspher"}
    row = case | {"status": "converged", "tolerance": 0.1, "provenance": {"commit": "1234567"}}
    tables.refuse_unlike([row, row, row | {"n": 128, "tolerance": 0.2}])
    for other, words in (
        ({"provenance": {"commit": "1234567+"}}, "tree with changes"),
        ({"status": "not reached"}, "status"),
        ({"tolerance": 0.2}, "tolerance"),
    ):
        with pytest.raises(ValueError, match=words):
            tables.refuse_unlike([row, row | other])


WRONG = rows("""
accuracy --n 64 --solvers nonsense | nonsense
peers --codes nonsense | --codes: found 'nonsense', allowed: aspher
peers | scripts/bench-peers-setup
peers --boundary free --codes tamaas | allowed: aspher-fft
peers --boundary free --hardness 1 | --hardness: with free edges
peers --boundary open | --boundary: found 'open', allowed: periodic, free
before --python nowhere | --python: found 'nowhere', allowed: the path of a Python
pairs --surfaces 2 | --surfaces: found 1 numbers, allowed: one for each
process --n 63 | --n: found
process --repeats 0 | --repeats: found 0
""")


def test_wrong_arguments_are_refused(monkeypatch, tmp_path, cli):
    monkeypatch.setenv("HPC_GFMD_PEERS", str(tmp_path / "nowhere"))
    cli.script = make_parser
    for arguments, words in WRONG:
        assert words in cli.refused(arguments)


SMALL = {  # of every item that needs no other code
    "process": "--n 32 --threads 1 2",
    "user": "--n 16",
    "before": "--n 16 --n-light 64",
    "light": "--n 64 --roughness 0.1 --a-r 0.01 --n-walls 64 --hurst 0.8 --a-r-walls 0.005",
    "pairs": "--n 32 64 --surfaces 2 1 --accuracy 1e-2",
    "accuracy": "--n 64 --hurst 0.8 --p-star 0.05 --solvers bpx --accuracy 1e-2 1e-4",
    "scaling": "--n 64 --ranks 1 --threads 1 --precision double",
    "storage": "--n 64",
    "releases": "--n 32",
}


@pytest.mark.slow
@pytest.mark.parametrize("item", SMALL)
def test_every_item(item, bench):
    """Rows have positive times, what was asked and where; loads reach their accuracy."""
    measured = bench(f"{item} {SMALL[item]} --repeats 1")
    assert set(SMALL) | {"peers"} == set(ITEMS)
    for row in measured:
        assert {"host", "cpu", "versions", "commit", "time", "ranks"} <= set(row["provenance"])
        assert row.get("status", "converged") == "converged"
        seconds = [value for name, value in row.items() if name.endswith("seconds")]
        assert all(value > 0 for value in seconds)
        assert item != "accuracy" or 0 < row["error"] < row["asked"]


@pytest.mark.slow
def test_peers_that_are_missing_are_left_out(bench, tmp_path, monkeypatch):
    python = tmp_path / "bin" / "python"
    python.parent.mkdir()
    python.write_text(f'#!/bin/sh\nexec {sys.executable} "$@"\n')
    python.chmod(0o755)
    monkeypatch.setenv("HPC_GFMD_PEERS", str(tmp_path))
    rows = bench("peers --n 64 --p-star 0.05 --error 1e-5 --repeats 1 --codes tamaas")
    row_of_code = {row["code"]: row for row in rows}
    assert row_of_code.pop("tamaas")["status"] == "not reached"
    assert all(row["error"] <= 1e-5 for row in row_of_code.values())
