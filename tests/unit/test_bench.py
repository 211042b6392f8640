"""Measurements of tiny contacts, and what they say is consistent."""

import json
import shlex
import sys
from dataclasses import replace

import mpi_harness
import numpy as np
import pytest
from bench import peers, releases, timing
from bench.cells import by_cells, love
from bench.command import make_parser
from bench.contacts import RoughContact, distance
from bench.kernels import field_passes
from bench.model import Machine, predict
from refusal import refused
from scene_tables import rows

from hpc_gfmd.commands.cli import main
from hpc_gfmd.util.errors import GfmdError


def read(path):
    """Rows of a table."""
    return [json.loads(line) for line in path.read_text().splitlines()]


@pytest.fixture
def bench(tmp_path, monkeypatch):
    """bench("item options", *options): its rows."""
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
def test_loosest_tolerance_is_close_to_the_edge(factor, target):
    tolerance, row = peers._loosest(lambda t: {"error": factor * t}, target, np.inf)
    assert row["error"] == factor * tolerance
    assert 0.4 * target < row["error"] <= target
    with refused(r"found an error of 3\.0e-05", GfmdError):
        peers._loosest(lambda t: {"error": max(t, 3e-5)}, 1e-5, np.inf)


def test_times():
    """All take turns; the time of an inner part is counted once; of a failing process its last
    words are told."""
    assert "".join(timing.in_turn("ABC", 3)) == "ABC" + "CBA" + "ABC"
    assert timing.ratio([2.0, 3.0, 9.0], [1.0, 1.0, 1.0]) == 3.0
    made = [{"seconds": s, "cpu_seconds": s / 2, "status": "converged"} for s in (3.0, 1.0, 5.0)]
    found = timing.summary(made)
    assert (found["seconds_min"], found["seconds_median"], found["repeats"]) == (1.0, 3.0, 3)

    class Work:
        inner = staticmethod(lambda: None)

        def outer(self):
            self.inner()
            self.inner()

    reads = iter([0, 1, 3, 4, 8, 10])  # of the clock: outer begins, inner 1-3 and 4-8, outer ends
    watch, work = timing.Stopwatch(lambda: next(reads)), Work()
    watch.watch(work, "inner", "inner")
    watch.watch(Work, "outer", "outer")
    work.outer()
    assert watch.take() == {"inner": 6, "outer": 4}
    assert watch.take() == {"inner": 0, "outer": 0}
    with refused(r"^nonsense on 1 ranks: .*No module named bench\.nonsense", GfmdError):
        timing.run_workers("nonsense", {1: (1, {})}, 1)


def test_true_errors():
    """They fall with what is asked; other discretisations of free edges differ where waves of two
    points are pressed, and only there."""
    contact = RoughContact(64, 0.05)
    errors = [
        contact.errors(*contact.press(accuracy=accuracy, precision="double"))["error"]
        for accuracy in (1e-2, 1e-6)
    ]
    assert errors[0] < 1e-2
    assert errors[1] < 1e-6
    free = RoughContact(32, 1.0, boundary="free").at_area(0.2)
    known, pressure = free.reference
    assert known["a_r"] == pytest.approx(0.2, rel=0.03)
    assert 1e-3 < distance(by_cells(free), pressure) < 0.06


def test_pressure_constant_on_cells():
    """The displacement by a pressure on one cell, there and on the cells around, by quadrature."""
    half = 0.4, 0.8
    i, j = np.arange(-3, 4), np.arange(-3, 4)
    found = love(2 * half[0] * i, 2 * half[1] * j, *half)
    x, y = ((np.arange(400) + 0.5) / 200 - 1 for _ in range(2))
    for k, m in ((1, 0), (0, 3), (-2, 1), (3, -1)):
        r = np.hypot(half[0] * (2 * k + x)[:, None], half[1] * (2 * m + y))
        assert found[k + 3, m + 3] == pytest.approx(
            np.mean(1 / r) * 4 * half[0] * half[1] / np.pi, rel=1e-5
        )
    assert found[3, 3] == found.max()


def test_accuracy(bench, tmp_path):
    found = bench(
        "accuracy --n 64 --hurst 0.8 --p-star 0.05 --solvers bpx --precision double"
        " --accuracy 1e-2 1e-4 --repeats 1"
    )
    assert [(row["start"], row["asked"]) for row in found] == [
        (start, asked) for start in ("nested", "cold") for asked in (1e-2, 1e-4)
    ]
    assert all(0 < row["error"] < row["asked"] and row["fft_pairs"] > 0 for row in found)
    where = found[0]["provenance"]
    assert {"host", "cpu", "versions", "commit", "time", "ranks"} <= set(where)
    assert where["versions"]["FFT"]
    assert (tmp_path / "accuracy-pairs.png").stat().st_size > 10_000


FAKE = """
import numpy as np
from types import SimpleNamespace

def solve_nested(tol, **_):
    known = np.load({path!r})
    noise = np.random.default_rng(1).standard_normal(known.shape)
    pressure = known + 3 * tol * noise * np.linalg.norm(known) / np.linalg.norm(noise)
    return SimpleNamespace(pressure=pressure, iterations=7, status="converged")
"""


def test_peers(bench, tmp_path, monkeypatch):
    """A stand-in for ASPHER whose true error is three times its tolerance is given the loosest that
    will do; a code that is not installed is said and left out."""
    np.save(tmp_path / "known.npy", RoughContact(64, 0.05).reference[1])
    (tmp_path / "aspher.py").write_text(FAKE.format(path=str(tmp_path / "known.npy")))
    python = tmp_path / "bin" / "python"
    python.parent.mkdir()
    python.write_text(f'#!/bin/sh\nPYTHONPATH={tmp_path} exec {sys.executable} "$@"\n')
    python.chmod(0o755)
    monkeypatch.setenv("HPC_GFMD_PEERS", str(tmp_path))
    command = "peers --n 64 --p-star 0.05 --error 1e-5 --repeats 2 --codes aspher tamaas"
    found = {row["code"]: row for row in bench(command)}
    aspher, tamaas = found["aspher"], found["tamaas"]
    assert aspher["error"] == pytest.approx(3 * aspher["tolerance"], rel=1e-6)
    assert 0.4e-5 < aspher["error"] <= 1e-5
    assert (aspher["iterations"], aspher["repeats"]) == (7, 3)
    assert tamaas["status"] == "not reached"
    assert "No module named 'tamaas'" in (tmp_path / "peers.txt").read_text()
    ours = [found[f"hpc-gfmd {precision}"] for precision in ("single", "double")]
    assert 1.0 in [row["seconds_over_ours"] for row in ours]  # of the fastest of them
    for row in ours:
        assert row["error"] <= 1e-5
        assert row["options"]["precision"] in row["code"]
        assert row["code_versions"]["hpc-gfmd"]
        assert row["peak_mib"] > 0


@pytest.mark.parametrize(
    ("arguments", "says"),
    rows("""
accuracy --solvers nonsense | nonsense
peers --codes nonsense | --codes: found 'nonsense', allowed: aspher
peers | scripts/bench-peers-setup
peers --boundary free --codes tamaas | allowed: aspher-fft
peers --boundary free --hardness 1 | --hardness: with free edges
peers --boundary open | --boundary: found 'open', allowed: periodic, free
pairs --surfaces 2 | --surfaces: found 1 numbers, allowed: one for each
kernels --n 63 | --n: found
kernels --repeats 0 | --repeats: found 0
"""),
)
def test_wrong_arguments_are_one_line_and_code_2(arguments, says, monkeypatch, tmp_path, cli):
    monkeypatch.setenv("HPC_GFMD_PEERS", str(tmp_path / "nowhere"))
    cli.script = make_parser
    assert says in cli.refused(arguments)


def test_kernels(bench):
    """Passes on one core and on two, with bytes of about fifteen fields an iteration."""
    pytest.importorskip("mpi4py_fft")
    assert 14 < sum(field_passes([(1024 >> k, 1024 >> k) for k in range(11)]).values()) < 15
    found = bench("kernels --n 64 --precision single --repeats 2")
    assert [row["cores"] for row in found] == [1] * 8 + [2] * 7  # FFTW's own plan is for one
    for row in found:
        if "bytes_per_point" in row:
            assert row["gb_per_s"] == pytest.approx(row["bytes_per_point"] / row["ns_per_point"])


def test_storage(bench, tmp_path):
    found = bench("storage --n 64 --repeats 1 --folder", str(tmp_path))
    assert [row["way"] for row in found] == ["raw", "raw, one file", "result file, serial"]
    assert found[2]["times raw"] == pytest.approx(found[2]["seconds"] / found[0]["seconds"])
    assert {path.suffix for path in tmp_path.iterdir()} == {".jsonl", ".txt"}


def test_pairs_are_means_over_surfaces(bench):
    found = bench("pairs --n 32 64 --surfaces 2 1 --accuracy 1e-2")
    assert [(row["loads"], row["converged"]) for row in found] == [(4, 4), (2, 2)]
    assert all(0 < row["iterations"] < row["fft_pairs"] <= row["largest"] for row in found)


def test_one_process_and_releases(bench, tmp_path, monkeypatch):
    found = bench("process --n 32 --threads 1 2 --repeats 1")
    assert [row["threads"] for row in found] == [1, 2]
    assert all(0 < row["outside_passes"] < 1 and row["cold_seconds"] > 0 for row in found)
    monkeypatch.setattr(releases, "SCENES", {"layer": releases.SCENES["layer"]})
    for count in (1, 2):  # the rows of another release are added
        found = bench("releases --n 32 --repeats 1")
        assert len(found) == count
        assert {row["status"] for row in found} == {"converged"}
    assert (tmp_path / "releases.png").stat().st_size > 10_000


def test_scaling(bench, tmp_path):
    """The model says of one core what was measured, and no more ranks than rows."""
    found = bench("scaling --n 64 --ranks 1 --threads 1 --precision double --repeats 1")
    assert [(row["kind"], row["efficiency"]) for row in found] == [("strong", 1), ("weak", 1)]
    small = found[0] | {"seconds_min": found[0]["seconds_min"] / 10}
    machine = Machine.of(found[0], small)
    assert machine.call > 0
    alone = predict(64, 1, replace(machine, cores=1, latency=0))
    assert alone["seconds"] == pytest.approx(found[0]["seconds_min"])
    modelled = read(tmp_path / "scaling-model.jsonl")
    assert {(row["n"], row["link_gb_per_s"]) for row in modelled} == {
        (n, link) for n in (2**15, 2**17) for link in (7, 12.5, 25)
    }
    assert {row["of_one_node"] for row in modelled if row["nodes"] == 1} == {1}
    assert (tmp_path / "scaling.png").stat().st_size > 10_000


def test_model_counts_what_ranks_send():
    """A network without bandwidth or latency of its own costs nothing; each has its price
    otherwise."""
    free = Machine(
        work=2.5e-10,
        levels=0,
        pairs=7,
        coarse_pairs=3,
        cores=8,
        barrier=0,
        halo=0,
        latency=0,
        overhead=0,
        link=1e30,
    )
    one, eight = (predict(4096, nodes, free) for nodes in (1, 8))
    assert eight["of_one_node"] > 0.96  # the rest: coarse grids are on fewer ranks
    gathered = predict(4096, 8, replace(free, levels=0.05))
    assert 0.9 < gathered["of_one_node"] < eight["of_one_node"]
    for price in ({"latency": 1e-4}, {"overhead": 1e-4}, {"link": 1e9}):
        assert predict(4096, 8, replace(free, **price))["seconds"] > 1.2 * eight["seconds"]
    assert predict(4096, 1024, free) is None
    crowded = predict(4096, 1, replace(free, bandwidth=1e9))
    assert crowded["seconds"] > 3 * one["seconds"]
    assert crowded["of_bandwidth"] > 0.9
    for price in ({"barrier": 1e-3}, {"halo": 1e-3}, {"call": 1e-2}):
        assert predict(4096, 1, replace(free, **price))["seconds"] > 1.2 * one["seconds"]
