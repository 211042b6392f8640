"""This package and other codes: time and memory at equal true error of the pressure field, on the
same surfaces, one thread each.

A code's tolerance says little about its error, so every code is first given the loosest tolerance
at which its true error (relative L2 norm of the pressure against a reference solved far tighter) is
below the same target. Then all run in turn.

With free edges the others take the pressure as constant on the cells of grid points, we as
band-limited: two discretisations of one contact. Each code is judged by the exact solution of its
own.
"""

import os
import sys
import tempfile
import time
import tomllib
from contextlib import ExitStack, closing
from dataclasses import asdict, replace
from itertools import product
from pathlib import Path

import numpy as np

from hpc_gfmd import GfmdError, SceneError

from .cells import by_cells
from .contacts import Case, distance
from .report import Report
from .timing import Process, in_turn, ratio, summary

CODES = tomllib.loads(Path(__file__).with_name("codes.toml").read_text())
TRIES = 25


def peers_python():
    """Find the interpreter of the environment that scripts/bench-peers-setup makes. Raises
    SceneError where there is none."""
    root = os.environ.get("HPC_GFMD_PEERS") or Path(__file__).resolve().parents[2] / ".venv-peers"
    python = Path(root) / "bin" / "python"
    if not python.exists():
        raise SceneError(
            f"bench peers: found no {python}, allowed: an environment made by"
            " scripts/bench-peers-setup (HPC_GFMD_PEERS names another folder)"
        )
    return python


class Code(Process):
    """A process that solves with one code; known: the exact pressure of its discretisation."""

    def __init__(self, name, folder, known):
        self.ours, self.path, self.known = name in CODES["ours"], folder / f"{name}.npy", known
        python = sys.executable if self.ours else peers_python()
        super().__init__(name, [python, Path(__file__).with_name("peer_worker.py")])

    def solve(self, tolerance):
        """Return the numbers of one solve, with its true error."""
        answer = self.ask(tolerance=tolerance, pressure_to=str(self.path))
        return answer | {"error": distance(np.load(self.path), self.known)}


def run(args):
    """Compare all codes on all surfaces; args: of command.py. Raises SceneError for a code that is
    not known or not there."""
    if args.boundary not in ("periodic", "free"):
        raise SceneError(f"--boundary: found {args.boundary!r}, allowed: periodic, free")
    free = args.boundary == "free"
    if free and args.hardness:
        raise SceneError("--hardness: with free edges no other code is known, allowed: 0")
    allowed = CODES["hard" if args.hardness else args.boundary]
    codes = list(allowed) if args.codes == ["all"] else args.codes
    for name in codes:
        if name not in allowed:
            raise SceneError(f"--codes: found {name!r}, allowed: {', '.join(allowed)}")
        peers_python()
    report = Report("peers", args.out)
    report.note(
        f"relative L2 error of the pressure field <= asked; {args.boundary}, H = {args.hurst},"
        " L/lam_l = 2, lam_s/a = 2, seed 1; slower: median over runs in turn of the time over that"
        " of our faster precision"
    )
    for n in args.n:
        some = Case(n, 1.0, args.hurst, args.boundary, args.hardness)
        loads = [some.at_area(a_r).p_star for a_r in args.a_r] if free else args.p_star
        for p_star, error in product(loads, args.error):
            chosen = {name: allowed[name] for name in codes}
            _one_case(replace(some, p_star=p_star), chosen, error, args, report)
    report.finish()


def _one_case(case, others, error, args, report):
    row, known = case.reference
    head = asdict(case) | {"a_r": row["a_r"], "asked": error}
    found = []  # (Code, what is reported, rows of all solves)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        np.save(folder / "heights.npy", case.surface.heights)
        surface = {"heights": str(folder / "heights.npy"), "pressure": case.p_star}
        if case.hardness:
            surface["hardness"] = case.hardness
        for name, its in (CODES["ours"] | others).items():
            ours = name in CODES["ours"]
            exact = known if ours or case.boundary != "free" else by_cells(case)
            code = stack.enter_context(closing(Code(name, folder, exact)))
            options = its | {"boundary": case.boundary} if ours else its
            of = {"code": name, "options": options}
            try:
                of |= code.ask(**surface, **options)
                of["version"] = next(iter(of["code_versions"].values()))
                of["tolerance"], rows = _loosest(code.solve, error, args.budget)
                found.append((code, of, rows))
            except GfmdError as failure:
                report.note(str(failure))
                report.add(**head, **of, status="not reached")
        quick = [one for one in found if one[-1][0]["seconds"] < args.budget / 2]
        for code, of, rows in in_turn(quick, args.repeats):
            rows.append(code.solve(of["tolerance"]))
    ours = [rows for code, _, rows in found if code.ours]
    for _, of, rows in found:
        slower = {}
        for key in ("seconds", "cpu_seconds") if ours else ():
            times = [[row[key] for row in some] for some in (rows, *ours)]
            slower[f"{key}_over_ours"] = ratio(times[0], min(times[1:], key=np.median))
        worst = {"error": max(row["error"] for row in rows)}
        report.add(**head, **of, **summary(rows) | worst | slower)


def _loosest(solve, target, budget):
    """Return a tolerance whose error is at most the target, hardly tighter than it has to be, with
    the solve that showed it: from loose ones on, proportionally to the error. Raises GfmdError
    where there is none."""
    begun, tolerance, lowest = time.perf_counter(), 0.3, np.inf
    for _ in range(TRIES):
        row = solve(tolerance)
        if row["error"] <= target:
            return tolerance, [row]
        lowest = min(lowest, row["error"])
        if time.perf_counter() - begun > budget:
            break
        tolerance *= float(np.clip(0.7 * target / row["error"], 0.2, 0.6))
    raise GfmdError(f"an error of {lowest:.1e} at the lowest, wanted: {target:g}")
