"""Speed of kernels and transforms, time against true error, and other codes on the same
surfaces."""

from argparse import ArgumentParser, Namespace
from collections.abc import Iterable
from importlib import import_module
from typing import Any

from hpc_gfmd.commands.cli import Parser
from hpc_gfmd.commands.number import number
from hpc_gfmd.util.errors import SceneError

PRECISIONS = ("single", "double")
ALONE = ("accuracy", "kernels", "peers")  # these run on one rank


def make_parser() -> ArgumentParser:
    """The parser of all measurements."""
    parser = Parser(
        prog="bench",
        description="Measure speed. Alternating runs, warmed up; compare numbers of one call only.",
    )
    parser.set_defaults(main=run)
    parts = parser.add_subparsers(metavar="WHAT", required=True, parser_class=Parser)

    kernels = _part(
        parts,
        "kernels",
        "passes of the default solver: bytes moved, time, share of a copy, on one core and on more",
        (1024, 2048, 4096),
        12,
    )
    kernels.add_argument(
        "--ranks",
        type=int,
        nargs="+",
        default=[1, 2],
        metavar="K",
        help="numbers of ranks, a core each (1 2)",
    )
    kernels.add_argument(
        "--p-star",
        type=number,
        default=0.05,
        metavar="P",
        help="load of the contact that is iterated (default 0.05)",
    )

    _part(
        parts,
        "fft",
        "our passes against mpi4py-fft's PFFT and FFTW's plan; on all ranks",
        (1024, 2048, 4096),
        12,
    )

    accuracy = _part(
        parts,
        "accuracy",
        "time and FFT pairs of all solvers against true error",
        (512, 1024, 2048, 4096),
        3,
    )
    accuracy.add_argument(
        "--p-star", type=number, nargs="+", default=[0.0007, 0.007, 0.05, 0.353, 1.0], metavar="P"
    )
    accuracy.add_argument("--hurst", type=number, nargs="+", default=[0.3, 0.8], metavar="H")
    accuracy.add_argument(
        "--solvers", nargs="+", default=["bpx", "gfmd", "fire", "ccg"], metavar="NAME"
    )
    accuracy.add_argument(
        "--start", nargs="+", choices=("nested", "cold"), default=["nested", "cold"]
    )
    accuracy.add_argument(
        "--accuracy", type=number, nargs="+", default=[1e-2, 1e-3, 1e-4, 1e-5, 1e-6], metavar="EPS"
    )
    accuracy.add_argument("--max-iterations", type=int, default=2000, metavar="K")
    accuracy.add_argument(
        "--budget",
        type=number,
        default=120.0,
        metavar="S",
        help="seconds after which a solve is interrupted, "
        "not repeated, and tighter accuracies are not tried (default 120)",
    )

    scaling = _part(
        parts,
        "scaling",
        "strong and weak scaling under mpirun, where the time goes, and a model of a cluster",
        (2048, 4096),
        3,
    )
    scaling.add_argument(
        "--ranks",
        type=int,
        nargs="+",
        default=[1, 2],
        metavar="K",
        help="numbers of ranks (default 1 2)",
    )
    scaling.add_argument(
        "--threads",
        type=int,
        nargs="+",
        default=[1, 2],
        metavar="T",
        help="threads of one rank (default 1 2)",
    )
    scaling.add_argument(
        "--p-star", type=number, default=0.05, metavar="P", help="load (default 0.05)"
    )

    storage = _part(
        parts, "storage", "result file against a raw write; on all ranks", (4096, 8192), 3
    )
    storage.add_argument(
        "--folder", default=".", metavar="DIR", help="where to write (default: here)"
    )

    peers = _part(
        parts,
        "peers",
        "ASPHER, Tamaas, ContactMechanics at equal true error (scripts/bench-peers-setup first)",
        (1024,),
        5,
    )
    peers.add_argument(
        "--boundary",
        choices=("periodic", "free"),
        default="periodic",
        help="of the surface (default periodic)",
    )
    loads = peers.add_mutually_exclusive_group()
    loads.add_argument(
        "--p-star", type=number, nargs="+", metavar="P", help="loads (default 0.007 0.353)"
    )
    loads.add_argument(
        "--a-r",
        type=number,
        nargs="+",
        metavar="A",
        help="the loads at which such shares of the nominal area touch "
        "(default with free edges: 0.02 0.2)",
    )
    peers.add_argument("--hurst", type=number, default=0.8, metavar="H")
    peers.add_argument(
        "--codes",
        nargs="*",
        default=None,
        metavar="NAME",
        help="which of the other codes (default: all)",
    )
    peers.add_argument(
        "--error",
        type=number,
        default=1e-5,
        metavar="E",
        help="relative L2 error of the pressure (default 1e-5)",
    )
    peers.add_argument(
        "--budget",
        type=number,
        default=60.0,
        metavar="S",
        help="seconds per code and case (default 60)",
    )
    return parser


def _part(parts: Any, what: str, text: str, sizes: Iterable[int], repeats: int) -> ArgumentParser:
    parser = parts.add_parser(what, help=text)
    parser.add_argument(
        "--n", type=int, nargs="+", default=list(sizes), metavar="N", help="points along an axis"
    )
    parser.add_argument("--precision", nargs="+", choices=PRECISIONS, default=list(PRECISIONS))
    parser.add_argument("--repeats", type=int, default=repeats, metavar="K")
    parser.add_argument(
        "--cpu",
        action="store_true",
        help="time by the processor's clock: for a machine that others use too",
    )
    parser.add_argument(
        "--quick", action="store_true", help="the smallest n only, 3 repeats at most"
    )
    parser.add_argument(
        "-o", "--out", metavar="DIR", help="write tables, JSON lines and pictures here"
    )
    parser.set_defaults(what=what)
    return parser


def run(args: Namespace) -> int:
    """Run one benchmark, bench_WHAT(args) of bench/WHAT.py. Raises SceneError for arguments that
    make no sense."""
    from hpc_gfmd.parallel.world import world

    if min(args.n) < 8 or any(n % 4 for n in args.n):
        raise SceneError(f"--n: found {args.n}, allowed: multiples of 4 from 8")
    if args.repeats < 1:
        raise SceneError(f"--repeats: found {args.repeats}, allowed: a whole number from 1")
    if args.what in ALONE and world().size > 1:
        raise SceneError(f"bench {args.what}: found {world().size} ranks, allowed: one")
    if args.quick:
        args.n, args.repeats = [min(args.n)], min(args.repeats, 3)
    getattr(import_module(f".{args.what}", __package__), f"bench_{args.what}")(args)
    return 0
