"""One FFT pair, forward and back: our slab passes against whole fields transformed as other
programs do, on any number of ranks."""

from argparse import Namespace
from collections.abc import Callable

import numpy as np
from numpy.typing import DTypeLike

from hpc_gfmd.parallel.comm import Comm
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.parallel.world import world
from hpc_gfmd.util.errors import GfmdError

from .cases import DTYPES
from .report import Report
from .timing import Clock, ratio

COLUMNS = {
    "n": ("n", "5d"),
    "precision": ("precision", "9"),
    "pair": ("pair", "16"),
    "ms_min": ("ms (min)", "9.3f"),
    "ms_median": ("ms (median)", "11.3f"),
    "slab_over_this": ("slab/this", "9.3f"),
    "gflops": ("Gflop/s", "8.2f"),
}
OURS = "slab passes"


def bench_fft(args: Namespace) -> None:
    """Time of a pair of each kind. args: n, precision (lists), repeats, cpu, out."""
    comm = world()
    clock = Clock(comm, args.cpu)
    report = Report("fft", COLUMNS, args.out, comm)
    report.say(
        f"# one pair: forward and back; {clock.name} time; slab/this: median over runs in turn;"
        " flops 5 N log2 N per pair"
    )
    for n in args.n:
        for precision in args.precision:
            dtype = DTYPES[precision]
            samples = clock.alternate(
                {OURS: slab_pair((n, n), dtype, comm)} | bare_pairs((n, n), dtype, comm),
                args.repeats,
                warmup=2,
            )
            for name, sample in samples.items():
                report.add(
                    n=n,
                    precision=precision,
                    pair=name,
                    clock=clock.name,
                    repeats=args.repeats,
                    ms_min=1e3 * sample.min,
                    ms_median=1e3 * sample.median,
                    slab_over_this=ratio(samples[OURS], sample),
                    gflops=5e-9 * n * n * np.log2(n * n) / sample.min,
                )
    report.finish()


def slab_pair(n: tuple[int, int], dtype: DTypeLike, comm: Comm) -> Callable[[], None]:
    """A function: our passes on a field, read by rows, forward, back, written by rows; nothing is
    done to the spectrum."""
    grid = Grid(n, comm=comm)
    fft, u = grid.fft(dtype), np.zeros(grid.shape, dtype)

    def read(i0: int, i1: int, x: np.ndarray) -> None:
        x[: i1 - i0] = u[i0:i1]

    def write(i0: int, i1: int, x: np.ndarray) -> None:
        u[i0:i1] = x[: i1 - i0]

    def pair() -> None:
        fft.forward_rows(read)
        fft.columns(lambda block, m: None)
        fft.backward_rows(write)

    return pair


def bare_pairs(n: tuple[int, int], dtype: DTypeLike, comm: Comm) -> dict[str, Callable[[], None]]:
    """{name: function} of all that work on this number of ranks: each planned, with (zero) fields
    of its own, without normalisation.

    Raises GfmdError where mpi4py-fft is missing.
    """
    try:
        from mpi4py import MPI
        from mpi4py_fft import PFFT, fftw
    except ImportError as error:
        raise GfmdError(
            f"mpi4py-fft cannot be imported ({error}): install the extra 'mpi'"
        ) from None
    pfft = PFFT(comm.mpi or MPI.COMM_SELF, n, dtype=np.dtype(dtype))
    for transform in (pfft.forward, pfft.backward):
        transform.input_array[...] = 0

    def default() -> None:
        pfft.forward(normalize=False)
        pfft.backward(normalize=False)

    if comm.size > 1:
        return {"PFFT": default}
    x, q = (
        fftw.aligned(n, dtype=np.dtype(dtype)),
        fftw.aligned((n[0], n[1] // 2 + 1), dtype=np.result_type(dtype, np.complex64)),
    )
    flags = (fftw.FFTW_MEASURE,)
    forward = fftw.rfftn(x, None, (0, 1), 1, flags, q)
    backward = fftw.irfftn(q, tuple(n), (0, 1), 1, flags, output_array=x)
    x[...], q[...] = 0, 0

    def two_dimensional() -> None:
        forward(x, q)
        backward(q, x)

    return {"PFFT": default, "FFTW 2-D": two_dimensional}
