"""One of this package's solvers on one case, as a user gets it: with its start on coarser grids and its certificate."""

import time
from dataclasses import dataclass, replace

import numpy as np

from ..driver.sweep import Sweep
from ..scene import Solver


@dataclass(frozen=True)
class Solved:
    """seconds, cpu_seconds: of the solve and of the pressure field, without planning and compilation; fft_pairs: everything counted;
    pressure: field, 0 out of contact, unit of E*; estimates: the solver's own (area, mean gap, pressure)."""

    seconds: float
    cpu_seconds: float
    status: str
    iterations: int
    fft_pairs: float
    a_r: float
    gap_mean: float
    pressure: np.ndarray
    estimates: tuple


class Ours:
    """Plans everything in __init__; `solve` can then be called again and again, and begins anew each time."""

    def __init__(self, case, solver="bpx", precision="double", nested=True, max_iterations=100_000):
        self.case = case
        self.settings = Solver(name=solver, precision=precision, nested=nested, max_iterations=max_iterations)
        self.sweep = Sweep(case.surface, self.settings)
        self.p = case.p_star * self.sweep.surface.g_rms

    def solve(self, accuracy):
        """Solved to a relative accuracy of area, mean gap and pressure."""
        sweep = self.sweep
        sweep.target = replace(sweep.target, accuracy=accuracy, residual=None)
        sweep.solver = sweep.before = None  # nothing is left of the solve before
        begun, cpu = time.perf_counter(), time.process_time()
        step = sweep.solve(self.p)
        contact = step.contact
        pressure = np.asarray(contact.field("pressure"))
        seconds, cpu_seconds = time.perf_counter() - begun, time.process_time() - cpu
        return Solved(seconds, cpu_seconds, contact.outcome.status, step.iterations, step.fft_pairs,
                      contact.contact_points / contact.N, contact.gap_mean, pressure, contact.outcome.errors)
