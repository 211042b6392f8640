"""Time and FFT pairs of the solvers against the true errors of what they return.

Every solver is run to a series of accuracies, each from its start: reading errors along the
iterations would disturb the times. What is reported is the true error of the result, not what was
asked. Solvers without error estimates of their own are asked for residuals instead, which costs
them less than being judged again and again. Who has not finished within the budget is interrupted:
what is reported is the error reached by then, and tighter accuracies are not tried.
"""

from argparse import Namespace
from typing import Any, Literal

import numpy as np

from hpc_gfmd.solvers import solver_names
from hpc_gfmd.util.errors import GfmdError

from .cases import Case
from .ours import Ours, Solved
from .reference import Reference, reference
from .report import Report, one_of
from .timing import in_turn

WITH_ESTIMATES = ("bpx",)
# seconds: who takes longer than this is timed at once, others once more when all caches are warm
LONG = 0.5
COLUMNS = {
    "n": ("n", "5d"),
    "hurst": ("H", "4.2g"),
    "p_star": ("p*", "8.4g"),
    "precision": ("precision", "9"),
    "solver": ("solver", "6"),
    "start": ("start", "6"),
    "accuracy": ("asked", "7.0e"),
    "error": ("true", "8.1e"),
    "area_error": ("area", "8.1e"),
    "gap_error": ("gap", "8.1e"),
    "pressure_error": ("pressure", "8.1e"),
    "iterations": ("iter", "6d"),
    "fft_pairs": ("pairs", "8.2f"),
    "seconds_min": ("s (min)", "9.3g"),
    "seconds_median": ("s (median)", "10.3g"),
    "cpu_seconds_min": ("cpu s (min)", "11.3g"),
    "status": ("status", "14"),
}


def bench_accuracy(args: Namespace) -> None:
    """All cases. args: n, hurst, p_star, precision, solvers, start, accuracy (lists),
    max_iterations, repeats, budget, out. Raises SceneError for a solver that does not exist."""
    one_of("--solvers", args.solvers, solver_names())
    report = Report("accuracy", COLUMNS, args.out)
    for n in args.n:
        for hurst in args.hurst:
            for p_star in args.p_star:
                case = Case(n, hurst, p_star)
                try:
                    known = reference(case)
                except GfmdError as error:
                    report.say(f"# {error}")
                    continue
                for precision in args.precision:
                    _one_case(case, precision, known, args, report)
    report.finish()
    if report.folder:
        from .pictures import accuracy_picture

        accuracy_picture(
            report.rows,
            report.folder / "accuracy.png",
            "cpu_seconds_min" if args.cpu else "seconds_min",
        )
        accuracy_picture(report.rows, report.folder / "accuracy-pairs.png", "fft_pairs")


def _one_case(
    case: Case,
    precision: Literal["single", "double"],
    known: Reference,
    args: Namespace,
    report: Report,
) -> None:
    ours = Ours(case, precision)
    ours.solve(0.1)
    runs: dict[tuple[str, str, float], list[Solved]] = {}
    rows, over = {}, set()  # by the same
    for solver in args.solvers:
        for start in args.start:
            for accuracy in sorted(args.accuracy, reverse=True):
                solved = _solve(ours, solver, start, accuracy, args)
                key = solver, start, accuracy
                rows[key] = _row(solved, known)
                slow = solved.seconds > args.budget
                runs[key] = [solved] if slow or solved.seconds > LONG else []
                if slow:
                    over.add(key)
                if slow or solved.status != "converged":
                    break
    for key in in_turn([key for key in runs if key not in over], args.repeats):
        if len(runs[key]) < args.repeats:
            runs[key].append(_solve(ours, *key, args))
    for (solver, start, accuracy), taken in runs.items():
        seconds = [s.seconds for s in taken]
        report.add(
            **case.label,
            precision=precision,
            solver=solver,
            start=start,
            accuracy=accuracy,
            repeats=len(taken),
            seconds_min=min(seconds),
            seconds_median=float(np.median(seconds)),
            cpu_seconds_min=min(s.cpu_seconds for s in taken),
            **rows[solver, start, accuracy],
        )


def _solve(ours: Ours, solver: str, start: str, wanted: float, args: Namespace) -> Solved:
    asked: dict[str, Any] = (
        {"accuracy": wanted} if solver in WITH_ESTIMATES else {"accuracy": None, "residual": wanted}
    )
    return ours.solve(
        solver=solver,
        nested=start == "nested",
        max_iterations=args.max_iterations,
        budget=args.budget,
        **asked,
    )


def _row(solved: Solved, known: Reference) -> dict[str, Any]:
    area, gap, pressure = known.errors(solved.a_r, solved.gap_mean, solved.pressure)
    return {
        "error": max(area, gap, pressure),
        "area_error": area,
        "gap_error": gap,
        "pressure_error": pressure,
        "estimates": list(solved.estimates),
        "iterations": solved.iterations,
        "fft_pairs": solved.fft_pairs,
        "status": solved.status,
    }
