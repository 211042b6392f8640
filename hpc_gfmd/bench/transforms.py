"""The FFT pair of our slab passes against other programs' pairs, on any number of ranks."""

import numpy as np

from ..grid import Grid
from ..parallel.bare_fft import bare_pairs
from ..parallel.comm import world
from .report import Report
from .timing import Clock, ratio

COLUMNS = {"n": ("n", "5d"), "precision": ("precision", "9"), "pair": ("pair", "16"), "ms_min": ("ms (min)", "9.3f"),
           "ms_median": ("ms (median)", "11.3f"), "slab_over_this": ("slab/this", "9.3f"), "gflops": ("Gflop/s", "8.2f")}
DTYPES = {"single": np.float32, "double": np.float64}


class SlabPair:
    """Our passes on a field: read by rows, forward, back, written by rows; nothing is done to the spectrum."""

    name = "slab passes"

    def __init__(self, n, dtype, comm):
        self.grid = Grid(n, comm=comm)
        self.fft = self.grid.fft(dtype)
        self.u = np.zeros(self.grid.shape, dtype)

    def __call__(self):
        def fill(i0, i1, x):
            x[: i1 - i0] = self.u[i0:i1]

        def use(i0, i1, x):
            self.u[i0:i1] = x[: i1 - i0]

        self.fft.forward_rows(fill)
        self.fft.columns(lambda block, m: None)
        self.fft.backward_rows(use)


def bench_fft(sizes, precisions, repeats, cpu, out):
    """Time of one pair, forward and back, of each kind."""
    comm = world()
    clock = Clock(comm, cpu)
    report = Report("fft", COLUMNS, out, comm)
    report.say(f"# one pair: forward and back; {clock.name} time; slab/this: median over runs in turn; flops 5 N log2 N per pair")
    for n in sizes:
        for precision in precisions:
            pairs = {SlabPair.name: SlabPair((n, n), DTYPES[precision], comm)} | bare_pairs((n, n), DTYPES[precision], comm)
            samples = clock.alternate(pairs, repeats, warmup=2)
            for name, sample in samples.items():
                report.add(n=n, precision=precision, pair=name, clock=clock.name, repeats=repeats, ms_min=1e3 * sample.min,
                           ms_median=1e3 * sample.median, slab_over_this=ratio(samples[SlabPair.name], sample),
                           gflops=5e-9 * n * n * np.log2(n * n) / sample.min)
    report.finish()
    return report.rows
