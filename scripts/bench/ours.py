"""This package's solvers on one case, as a user gets them: with the start on coarser grids and the
certificate."""

import time
from dataclasses import dataclass
from typing import Literal

import numpy as np

from hpc_gfmd.certificate.criterion import Target
from hpc_gfmd.driver.sweep import Sweep
from hpc_gfmd.scene import Solver
from hpc_gfmd.solvers import solver_class

from .cases import Case


@dataclass(frozen=True)
class Solved:
    """seconds, cpu_seconds: of the solve and of the pressure field, without planning and
    compilation; fft_pairs: everything counted; pressure: field, 0 out of contact, unit of E*;
    estimates: the solver's own (area, mean gap, pressure)."""

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
    """Plans everything for a case and a precision; `solve` can then be called again and again, and
    begins anew each time."""

    def __init__(self, case: Case, precision: Literal["single", "double"] = "double"):
        self.sweep = Sweep(case.surface, Solver(precision=precision, nested=True), body=case.body)
        self.p_mean = case.p_star * self.sweep.surface.g_rms
        self.nested = self.sweep.nested

    def solve(
        self,
        accuracy: float | None,
        solver: str = "bpx",
        nested: bool = True,
        max_iterations: int = 100_000,
        residual: float | None = None,
        budget: float = np.inf,
    ) -> Solved:
        """Solved to a relative accuracy of area, mean gap and pressure, from coarser grids (nested)
        or from a flat plane.

        With residual given it is that, the rms of the pressure on open points over p0, that ends
        the solve; accuracy is then None. budget: seconds after which the solve is interrupted.
        """
        sweep = self.sweep
        sweep.target = Target(accuracy, residual, max_iterations)
        sweep.solver_class, sweep.nested = solver_class(solver), self.nested if nested else None
        sweep.solver = None  # nothing is left of the solve before
        begun, cpu = time.perf_counter(), time.process_time()
        contact = sweep.solve(
            self.p_mean, lambda iterations, progress: time.perf_counter() - begun > budget
        )
        pressure = np.asarray(contact.field("pressure"))
        seconds, cpu_seconds = time.perf_counter() - begun, time.process_time() - cpu
        return Solved(
            seconds,
            cpu_seconds,
            contact.status,
            contact.iterations,
            contact.fft_pairs,
            contact.contact_points / contact.N,
            contact.gap_mean,
            pressure,
            contact.certificate.errors,
        )
