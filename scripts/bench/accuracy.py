"""Time and FFT pairs of the solvers against the true errors of what they return.

What is reported is the true error of the result, not what was asked. The default solver is asked
for accuracies, the other for residuals, as the paper does. Of a solver that
takes longer than the budget, or that does not converge, no tighter ones are tried.
"""

import json
import tomllib
from functools import partial
from itertools import product, starmap
from pathlib import Path

from hpc_gfmd import GfmdError

from .contacts import Case
from .pictures import Panel, group, picture
from .report import Report
from .timing import in_turn, summary

CODES = Path(__file__).with_name("codes.toml")


def run(args):
    """Measure all cases; args: of command.py."""
    report = Report("accuracy", args.out)
    for case in starmap(Case, product(args.n, args.p_star, args.hurst)):
        _one_case(case, args, report)
    report.finish()
    if report.path:
        draw(report.path, report.rows, args.peers)


def draw(path, rows, peers):
    """Draw the errors of the largest grid against time and pairs beside `path`.

    peers: a file of rows that `bench peers` has written, "" for none; in the picture of pairs only.
    """
    largest = max(row["n"] for row in rows)
    rows = [row for row in rows if row["n"] == largest]
    keys = "solver", "start", "precision"
    # error: the worst of area, gap, pressure
    for name, cost, drawn in (
        ("accuracy", "seconds_min", rows),
        ("accuracy-pairs", "fft_pairs", rows + rows_of_peers(peers, rows)),
    ):
        panels = [
            Panel(members, keys, cost, "error", f"H = {hurst}, p* = {p_star:.3g}")
            for (hurst, p_star), members in group(drawn, "hurst", "p_star").items()
        ]
        picture(path.with_name(f"{name}.png"), panels)


def rows_of_peers(path, rows):
    """Return rows of other codes on the same surfaces and loads, whose FFT pairs follow from their
    iterations; their errors are those of the pressure."""
    if not path:
        return []
    each = tomllib.loads(CODES.read_text())["pairs_per_iteration"]
    same = {(row["n"], row["hurst"], row["p_star"]) for row in rows}
    found = []
    for line in Path(path).read_text().splitlines():
        row = json.loads(line)
        code = row["code"]
        if code in each and (row["n"], row["hurst"], row["p_star"]) in same and "error" in row:
            pairs = each[code] * row["iterations"]
            head = {key: row[key] for key in ("hurst", "p_star", "error")}
            found.append(
                head | {"solver": code, "start": "cold", "precision": "double", "fft_pairs": pairs}
            )
    return found


def _one_case(case, args, report):
    try:
        case.reference  # noqa: B018
    except GfmdError as error:
        report.note(str(error))
        return
    found = []  # (what is reported, what solves again, rows of all solves)
    for precision, solver, start in product(args.precision, args.solvers, args.start):
        case.press(precision=precision, accuracy=0.1)  # compiles and plans
        for asked in sorted(args.accuracy, reverse=True):
            press = partial(
                case.press,
                precision=precision,
                name=solver,
                nested=start == "nested",
                max_iterations=args.max_iterations,
                **{"accuracy" if solver == "bpx" else "residual": asked},
            )
            row, pressure = press()
            head = {"n": case.n, "hurst": case.hurst, "precision": precision, "solver": solver}
            head |= {"start": start, "asked": asked} | case.errors(row, pressure)
            found.append((head, press, [row]))
            if row["seconds"] > args.budget or row["status"] != "converged":
                break
    quick = [one for one in found if one[-1][0]["seconds"] < args.budget]
    for _, press, rows in in_turn(quick, args.repeats - 1):
        rows.append(press()[0])
    for head, _, rows in found:
        report.add(**head, **summary(rows))
