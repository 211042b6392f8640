"""`python scripts/paper`: the paper's figures and tables, and questions beyond it."""

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from typing import Any

from hpc_gfmd.commands.cli import Parser
from hpc_gfmd.util.errors import SceneError


def make_parser() -> ArgumentParser:
    """The parser of the command line."""
    parser = Parser(
        prog="python scripts/paper",
        description=(
            "Reproduce figures and tables of the paper: solve the contacts that are missing,"
            " tabulate, draw. Works the same alone and under mpirun/srun; what is finished is kept,"
            " so the same command continues. Exit code 1: a contact could not be solved, 3: one did"
            " not reach its accuracy."
        ),
    )
    parser.add_argument(
        "name",
        metavar="NAME",
        nargs="*",
        help=(
            "fig1 ... fig13, table1 ... table5, all of these (all), or one beyond the paper (see"
            " --list)"
        ),
    )
    parser.add_argument(
        "--level",
        default="quick",
        metavar="LEVEL",
        help="quick (a minute, default), desk or paper (a cluster)",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        help="folder of runs, tables and pictures (default: study-LEVEL)",
    )
    parser.add_argument(
        "--report", action="store_true", help="write the report, which all does anyway"
    )
    parser.add_argument("--list", action="store_true", help="list what there is")
    parser.add_argument(
        "--plan",
        action="store_true",
        help="say what would be solved and how long it takes, and stop",
    )
    only = parser.add_mutually_exclusive_group()
    only.add_argument("--only-run", action="store_true", help="solve, but do not tabulate and draw")
    only.add_argument("--no-run", action="store_true", help="tabulate and draw what is there")
    parser.add_argument(
        "--part", metavar="I/K", help="solve the I-th of K shares only; several jobs may share DIR"
    )
    parser.add_argument(
        "--reference",
        metavar="FILE.json",
        help="write the data file of hpc_gfmd.reference from the stored sweeps",
    )
    parser.add_argument(
        "--coefficients",
        metavar="FILE.json",
        help="write our coefficients of eq. tfc, for `hpc-gfmd tfc --table`",
    )
    parser.add_argument(
        "--threads",
        default="1",
        metavar="T",
        help='threads of each rank: a number or "auto" (default 1)',
    )
    parser.set_defaults(saves=True, main=main)
    return parser


def main(args: Namespace) -> int:
    """Solve, tabulate and draw. Raises SceneError for names, levels and shares that do not
    exist."""
    from hpc_gfmd.parallel.world import world

    from . import catalogue
    from .levels import REFERENCE, at_level

    comm = world()
    if args.list:
        _say(
            comm, "\n".join(f"{name:8} {catalogue.study(name).title}" for name in catalogue.names())
        )
        return 0
    at_level(REFERENCE, args.level)
    part, threads = _part(args), _threads(args.threads)
    if args.only_run and (args.report or args.reference or args.coefficients):
        raise SceneError(
            "--only-run: found with --report, --reference or --coefficients, allowed: without them"
        )
    studies = [catalogue.study(name) for name in _names(args.name)]
    folder = args.output or f"study-{args.level}"
    exit_code = 0
    if not args.no_run:
        exit_code = _solve(args, studies, folder, part, threads, comm)
    if exit_code not in (0, 1, 3) or args.only_run or args.plan:
        return exit_code
    _publish(args, studies, folder, comm)
    return exit_code


def _solve(
    args: Namespace,
    studies: Sequence,
    folder: str,
    part: tuple[int, int] | None,
    threads: int | str,
    comm: Any,
) -> Any:
    from .runner import run_missing, share
    from .store import Store

    cases = [case for study in studies for case in study.cases(args.level)]
    if part:
        cases = share(cases, *part)
    store = Store(folder, part and part[0])
    outcome = run_missing(
        cases, store, comm, threads, say=lambda text: print(text, flush=True), dry=args.plan
    )
    if outcome.failed:
        _say(comm, f"{len(outcome.failed)} contacts could not be solved, see FAILED above")
    return outcome.exit_code


def _publish(args: Namespace, studies: Sequence, folder: str, comm: Any) -> None:
    from hpc_gfmd.parallel.guard import guarded

    from .publish import as_text, publish
    from .store import Store

    with guarded(comm, "writing tables and pictures"):
        if comm.rank != 0:
            return
        store = Store(folder)
        for study in studies:
            rows = publish(study, store, args.level)
            print(
                f"\n{study.name}: {study.title}\n{as_text(rows) if rows else 'nothing stored yet'}",
                flush=True,
            )
        if args.report or "all" in args.name:
            from .report import report

            print(f"report: {report(folder, args.level)}", flush=True)
        if args.coefficients:
            from .coefficients import our_table, write_our_table
            from .levels import tfc_series

            write_our_table(
                our_table(store.runs_of(tfc_series(args.level)), args.level), args.coefficients
            )
            print(f"coefficients: {args.coefficients}", flush=True)
        if args.reference:
            from .reference_data import write_reference

            print(
                f"{args.reference}: {write_reference(args.reference, store, args.level)} curves",
                flush=True,
            )


def _names(given: Sequence[str]) -> list[str]:
    from . import catalogue

    if not given:
        raise SceneError(f"NAME: found nothing, allowed: all, {', '.join(catalogue.names())}")
    return list(
        dict.fromkeys(
            one for name in given for one in (catalogue.of_paper() if name == "all" else [name])
        )
    )


def _part(args: Namespace) -> tuple[int, int] | None:
    if args.part is None:
        return None
    part, _, parts = args.part.partition("/")
    if not (part.isdecimal() and parts.isdecimal() and 1 <= int(part) <= int(parts)):
        raise SceneError(
            f"--part: found {args.part!r}, allowed: I/K with whole numbers 1 <= I <= K"
        )
    if not args.only_run and not args.plan:
        raise SceneError(
            "--part: found alone, allowed: together with --only-run (tabulate with --no-run when"
            " all parts are done)"
        )
    return int(part), int(parts)


def _threads(text: str) -> str:
    if text != "auto" and not (text.isdecimal() and 1 <= int(text) <= 65536):
        raise SceneError(f'--threads: found {text!r}, allowed: a whole number from 1, or "auto"')
    return text


def _say(comm: Any, text: str) -> None:
    if comm.rank == 0:
        print(text, flush=True)
