"""Benchmarks run on tiny contacts, and what they say is consistent."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import mpi_harness
import numpy as np
import pytest
from bench import command, peers, scaling, workers
from bench.cases import Case
from bench.cells import Cells
from bench.command import make_parser
from bench.loosest import loosest
from bench.messages import LARGE
from bench.model import Machine, Network, predict
from bench.ours import Ours
from bench.passes import field_passes
from bench.reference import reference
from bench.timing import Clock, Sample, Stopwatch, ratio
from bench.workers import Worker, what_failed

from hpc_gfmd.commands import cli as command_line
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.util.errors import GfmdError


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("HPC_GFMD_CACHE", str(tmp_path / "cache"))


def main(arguments):
    return command_line.main(arguments, make_parser)


def rows(path):
    return [json.loads(line) for line in path.read_text().splitlines()]


@pytest.mark.parametrize(
    ("factor", "start"), [(1.0, 1e-5), (0.01, 1e-5), (30.0, 1e-4), (1.0, 1e-9)]
)
def test_loosest_tolerance_is_close_to_the_edge(factor, start):
    tolerance, error = loosest(lambda t: factor * t, 1e-5, start)
    assert error <= 1e-5
    assert error == factor * tolerance
    assert error * 2.1 > 1e-5


def test_loosest_tells_when_nothing_is_good_enough():
    tolerance, error = loosest(lambda t: max(t, 3e-5), 1e-5, 1e-4)
    assert tolerance is None
    assert error == 3e-5


def test_runs_alternate_after_the_warm_up():
    calls = []
    samples = Clock().alternate(
        {"a": lambda: calls.append("a"), "b": lambda: calls.append("b")}, 3, warmup=1
    )
    assert "".join(calls) == "ab" + "ab" + "ba" + "ab"
    assert [len(s.seconds) for s in samples.values()] == [3, 3]
    assert ratio(Sample((2.0, 3.0, 9.0)), Sample((1.0, 1.0, 1.0))) == 3.0


def test_the_time_of_an_inner_part_is_counted_once():
    reads = iter([0, 1, 3, 4, 8, 10])  # of the clock: outer begins, inner 1-3 and 4-8, outer ends
    watch = Stopwatch(("inner", "outer"), lambda: next(reads))
    inner = watch.timed("inner", lambda: None)
    watch.timed("outer", lambda: [inner(), inner()])()
    assert watch.seconds == {"inner": 6, "outer": 4}


def test_traffic_of_an_iteration_is_about_fifteen_fields():
    shapes = [(1024 >> k, 1024 >> k) for k in range(11)]
    assert 14 < sum(field_passes(shapes).values()) < 15


def test_reference_is_kept_and_true_errors_fall():
    case = Case(64, 0.8, 0.05)
    known, again, ours = reference(case), reference(case), Ours(case)
    np.testing.assert_array_equal(known.pressure, again.pressure)
    assert known.pressure.mean() == pytest.approx(0.05, rel=1e-8)
    errors = [
        max(known.errors(s.a_r, s.gap_mean, s.pressure))
        for s in (ours.solve(1e-2), ours.solve(1e-6, nested=False))
    ]
    assert errors[0] < 1e-2
    assert errors[1] < 1e-6


def test_free_edges_are_a_property_of_the_case():
    """Both discretisations have the load and the area asked for; they differ where waves of two
    points are pressed, and only there."""
    coarse, fine = (
        replace(Case(32, 0.8, 1.0, boundary="free"), **more).at_area(0.2)
        for more in ({}, {"n": 64})
    )
    for case in (coarse, fine):
        known, of_others = reference(case), reference(case.of_others)
        assert known.pressure.mean() == pytest.approx(case.p_star, rel=1e-8)
        assert known.a_r == pytest.approx(0.2, rel=0.03)
        assert 1e-3 < known.pressure_error(of_others.pressure - known.pressure) < 0.06
    assert Case(32, 0.8, 0.05).of_others.body == Case(32, 0.8, 0.05).body


def test_pressure_constant_on_cells():
    """The displacement by a pressure on one cell, there and on the cells around, by quadrature."""
    grid = Grid((24, 16), (2.4, 3.2), nominal=(12, 8))
    fill, out = Cells((True, True)).compliance_rows(grid), np.empty((24, 16))
    fill(0, 24, out)
    a_x, a_y = (s / grid.a for s in grid.spacings)
    x, y = ((np.arange(400) + 0.5) / 400 - 0.5 for _ in range(2))
    for i, j in ((1, 0), (0, 3), (-2, 5), (12, -1)):
        r = np.hypot(a_x * (i + x)[:, None], a_y * (j + y))
        assert out[i, j] == pytest.approx(np.mean(1 / r) * a_x * a_y / np.pi, rel=1e-5)
    assert out[0, 0] == out.max()


def test_accuracy_writes_table_lines_and_picture(tmp_path):
    where = tmp_path / "out"
    assert (
        main(
            [
                "accuracy",
                "--n",
                "64",
                "--hurst",
                "0.8",
                "--p-star",
                "0.05",
                "--solvers",
                "bpx",
                "--precision",
                "double",
                "--accuracy",
                "1e-2",
                "1e-4",
                "--quick",
                "--repeats",
                "1",
                "-o",
                str(where),
            ]
        )
        == 0
    )
    found = rows(where / "accuracy.jsonl")
    assert [(r["start"], r["accuracy"]) for r in found] == [
        ("nested", 1e-2),
        ("nested", 1e-4),
        ("cold", 1e-2),
        ("cold", 1e-4),
    ]
    assert all(
        0 < r["error"] < r["accuracy"] and r["fft_pairs"] > 0 and r["seconds_min"] > 0
        for r in found
    )
    assert {"host", "cpu", "versions", "commit", "time", "threads", "ranks"} <= set(
        found[0]["provenance"]
    )
    assert len((where / "accuracy.txt").read_text().splitlines()) == 2 + len(found)
    assert (where / "accuracy.png").stat().st_size > 10_000


def test_peers_without_peers_compares_our_precisions(tmp_path):
    assert (
        main(
            [
                "peers",
                "--n",
                "64",
                "--p-star",
                "0.05",
                "--codes",
                "--repeats",
                "2",
                "-o",
                str(tmp_path),
            ]
        )
        == 0
    )
    found = rows(tmp_path / "peers.jsonl")
    assert [r["code"] for r in found] == ["hpc-gfmd single", "hpc-gfmd double"]
    assert all(r["error"] <= 1e-5 for r in found)
    assert all(r["times_slower"] > 0 for r in found)
    assert (
        main(
            [
                "peers",
                "--n",
                "64",
                "--boundary",
                "free",
                "--codes",
                "--repeats",
                "1",
                "-o",
                str(tmp_path),
            ]
        )
        == 0
    )
    found = rows(tmp_path / "peers.jsonl")
    assert [(r["code"], round(r["a_r"], 1)) for r in found[::2]] == [
        ("hpc-gfmd single", 0.0),
        ("hpc-gfmd single", 0.2),
    ]
    assert all(r["error"] <= 1e-5 and r["boundary"] == "free" for r in found)


FAKE = """
import numpy as np
from types import SimpleNamespace

def solve_nested(tol, **_):
    known = np.load({path!r})
    noise = np.random.default_rng(1).standard_normal(known.shape)
    pressure = known + 3 * tol * noise * np.linalg.norm(known) / np.linalg.norm(noise)
    return SimpleNamespace(pressure=pressure, iterations=7, status="converged")
"""


def test_another_code_is_given_the_loosest_tolerance_that_will_do(tmp_path, monkeypatch):
    """A stand-in for ASPHER whose true error is three times its tolerance; one that is not
    installed is said and left out."""
    np.save(tmp_path / "known.npy", reference(Case(64, 0.8, 0.05)).pressure)
    (tmp_path / "aspher.py").write_text(FAKE.format(path=str(tmp_path / "known.npy")))
    python = tmp_path / "bin" / "python"
    python.parent.mkdir()
    python.write_text(f'#!/bin/sh\nPYTHONPATH={tmp_path} exec {sys.executable} "$@"\n')
    python.chmod(0o755)
    monkeypatch.setenv("HPC_GFMD_PEERS", str(tmp_path))
    assert (
        main(
            [
                "peers",
                "--n",
                "64",
                "--p-star",
                "0.05",
                "--precision",
                "double",
                "--codes",
                "aspher",
                "tamaas",
                "--repeats",
                "2",
                "-o",
                str(tmp_path),
            ]
        )
        == 0
    )
    found = {row["code"]: row for row in rows(tmp_path / "peers.jsonl")}
    ours, aspher, tamaas = (found[code] for code in ("hpc-gfmd double", "aspher", "tamaas"))
    assert aspher["error"] == pytest.approx(3 * aspher["tolerance"], rel=1e-6)
    assert 0.4e-5 < aspher["error"] <= 1e-5
    assert (aspher["iterations"], aspher["repeats"], aspher["in_turn"], ours["times_slower"]) == (
        7,
        2,
        "yes",
        1.0,
    )
    assert (tamaas["status"], "seconds_min" in tamaas) == ("not reached", False)
    assert "No module named 'tamaas'" in (tmp_path / "peers.txt").read_text()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["accuracy", "--solvers", "nonsense"], "--solvers: found 'nonsense', allowed: bpx"),
        (["peers", "--codes", "nonsense"], "--codes: found 'nonsense', allowed: aspher"),
        (["peers"], "scripts/bench-peers-setup"),
        (
            ["peers", "--boundary", "free", "--codes", "tamaas"],
            "--codes: found 'tamaas', allowed: aspher-fft",
        ),
        (["fft", "--n", "63"], "--n: found"),
        (["kernels", "--repeats", "0"], "--repeats: found 0"),
    ],
)
def test_wrong_arguments_are_one_line_and_code_2(arguments, says, monkeypatch, tmp_path, cli):
    monkeypatch.setenv("HPC_GFMD_PEERS", str(tmp_path / "nowhere"))
    cli.script = make_parser
    assert says in cli.refused(*arguments)


def test_transforms(tmp_path):
    """In a process of its own: PFFT starts MPI."""
    pytest.importorskip("mpi4py_fft")
    subprocess.run(
        [
            sys.executable,
            Path(command.__file__).parent,
            "fft",
            "--n",
            "64",
            "--precision",
            "single",
            "--repeats",
            "2",
            "-o",
            tmp_path,
        ],
        check=True,
        capture_output=True,
    )
    found = rows(tmp_path / "fft.jsonl")
    assert len(found) == 3
    assert all(r["ms_min"] > 0 for r in found)


def test_kernels(tmp_path, monkeypatch):
    """Passes on one core and on two; what a node allows is bound by its cores or by its memory."""
    pytest.importorskip("mpi4py_fft")
    monkeypatch.setenv("OMPI_ALLOW_RUN_AS_ROOT", "1")
    monkeypatch.setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
    assert (
        main(
            [
                "kernels",
                "--n",
                "64",
                "--precision",
                "single",
                "--repeats",
                "2",
                "-o",
                str(tmp_path),
            ]
        )
        == 0
    )
    found = rows(tmp_path / "kernels.jsonl")
    assert [r["cores"] for r in found] == [1] * 8 + [2] * 7  # FFTW's own plan is for one
    passes = [r for r in found if "bytes_per_point" in r]
    assert all(
        r["gb_per_s"] == pytest.approx(r["bytes_per_point"] / r["ns_per_point"]) for r in passes
    )
    for row in (r for r in passes if r["cores"] == 1):
        memory = row["bytes_per_point"] / Machine.bandwidth * 1e9
        assert row["node_ns_per_point"] == pytest.approx(
            max(row["ns_per_point"] / Machine.cores, memory)
        )
        assert row["node_of_bandwidth"] == pytest.approx(memory / row["node_ns_per_point"])


def test_storage(tmp_path):
    assert (
        main(
            [
                "storage",
                "--n",
                "64",
                "--repeats",
                "1",
                "--folder",
                str(tmp_path),
                "-o",
                str(tmp_path / "out"),
            ]
        )
        == 0
    )
    found = rows(tmp_path / "out" / "storage.jsonl")
    assert [r["way"] for r in found] == ["raw", "raw, one file", "result file, serial", "read back"]
    assert found[2]["times_raw"] == pytest.approx(found[2]["seconds"] / found[0]["seconds"])
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_scaling_of_one_rank(tmp_path):
    """Strong, and weak, which is the same; the model says of one core what was measured."""
    assert (
        main(
            [
                "scaling",
                "--n",
                "64",
                "--ranks",
                "1",
                "--threads",
                "1",
                "--precision",
                "double",
                "--repeats",
                "1",
                "-o",
                str(tmp_path),
            ]
        )
        == 0
    )
    found = rows(tmp_path / "scaling.jsonl")
    assert [r["kind"] for r in found] == ["strong", "weak"]
    for row in found:
        assert row["efficiency"] == 1
        assert sum(
            share for key, share in row.items() if key.startswith("share_")
        ) == pytest.approx(1)
    assert Machine.from_row(found[0]).call == 0
    machine = Machine.from_row(found[0], found[0] | {"seconds": found[0]["seconds"] / 10})
    assert machine.call > 0
    alone = predict(64, 1, replace(machine, cores=1), Network(latency=0))
    assert alone["seconds"] == pytest.approx(found[0]["seconds"])
    modelled = rows(tmp_path / "scaling-model.jsonl")
    assert {(row["n"], row["network_gb_per_s"]) for row in modelled} == {
        (n, link) for n in (2**15, 2**17) for link in (7, 12.5, 25)
    }
    assert all(
        row["ranks"] <= row["n"] and row["of_one_node"] <= 1 and row["of_bandwidth"] <= 1
        for row in modelled
    )
    assert (tmp_path / "scaling.png").stat().st_size > 10_000


def test_model_counts_what_ranks_send():
    """A network without bandwidth or latency of its own costs nothing; each has its price
    otherwise."""
    machine = Machine(
        fft=1e-10, kernel=5e-9, levels=0, pairs=7, coarse_pairs=3, cores=8, barrier=0, halo=0
    )
    free = Network(latency=0, overhead=0, bandwidth=1e30)
    one, eight = (predict(4096, nodes, machine, free, 8) for nodes in (1, 8))
    assert eight["of_one_node"] > 0.96  # the rest: coarse grids are on fewer ranks
    gathered = predict(4096, 8, replace(machine, levels=0.05), free, 8)
    assert 0.9 < gathered["of_one_node"] < eight["of_one_node"]
    for slower in (
        replace(free, latency=1e-4),
        replace(free, overhead=1e-4),
        replace(free, bandwidth=1e9),
    ):
        assert predict(4096, 8, machine, slower, 8)["seconds"] > 1.2 * eight["seconds"]
    assert predict(4096, 1024, machine, free, 8) is None
    crowded = predict(4096, 1, replace(machine, bandwidth=1e9), free, 8)
    assert crowded["seconds"] > 3 * one["seconds"]
    assert (
        crowded["of_bandwidth"] > 0.98
    )  # what is transposed within the node is read where it stands
    for slower in (
        replace(machine, barrier=1e-3),
        replace(machine, halo=1e-3),
        replace(machine, call=1e-2),
    ):
        assert predict(4096, 1, slower, free, 8)["seconds"] > 1.2 * one["seconds"]


AS_ROOT = """----------------
mpirun has detected an attempt to run as root.

Running as root is *strongly* discouraged as any mistake can be costly.
We reiterate our advice against doing so - please proceed at your own risk.
----------------
"""
OURS = """Traceback (most recent call last):
  File "scaling_worker.py", line 3, in main
ValueError: nothing to solve
----------------
Primary job  terminated normally, but 1 process returned a non-zero exit code.
----------------
"""


def test_a_failing_launcher_is_quoted_by_the_line_that_says_most():
    """mpirun puts what it has to say between lines of dashes, and good advice at the end."""
    for stderr, line in (
        (AS_ROOT, "mpirun has detected an attempt to run as root."),
        (OURS, "ValueError: nothing to solve"),
        ("", "?"),
        ("-----\nno such host\n-----\n", "no such host"),
    ):
        assert what_failed(stderr) == line
    with pytest.raises(
        GfmdError, match=r"^nonsense on 1 rank failed: .*No module named bench\.nonsense"
    ):
        Worker("nonsense", 1)


def test_workers_take_turns_and_are_closed(monkeypatch):
    calls = []

    def worker(name):
        return SimpleNamespace(
            measure=lambda: calls.append(name) or len(calls),
            close=lambda: calls.append(name.lower()),
        )

    monkeypatch.setattr(workers, "Worker", worker)
    assert workers.measured({1: "A", 2: "B", 3: "C"}, 3) == {
        1: [1, 6, 7],
        2: [2, 5, 8],
        3: [3, 4, 9],
    }
    assert "".join(calls) == "ABC" + "CBA" + "ABC" + "cba"


def test_messages_of_this_machine(monkeypatch):
    """Two ranks measure as often as they are asked, and end when nobody asks any more."""
    if mpi_harness.missing():
        pytest.skip(f"{mpi_harness.missing()} is missing")
    for name, value in mpi_harness.environment().items():
        monkeypatch.setenv(name, value)
    worker = Worker("messages", 2)
    first, second = worker.measure(), worker.measure()
    worker.close()
    assert first.keys() == second.keys() == {"ranks", *scaling.MESSAGES}
    assert all(0 < value < np.inf for value in (*first.values(), *second.values()))
    assert first["latency"] < LARGE / first["bandwidth"]


def test_worker_stands_alone():
    assert "hpc_gfmd" not in Path(peers.__file__).with_name("peer_worker.py").read_text()
