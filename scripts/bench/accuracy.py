"""Time and FFT pairs of the solvers against the true errors of what they return.

What is reported is the true error of the result, not what was asked. The default solver is asked
for accuracies, the others, which have no estimates of their own, for residuals. Of a solver that
takes longer than the budget, or that does not converge, no tighter ones are tried.
"""

from functools import partial
from itertools import product, starmap

from hpc_gfmd import GfmdError

from .contacts import Case
from .pictures import Panel, group, picture
from .report import Report
from .timing import in_turn, summary


def run(args):
    """Measure all cases; args: of command.py."""
    report = Report("accuracy", args.out)
    for case in starmap(Case, product(args.n, args.p_star, args.hurst)):
        _one_case(case, args, report)
    report.finish()
    if report.path:
        rows = [row for row in report.rows if row["n"] == max(args.n)]
        keys = "solver", "start", "precision"
        # error: the worst of area, gap, pressure
        for name, cost in (("accuracy", "seconds_min"), ("accuracy-pairs", "fft_pairs")):
            panels = [
                Panel(members, keys, cost, "error", f"H = {hurst}, p* = {p_star:.3g}")
                for (hurst, p_star), members in group(rows, "hurst", "p_star").items()
            ]
            picture(report.path.with_name(f"{name}.png"), panels)


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
