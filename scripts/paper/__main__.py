"""Make figures and tables of the paper, also under mpirun: `python scripts/paper ITEM`."""

import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path

if not __package__:  # run by its path
    sys.path[0] = str(Path(__file__).resolve().parents[1])

from hpc_gfmd import SceneError, on_rank_0, world
from hpc_gfmd.commands.cli import Parser
from hpc_gfmd.commands.cli import main as run_command
from paper.cases import LEVELS, Store, cases_of
from paper.items import STUDIES, TEXTS
from paper.items.curves import reference_data
from paper.report import coefficients, publish, report, write_whole
from paper.rows import Rows, as_csv
from paper.solve import run_missing

OF_PAPER = [name for name, text in TEXTS.items() if "question" not in text]
DESCRIPTION = (
    "Reproduce figures and tables of the paper: solve the contacts that are missing, tabulate and"
    " draw them, in one process or under mpirun/srun. Finished contacts are kept, so the same"
    " command resumes an interrupted run. Exit code 1: a contact could not be solved; 3: one did"
    " not reach its accuracy."
)


def make_parser() -> ArgumentParser:
    """Return the parser of the command line."""
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
    add("--list", action="store_true", help="list all items")
    add("--no-run", action="store_true", help="only tabulate and draw stored contacts")
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
    """Solve, tabulate and draw; return the exit code. Raises SceneError for wrong arguments."""
    comm = world()
    if args.list:
        for name, text in TEXTS.items() if comm.rank == 0 else ():
            print(f"{name:14} {text['title']}")
        return 0
    items = _items(args)
    store = Store(args.output or f"study-{args.level}")
    cases = [case for name in items for case in cases_of(name, args.level)]
    code = 0
    if not args.no_run:
        threads = args.threads if args.threads == "auto" else int(args.threads)
        code = run_missing(cases, store, comm, threads)
    if code in (0, 1, 3):
        on_rank_0(comm, "writing tables and pictures", lambda: _publish(args, items, store))
    return code


def _publish(args, items, store):
    tables: dict[str, Rows] = {}
    for name in items:
        tables[name] = publish(STUDIES[name], store, args.level)
        text = as_csv(tables[name]).strip() or "nothing stored yet"
        print(f"\n{name}: {TEXTS[name]['title']}\n{text}", flush=True)
    if "all" in args.item:
        path = report(store, args.level, {name: tables[name] for name in OF_PAPER})
        print(f"report: {path}", flush=True)
    if args.coefficients:
        write_whole(args.coefficients, coefficients(store, args.level))
    if args.reference:
        runs = store.runs_of(cases_of("curves", args.level))
        write_whole(args.reference, reference_data(runs, args.level))


def _items(args):
    """Return the requested items, each once."""
    allowed = f"allowed: all, {', '.join(TEXTS)}"
    if not args.item:
        raise SceneError(f"ITEM: not given, {allowed}")
    items = [item for name in args.item for item in (OF_PAPER if name == "all" else [name])]
    if unknown := set(items) - set(TEXTS):
        raise SceneError(f"ITEM: found {', '.join(sorted(unknown))}, {allowed}")
    if args.threads != "auto" and not (args.threads.isdecimal() and int(args.threads) > 0):
        raise SceneError(f'--threads: found {args.threads!r}, allowed: a number from 1, or "auto"')
    return list(dict.fromkeys(items))


if __name__ == "__main__":
    sys.exit(run_command(script=make_parser))
