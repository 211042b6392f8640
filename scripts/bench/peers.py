"""This package against other codes: time at equal true error of the pressure field, on the same
surfaces, one thread each.

A code's tolerance says little about its error, so every code is first given the loosest tolerance
at which its true error (relative L2 norm of the pressure field against a reference solved far
tighter) is below the same target. Then all run in turn.

With free edges the others take the pressure as constant on the cells of grid points, we as
band-limited: two discretisations of one contact. Each code is then judged by the exact solution of
its own.
"""

import json
import os
import subprocess
import tempfile
import time
from argparse import Namespace
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np

from hpc_gfmd.util.errors import GfmdError, SceneError

from .cases import Case
from .loosest import PATIENCE, loosest
from .ours import Ours
from .reference import Reference, reference
from .report import Report, one_of
from .timing import in_turn

NAMES = {
    "periodic": (
        "aspher",
        "aspher-float",
        "aspher-mixed",
        "tamaas",
        "contactmechanics-pk",
        "contactmechanics-ccg",
    ),
    "free": (
        "aspher-fft",
        "aspher-fft-mixed",
        "aspher-h2",
        "aspher-h2-active",
        "aspher-h2-active-float",
        "aspher-h2-active-q8",
        "contactmechanics-free-pk",
        "contactmechanics-free-ccg",
    ),
}
LOADS = {
    "periodic": {"p_star": [0.007, 0.353]},
    "free": {"a_r": [0.02, 0.2]},
}  # where none are asked for
COLUMNS = {
    "n": ("n", "5d"),
    "p_star": ("p*", "8.4g"),
    "a_r": ("a_r", "6.4f"),
    "code": ("code", "<25"),
    "tolerance": ("tolerance", "9.2g"),
    "error": ("L2 error", "9.2g"),
    "iterations": ("iter", "6d"),
    "seconds_min": ("s (min)", "9.3g"),
    "seconds_median": ("s (median)", "10.3g"),
    "cpu_seconds_min": ("cpu s (min)", "11.3g"),
    "repeats": ("runs", "4d"),
    "in_turn": ("in turn", "7"),
    "times_slower": ("x ours", "7.1f"),
    "cpu_times_slower": ("x (cpu)", "7.1f"),
    "status": ("status", "<13"),
}


def peers_python() -> Path:
    """The interpreter of the environment that scripts/bench-peers-setup makes. Raises SceneError
    where there is none."""
    root = os.environ.get("HPC_GFMD_PEERS") or Path(__file__).resolve().parents[2] / ".venv-peers"
    python = Path(root) / "bin" / "python"
    if not python.exists():
        raise SceneError(
            f"bench peers: found no {python}, allowed: an environment made by"
            " scripts/bench-peers-setup (HPC_GFMD_PEERS names another folder)"
        )
    return python


class _Peer:
    """A process that solves with another code; known: its Reference; first: its first tolerance
    over the error wanted."""

    first = 1

    def __init__(
        self, name: str, python: Path, folder: str, heights: Path, pressure: float, known: Reference
    ):
        self.name, self.heights, self.load, self.pressure_path = (
            name,
            heights,
            pressure,
            Path(folder) / f"{name}.npy",
        )
        self.known = known
        environment = {
            k: v
            for k, v in os.environ.items()
            if not k.startswith(("PYTHON", "OMPI_", "PMI", "VIRTUAL_ENV"))
        }
        environment["OMP_NUM_THREADS"] = "1"
        self.process: Any = subprocess.Popen(
            [python, Path(__file__).with_name("peer_worker.py"), name],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env=environment,
        )

    def _ask(self, **what: object) -> dict[str, Any]:
        try:
            self.process.stdin.write(json.dumps(what) + "\n")
            self.process.stdin.flush()
            line = self.process.stdout.readline()
        except BrokenPipeError:
            line = ""
        answer = json.loads(line) if line else {"error": "the process died"}
        if "error" in answer:
            raise GfmdError(f"{self.name}: {answer['error']}")
        return answer

    def prepare(self) -> None:
        """Let it plan."""
        self._ask(heights=str(self.heights), pressure=self.load)

    def solve(self, tolerance: float) -> tuple[dict[str, Any], np.ndarray]:
        """Numbers of the solve, and the pressure field."""
        answer = self._ask(tolerance=tolerance, pressure_to=str(self.pressure_path))
        return answer, np.load(self.pressure_path)

    def close(self) -> None:
        """End the process."""
        self.process.stdin.close()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()


class _We:
    """This package's default solver in one precision, with the same methods. Only the pressure
    field is asked for, as of the others: its tolerance is the residual, because `accuracy` goes on
    until the area and the mean gap are as good."""

    first = 100

    def __init__(self, case: Case, precision: Literal["single", "double"], known: Reference):
        self.name, self.case, self.precision, self.known = (
            f"hpc-gfmd {precision}",
            case,
            precision,
            known,
        )

    def prepare(self) -> None:
        """Plan and compile."""
        self.ours = Ours(self.case, self.precision)
        self.ours.solve(None, residual=1.0)

    def solve(self, tolerance: float) -> tuple[dict[str, Any], np.ndarray]:
        """Numbers of the solve, and the pressure field."""
        solved = self.ours.solve(None, residual=tolerance)
        return {
            "seconds": solved.seconds,
            "cpu_seconds": solved.cpu_seconds,
            "iterations": solved.iterations,
            "status": solved.status,
            "fft_pairs": solved.fft_pairs,
        }, solved.pressure

    def close(self) -> None:
        """Give the memory back."""
        del self.ours


Code = _Peer | _We
Maker = Callable[[], Code]


def bench_peers(args: Namespace) -> None:
    """All codes on all surfaces. args: n, p_star or a_r (None: LOADS), precision, codes (lists;
    codes None: all), hurst, boundary, error, repeats, budget (seconds after which a code is not run
    again on a case), out. Raises SceneError for a code that is not known or not there."""
    names = NAMES[args.boundary]
    codes = names if args.codes is None else args.codes
    one_of("--codes", codes, names)
    python = peers_python() if codes else Path()
    report = Report("peers", COLUMNS, args.out)
    report.say(
        f"# equal true error: relative L2 of the pressure field <= {args.error:g}; {args.boundary},"
        f" H = {args.hurst}, L/lam_l = 2, lam_s/a = 2, seed 1; x: median over runs in turn of the"
        " time over that of our faster precision"
    )
    with tempfile.TemporaryDirectory() as folder:
        for n in args.n:
            for case in _cases(n, args):
                known, of_others = reference(case), reference(case.of_others)
                heights = Path(folder) / "heights.npy"
                np.save(heights, -case.gap())
                makers: list[Maker] = [
                    partial(_We, case, precision, known) for precision in args.precision
                ]
                makers += [
                    partial(_Peer, name, python, folder, heights, case.p_star, of_others)
                    for name in codes
                ]
                _one_case(case, makers, args, report)
    report.finish()


def _cases(n: int, args: Namespace) -> list[Case]:
    asked = {
        key: getattr(args, key) for key in ("p_star", "a_r") if getattr(args, key) is not None
    } or LOADS[args.boundary]
    case = Case(n, args.hurst, 1.0, boundary=args.boundary)
    return [replace(case, p_star=p) for p in asked.get("p_star", ())] + [
        case.at_area(a_r) for a_r in asked.get("a_r", ())
    ]


def _one_case(case: Case, makers: Sequence[Maker], args: Namespace, report: Report) -> None:
    codes: list[Code] = []
    tolerances: dict[Code, float] = {}
    taken: dict[Code, list[dict]] = {}
    try:
        for make in makers:
            codes.append(make())
            tolerance, taken[codes[-1]] = _search(codes[-1], case, args, report)
            if tolerance is None:
                codes.pop().close()
            else:
                tolerances[codes[-1]] = tolerance
        slow = {code for code in codes if taken[code]}
        for code in in_turn(codes, args.repeats):
            if code not in slow and sum(run["seconds"] for run in taken[code]) < args.budget:
                taken[code].append(_solved(code, tolerances[code]))
    finally:
        for code in codes:
            code.close()
    _report(case, codes, tolerances, taken, slow, report)


def _solved(code: Code, tolerance: float) -> dict[str, Any]:
    """Numbers of one solve, with its true error."""
    answer, pressure = code.solve(tolerance)
    return answer | {"error": code.known.pressure_error(pressure - code.known.pressure)}


def _search(
    code: Code, case: Case, args: Namespace, report: Report
) -> tuple[float | None, list[dict]]:
    """(tolerance, runs): the loosest tolerance that is good enough, None where there is none. What
    is too slow to be run again is judged by its run in the search, which was not in turn with the
    others."""
    tried: dict[float, dict] = {}
    begun = time.perf_counter()
    tolerance: float | None = None
    error: float | None = None

    def error_at(tolerance: float) -> float:
        tried[tolerance] = _solved(code, tolerance)
        return tried[tolerance]["error"]

    try:
        code.prepare()
        tolerance, error = loosest(error_at, args.error, code.first * args.error, args.budget)
    except GfmdError as failure:
        report.say(f"# {failure}")
    if tolerance is None:
        gave_up = time.perf_counter() - begun > PATIENCE * args.budget
        last = _pick(list(tried.values())[-1] if tried else {}, "iterations")
        report.add(
            **case.label,
            code=code.name,
            a_r=code.known.a_r,
            error=error,
            status="out of time" if gave_up else "not reached",
            **last,
        )
        return None, []
    run = tried[tolerance]
    return tolerance, [run] if run["seconds"] > args.budget / 2 else []


def _report(
    case: Case,
    codes: Sequence[Code],
    tolerances: dict[Code, float],
    taken: dict[Code, list[dict]],
    slow: set[Code],
    report: Report,
) -> None:
    ours = [code for code in codes if isinstance(code, _We)]
    for code in codes:
        runs = taken[code]
        seconds, cpu = ([t[key] for t in runs] for key in ("seconds", "cpu_seconds"))
        row = {
            "code": code.name,
            "a_r": code.known.a_r,
            "tolerance": tolerances[code],
            "error": max(t["error"] for t in runs),
            "repeats": len(runs),
            "in_turn": "no" if code in slow else "yes",
            "seconds_min": min(seconds),
            "seconds_median": float(np.median(seconds)),
            "cpu_seconds_min": min(cpu),
        }
        row |= _pick(runs[-1], "iterations", "status", "fft_pairs")
        for key, name in (("seconds", "times_slower"), ("cpu_seconds", "cpu_times_slower")):
            if ours:
                best = min(ours, key=lambda c: np.median([t[key] for t in taken[c]]))
                pairs = zip(runs, taken[best], strict=False)
                row[name] = float(np.median([a[key] / b[key] for a, b in pairs]))
        report.add(**case.label, **row)


def _pick(answer: dict, *keys: str) -> dict:
    return {key: answer[key] for key in keys if answer.get(key) is not None}
