"""`hpc-gfmd bench`: speed of kernels and transforms, time against true error, and other codes on the same surfaces."""

from .number import number

PRECISIONS = ("single", "double")


def add_parser(subparsers):
    parser = subparsers.add_parser("bench", help="kernels, FFT, time against error, other codes",
                                   description="Measure speed. Alternating runs, warmed up; compare numbers of one call only.")
    parts = parser.add_subparsers(metavar="WHAT", required=True)

    kernels = parts.add_parser("kernels", help="passes of the default solver: bytes moved, share of a copy, iteration over FFT pair")
    _common(kernels, (1024, 2048, 4096), 12)
    kernels.add_argument("--p-star", type=number, default=0.05, metavar="P", help="load of the contact that is iterated (default 0.05)")
    kernels.set_defaults(main=main, part=_kernels)

    fft = parts.add_parser("fft", help="our passes against mpi4py-fft's PFFT and FFTW's plans; on all ranks")
    _common(fft, (1024, 2048, 4096), 12)
    fft.set_defaults(main=main, part=_fft)

    accuracy = parts.add_parser("accuracy", help="time and FFT pairs of all solvers against true error")
    _common(accuracy, (512, 1024, 2048, 4096), 3)
    accuracy.add_argument("--p-star", type=number, nargs="+", default=[0.0007, 0.007, 0.05, 0.353, 1.0], metavar="P")
    accuracy.add_argument("--hurst", type=number, nargs="+", default=[0.3, 0.8], metavar="H")
    accuracy.add_argument("--solvers", nargs="+", default=["bpx", "gfmd", "fire", "ccg"], metavar="NAME")
    accuracy.add_argument("--start", nargs="+", choices=("nested", "cold"), default=["nested", "cold"])
    accuracy.add_argument("--accuracy", type=number, nargs="+", default=[1e-2, 1e-3, 1e-4, 1e-5, 1e-6], metavar="EPS")
    accuracy.add_argument("--max-iterations", type=int, default=2000, metavar="K")
    accuracy.add_argument("--budget", type=number, default=120.0, metavar="S", help="seconds after which a solve is interrupted, "
                          "not repeated, and tighter accuracies are not tried (default 120)")
    accuracy.set_defaults(main=main, part=_accuracy)

    scaling = parts.add_parser("scaling", help="strong and weak scaling under mpirun, where the time goes, and a model of a cluster")
    _common(scaling, (2048, 4096), 3)
    scaling.add_argument("--ranks", type=int, nargs="+", default=[1, 2], metavar="K", help="numbers of ranks (default 1 2)")
    scaling.add_argument("--threads", type=int, nargs="+", default=[1, 2], metavar="T", help="threads of one rank (default 1 2)")
    scaling.add_argument("--p-star", type=number, default=0.05, metavar="P", help="load (default 0.05)")
    scaling.set_defaults(main=main, part=_scaling)

    storage = parts.add_parser("storage", help="result file against a raw write; on all ranks")
    _common(storage, (4096, 8192), 3)
    storage.add_argument("--folder", default=".", metavar="DIR", help="where to write (default: here)")
    storage.set_defaults(main=main, part=_storage)

    peers = parts.add_parser("peers", help="ASPHER, Tamaas, ContactMechanics at equal true error (scripts/bench-peers-setup first)")
    _common(peers, (1024,), 5)
    peers.add_argument("--p-star", type=number, nargs="+", default=[0.007, 0.353], metavar="P")
    peers.add_argument("--hurst", type=number, default=0.8, metavar="H")
    peers.add_argument("--codes", nargs="*", default=None, metavar="NAME", help="which of the other codes (default: all)")
    peers.add_argument("--error", type=number, default=1e-5, metavar="E", help="relative L2 error of the pressure (default 1e-5)")
    peers.add_argument("--budget", type=number, default=60.0, metavar="S", help="seconds per code and case (default 60)")
    peers.set_defaults(main=main, part=_peers)


def _common(parser, sizes, repeats):
    parser.add_argument("--n", type=int, nargs="+", default=list(sizes), metavar="N", help="points along an axis")
    parser.add_argument("--precision", nargs="+", choices=PRECISIONS, default=list(PRECISIONS))
    parser.add_argument("--repeats", type=int, default=repeats, metavar="K")
    parser.add_argument("--cpu", action="store_true", help="time by the processor's clock: for a machine that others use too")
    parser.add_argument("--quick", action="store_true", help="the smallest n only, 3 repeats at most")
    parser.add_argument("-o", "--out", metavar="DIR", help="write tables, JSON lines and pictures here")


def main(args) -> int:
    """Run one benchmark. Raises SceneError for arguments that make no sense."""
    from ..errors import SceneError

    if min(args.n) < 8 or any(n % 4 for n in args.n):
        raise SceneError(f"--n: found {args.n}, allowed: multiples of 4 from 8")
    if args.repeats < 1:
        raise SceneError(f"--repeats: found {args.repeats}, allowed: a whole number from 1")
    if args.quick:
        args.n, args.repeats = [min(args.n)], min(args.repeats, 3)
    args.part(args)
    return 0


def _kernels(args):
    from ..bench.kernels import bench_kernels

    bench_kernels(args.n, args.precision, args.p_star, args.repeats, args.cpu, args.out)


def _fft(args):
    from ..bench.transforms import bench_fft

    bench_fft(args.n, args.precision, args.repeats, args.cpu, args.out)


def _storage(args):
    from ..bench.storage import bench_storage

    bench_storage(args.n, args.folder, args.repeats, args.out)


def _scaling(args):
    from ..bench.scaling import bench_scaling

    bench_scaling(args.n, args.ranks, args.threads, args.precision, args.p_star, args.repeats, args.out)


def _accuracy(args):
    from ..bench.accuracy import bench_accuracy

    _alone("accuracy")
    _known("--solvers", args.solvers, _solver_names())
    bench_accuracy(args)


def _peers(args):
    from ..bench.peers import NAMES, bench_peers

    _alone("peers")
    codes = NAMES if args.codes is None else args.codes
    _known("--codes", codes, NAMES)
    bench_peers(args.n, args.p_star, args.hurst, args.precision, codes, args.error, args.repeats, args.budget, args.out)


def _solver_names():
    from ..registry import solver_names

    return solver_names()


def _known(key, found, allowed):
    from ..errors import SceneError

    wrong = [name for name in found if name not in allowed]
    if wrong:
        raise SceneError(f"{key}: found {wrong[0]!r}, allowed: {', '.join(allowed)}")


def _alone(what):
    from ..errors import SceneError
    from ..parallel.comm import world

    if world().size > 1:
        raise SceneError(f"bench {what}: found {world().size} ranks, allowed: one")
