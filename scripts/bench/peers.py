"""Time and memory of this package and other codes at equal true error of the pressure field, on the
same surfaces and with one thread each.

The tolerance of a code says little about its error. Every code is therefore first given the loosest
tolerance at which its true error (relative L2 norm of the pressure against a far more accurate
reference) meets a common target. Then all codes take turns.

With free edges the other codes take the pressure as constant on the cells around grid points, this
package as band-limited: two discretisations of one contact. Each code is compared with the exact
solution of its own discretisation.
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
from typing import NamedTuple

import numpy as np

from hpc_gfmd import GfmdError, SceneError

from .cells import by_cells
from .contacts import RoughContact, distance
from .report import Report
from .timing import Process, in_turn, ratio, summary

CODES = tomllib.loads(Path(__file__).with_name("codes.toml").read_text())
MAX_TRIES = 25  # tolerances of a search


def peers_python():
    """Return the interpreter of the environment that scripts/bench-peers-setup makes. Raises
    SceneError if there is none."""
    root = os.environ.get("HPC_GFMD_PEERS") or Path(__file__).resolve().parents[2] / ".venv-peers"
    python = Path(root) / "bin" / "python"
    if not python.exists():
        raise SceneError(
            f"bench peers: found no {python}, allowed: an environment made by"
            " scripts/bench-peers-setup (HPC_GFMD_PEERS names another folder)"
        )
    return python


class Code(Process):
    """A process that solves contacts with one code (a key of codes.toml), whose exact solution is
    exact_pressure in its discretisation."""

    def __init__(self, name, folder, exact_pressure):
        self.is_ours = name in CODES["ours"]
        self._pressure_path = folder / f"{name}.npy"
        self._exact_pressure = exact_pressure
        python = sys.executable if self.is_ours else peers_python()
        super().__init__(name, [python, Path(__file__).with_name("peer_worker.py")])

    def solve(self, tolerance):
        """Solve once and return the numbers of the solve with its true error."""
        answer = self.ask(tolerance=tolerance, pressure_to=str(self._pressure_path))
        return answer | {"error": distance(np.load(self._pressure_path), self._exact_pressure)}


class Contender(NamedTuple):
    """A code that meets the target.

    Attributes
    ----------
    code : Code
        Its process.
    settings : dict
        Name, options, version and tolerance.
    rows : list of dict
        Rows of its solves.
    """

    code: Code
    settings: dict
    rows: list


def run(args):
    """Compare all codes on all contacts. Raises SceneError for codes that are unknown or not
    installed, and for a wrong boundary or hardness."""
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
    chosen = {name: allowed[name] for name in codes}
    report = Report("peers", args.out)
    report.note(
        f"relative L2 error of the pressure field <= asked; {args.boundary}, H = {args.hurst},"
        f" L/lam_l = {args.l_over_lam_l:g}, lam_s/a = {args.lam_s_over_a:g}, seed 1; over_ours:"
        " median over runs in turn of the time over that of our faster precision"
    )
    for n in args.n:
        surface = RoughContact(
            n,
            1.0,
            args.hurst,
            args.boundary,
            args.hardness,
            L_over_lam_l=args.l_over_lam_l,
            lam_s_over_a=args.lam_s_over_a,
        )
        loads = [surface.at_area(a_r).p_star for a_r in args.a_r] if free else args.p_star
        for p_star, error in product(loads, args.error):
            _compare(replace(surface, p_star=p_star), chosen, error, args, report)
    report.finish()


def _compare(contact, other_codes, error, args, report):
    """Report our codes and others on one contact at one target of the error."""
    reference_row, reference_pressure = contact.reference
    head = asdict(contact) | {"a_r": reference_row["a_r"], "asked": error}
    contenders = []
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        np.save(folder / "heights.npy", contact.surface.heights)
        surface = {"heights": str(folder / "heights.npy"), "pressure": contact.p_star}
        if contact.hardness:
            surface["hardness"] = contact.hardness
        for name, options in (CODES["ours"] | other_codes).items():
            is_ours = name in CODES["ours"]
            if is_ours:
                options = options | {"boundary": contact.boundary}
            on_cells = contact.boundary == "free" and not is_ours
            exact_pressure = by_cells(contact) if on_cells else reference_pressure
            code = stack.enter_context(closing(Code(name, folder, exact_pressure)))
            settings = {"code": name, "options": options}
            try:
                settings |= code.ask(**surface, **options)
                settings["version"] = next(iter(settings["code_versions"].values()))
                settings["tolerance"], row = _loosest(code.solve, error, args.budget)
                contenders.append(Contender(code, settings, [row]))
            except GfmdError as failure:
                report.note(str(failure))
                report.add(**head, **settings, status="not reached")
        fast = [c for c in contenders if c.rows[0]["seconds"] < args.budget / 2]
        for contender in in_turn(fast, args.repeats):
            contender.rows.append(contender.code.solve(contender.settings["tolerance"]))
    our_rows = [contender.rows for contender in contenders if contender.code.is_ours]
    for contender in contenders:
        statuses = {row["status"] for row in contender.rows}
        if len(statuses) > 1:
            report.note(f"{contender.settings['code']}: solves end as {', '.join(statuses)}")
            report.add(**head, **contender.settings, status="differs")
            continue
        row = summary(contender.rows) | {"error": max(row["error"] for row in contender.rows)}
        row |= _times_over_ours(contender.rows, our_rows)
        report.add(**head, **contender.settings, **row)


def _times_over_ours(rows, our_rows):
    """Return the median times of rows over those of the fastest of our codes, {} without ours."""
    ratios = {}
    for key in ("seconds", "cpu_seconds") if our_rows else ():
        our_times = [[row[key] for row in series] for series in our_rows]
        fastest = min(our_times, key=np.median)
        ratios[f"{key}_over_ours"] = ratio([row[key] for row in rows], fastest)
    return ratios


def _loosest(solve, target, budget):
    """Return a tolerance whose error just meets a target, and the row of the solve that shows it.

    The search starts from a loose tolerance and tightens it in proportion to the "error" of
    solve(tolerance). Raises GfmdError if no tolerance meets the target within a budget of seconds.
    """
    begin = time.perf_counter()
    tolerance = 0.3
    smallest_error = np.inf
    for _ in range(MAX_TRIES):
        row = solve(tolerance)
        if row["error"] <= target:
            return tolerance, row
        smallest_error = min(smallest_error, row["error"])
        if time.perf_counter() - begin > budget:
            break
        tolerance *= float(np.clip(0.7 * target / row["error"], 0.2, 0.6))
    raise GfmdError(f"found an error of {smallest_error:.1e} at best, allowed: {target:g}")
