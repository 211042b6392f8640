"""`python scripts/paper ITEM`: figures and tables of the paper, alone and under mpirun."""

import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path

if not __package__:  # started by its path
    sys.path[0] = str(Path(__file__).resolve().parents[1])

from hpc_gfmd import SceneError, on_rank_0, world
from hpc_gfmd.commands.cli import Parser
from hpc_gfmd.commands.cli import main as run_command
from paper.cases import LEVELS, Store, cases_of, share
from paper.items import STUDIES, TEXTS
from paper.items.curves import reference_data
from paper.report import coefficients, publish, report, write_whole
from paper.rows import Rows, as_csv
from paper.solve import run_missing

OF_PAPER = [name for name, text in TEXTS.items() if "question" not in text]
DESCRIPTION = (
    "Reproduce figures and tables of the paper: solve the contacts that are missing, tabulate,"
    " draw. Works the same alone and under mpirun/srun; what is finished is kept, so the same"
    " command continues. Exit code 1: a contact could not be solved, 3: one did not reach its"
    " accuracy."
)


def make_parser() -> ArgumentParser:
    """Make the parser of the command line."""
    parser = Parser(prog="python scripts/paper", description=DESCRIPTION)
    add = parser.add_argument
    add(
        "item",
        metavar="ITEM",
        nargs="*",
        help=f"{OF_PAPER[0]} ... {OF_PAPER[-1]}, all, or one beyond the paper (--list)",
    )
    add(
        "--level",
        default="quick",
        metavar="LEVEL",
        help=f"{', '.join(LEVELS)} (default: quick, a minute)",
    )
    add(
        "-o",
        "--output",
        metavar="DIR",
        help="folder of runs, tables and pictures (default: study-LEVEL)",
    )
    add("--report", action="store_true", help="write the report, which all does anyway")
    add("--list", action="store_true", help="list what there is")
    add("--plan", action="store_true", help="say what would be solved, and stop")
    only = parser.add_mutually_exclusive_group()
    only.add_argument("--only-run", action="store_true", help="solve, but do not tabulate and draw")
    only.add_argument("--no-run", action="store_true", help="tabulate and draw what is there")
    only.add_argument("--redraw", action="store_true", help="draw the tables (CSV) that are there")
    add("--part", metavar="I/K", help="solve the I-th of K shares only; several jobs may share DIR")
    add(
        "--reference",
        metavar="FILE.json",
        type=Path,
        help="write the data of hpc_gfmd.reference from the stored curves",
    )
    add(
        "--coefficients",
        metavar="FILE.json",
        type=Path,
        help="write our coefficients of eq. tfc, for `hpc-gfmd tfc --table`",
    )
    add(
        "--threads",
        default="1",
        metavar="T",
        help='threads of each rank: a number or "auto" (default 1)',
    )
    parser.set_defaults(saves=True, main=main)
    return parser


def main(args: Namespace) -> int:
    """Solve, tabulate and draw. Raises SceneError for names, levels and shares that are none."""
    comm = world()
    if args.list:
        for name, text in TEXTS.items() if comm.rank == 0 else ():
            print(f"{name:14} {text['title']}")
        return 0
    items = _items(args)
    part = _part(args)
    if args.only_run and (args.report or args.reference or args.coefficients):
        raise SceneError("--only-run: found with --report, --reference or --coefficients")
    folder = args.output or f"study-{args.level}"
    cases = [case for name in items for case in cases_of(name, args.level)]
    code = 0
    if not (args.no_run or args.redraw):
        chosen = share(cases, *part) if part else cases
        threads = args.threads if args.threads == "auto" else int(args.threads)
        code = run_missing(chosen, Store(folder, part and part[0]), comm, threads, dry=args.plan)
    if code in (0, 1, 3) and not (args.only_run or args.plan):
        on_rank_0(comm, "writing tables and pictures", lambda: _publish(args, items, Store(folder)))
    return code


def _publish(args, items, store):
    tables: dict[str, Rows] = {}
    for name in items:
        tables[name] = publish(STUDIES[name], store, args.level, args.redraw)
        said = as_csv(tables[name]).strip() or "nothing stored yet"
        print(f"\n{name}: {TEXTS[name]['title']}\n{said}", flush=True)
    if args.report or "all" in args.item:
        for name in OF_PAPER:
            tables.setdefault(name, publish(STUDIES[name], store, args.level, args.redraw))
        path = report(store, args.level, {name: tables[name] for name in OF_PAPER})
        print(f"report: {path}", flush=True)
    if args.coefficients:
        write_whole(args.coefficients, coefficients(store, args.level))
    if args.reference:
        runs = store.runs_of(cases_of("curves", args.level))
        write_whole(args.reference, reference_data(runs, args.level))


def _items(args):
    allowed = f"allowed: all, {', '.join(TEXTS)}"
    if not args.item:
        raise SceneError(f"ITEM: not given, {allowed}")
    items = [one for name in args.item for one in (OF_PAPER if name == "all" else [name])]
    if unknown := set(items) - set(TEXTS):
        raise SceneError(f"ITEM: found {', '.join(sorted(unknown))}, {allowed}")
    if args.threads != "auto" and not (args.threads.isdecimal() and int(args.threads) > 0):
        raise SceneError(f'--threads: found {args.threads!r}, allowed: a number from 1, or "auto"')
    return list(dict.fromkeys(items))


def _part(args):
    if args.part is None:
        return None
    part, _, parts = args.part.partition("/")
    whole = part.isdecimal() and parts.isdecimal() and 1 <= int(part) <= int(parts)
    if not (whole and (args.only_run or args.plan)):
        raise SceneError(
            f"--part: found {args.part!r}, allowed: I/K, whole numbers 1 <= I <= K, with --only-run"
        )
    return int(part), int(parts)


if __name__ == "__main__":
    sys.exit(run_command(script=make_parser))
