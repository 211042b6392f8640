"""Time and FFT pairs of the solvers against the true errors of their solutions.

The errors are those of the result, not what was requested. An accuracy is requested of the default
solver, a residual of the other one, as in the paper. When a solver exceeds the time budget or does
not converge, tighter requests are skipped.
"""

import json
import tomllib
from functools import partial
from itertools import product, starmap
from pathlib import Path
from typing import NamedTuple

from hpc_gfmd import GfmdError

from .contacts import RoughContact
from .pictures import Panel, group, picture
from .report import Report
from .timing import in_turn, summary

CODES = Path(__file__).with_name("codes.toml")


class Measurement(NamedTuple):
    """A solver's way to solve one contact.

    Attributes
    ----------
    head : dict
        What was requested, and the errors of the solution.
    press : function
        Solves again and returns (row, pressure).
    rows : list of dict
        Rows of all solves so far.
    """

    head: dict
    press: partial
    rows: list


def run(args):
    """Measure all contacts and draw the largest grid."""
    report = Report("accuracy", args.out)
    for contact in starmap(RoughContact, product(args.n, args.p_star, args.hurst)):
        _measure(contact, args, report)
    report.finish()
    if report.path:
        draw(report.path, report.rows, args.peers)


def draw(path, rows, peers):
    """Draw FFT pairs against the largest error of area, gap and pressure, for the rows of the
    largest grid and those of other codes (file `peers`; "" for none), beside the file of rows."""
    largest = max(row["n"] for row in rows)
    rows = [row for row in rows if row["n"] == largest]
    rows += rows_of_peers(peers, rows)
    keys = "solver", "start", "precision"
    panels = [
        Panel(members, keys, "fft_pairs", "error", f"H = {hurst}, p* = {p_star:.3g}")
        for (hurst, p_star), members in group(rows, "hurst", "p_star").items()
    ]
    picture(path.with_name("accuracy-pairs.png"), panels)


def rows_of_peers(path, rows):
    """Return the rows of other codes (file at path; "" for none) on the contacts of our rows. Their
    FFT pairs follow from their iterations, and their errors are those of the pressure."""
    if not path:
        return []
    pairs_per_iteration = tomllib.loads(CODES.read_text())["pairs_per_iteration"]
    our_contacts = {(row["n"], row["hurst"], row["p_star"]) for row in rows}
    peer_rows = []
    for line in Path(path).read_text().splitlines():
        row = json.loads(line)
        code = row["code"]
        is_ours = (row["n"], row["hurst"], row["p_star"]) in our_contacts
        if code in pairs_per_iteration and is_ours and "error" in row:
            peer_row = {key: row[key] for key in ("hurst", "p_star", "error")}
            peer_row |= {"solver": code, "start": "cold", "precision": "double"}
            peer_row["fft_pairs"] = pairs_per_iteration[code] * row["iterations"]
            peer_rows.append(peer_row)
    return peer_rows


def _measure(contact, args, report):
    """Report all solvers on one contact; their repeated solves take turns."""
    try:
        contact.reference  # noqa: B018
    except GfmdError as error:
        report.note(str(error))
        return
    measurements = []
    for precision, solver, start in product(args.precision, args.solvers, args.start):
        contact.press(precision=precision, accuracy=0.1)  # compiles and plans
        for requested in sorted(args.accuracy, reverse=True):
            press = partial(
                contact.press,
                precision=precision,
                name=solver,
                nested=start == "nested",
                max_iterations=args.max_iterations,
                **{"accuracy" if solver == "bpx" else "residual": requested},
            )
            row, pressure = press()
            head = {"n": contact.n, "hurst": contact.hurst}
            head |= {"precision": precision, "solver": solver, "start": start, "asked": requested}
            head |= contact.errors(row, pressure)
            measurements.append(Measurement(head, press, [row]))
            if row["seconds"] > args.budget or row["status"] != "converged":
                break
    fast = [m for m in measurements if m.rows[0]["seconds"] < args.budget]
    for measurement in in_turn(fast, args.repeats - 1):
        measurement.rows.append(measurement.press()[0])
    for measurement in measurements:
        report.add(**measurement.head, **summary(measurement.rows))
