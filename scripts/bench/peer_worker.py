"""Other codes for the same contact, each in its own way; run by peers.py with the Python of the
peers' environment.

    python peer_worker.py NAME

Reads one JSON object per line and answers each with one:
    {"heights": path.npy, "pressure": p0}     plan for this surface (float64, n x n, peaks up, of
    size 1 x 1, E* = 1) {"tolerance": t, "pressure_to": path.npy} solve from scratch; answers
    seconds, cpu_seconds, iterations, status

Stands alone: imports nothing of the package that it is compared with. Planning and compilation are
never inside of the times.
"""

import json
import math
import os
import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Any

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"

import numpy as np  # noqa: E402 (reads the variables above)

MAX_ITERATIONS = 20000
Solved = tuple[Any, int | None, str]  # what `pressure` takes, iterations, status


class Aspher:
    """solve_nested, ASPHER's fastest for this problem, with its default preconditioner; settings:
    others of its arguments."""

    def __init__(
        self,
        heights: np.ndarray,
        p0: float,
        backend: str = "periodic",
        precision: str = "double",
        **settings: object,
    ):
        self.n, self.p0 = len(heights), p0
        self.settings = settings | {"backend": backend, "precision": precision}
        self.gap = np.ascontiguousarray(heights.max() - heights).ravel()
        self.solve(1e-2)  # FFTW keeps the plans

    def solve(self, tolerance: float) -> Solved:
        import aspher

        result = aspher.solve_nested(
            grid_size=self.n,
            gap=self.gap,
            p_nominal=self.p0,
            domain_size=1.0,
            E_star=1.0,
            coarsest=min(64, self.n),
            tol=tolerance,
            max_iter=MAX_ITERATIONS,
            light_result=True,
            **self.settings,
        )
        return result, int(result.iterations), str(result.status)

    @staticmethod
    def pressure(result: Any) -> np.ndarray:
        return np.asarray(result.pressure)


class Tamaas:
    """PolonskyKeerRey with the pressure as its variable."""

    def __init__(self, heights: np.ndarray, p0: float):
        import tamaas as tm

        tm.initialize(1)
        tm.set_log_level(tm.LogLevel.error)
        self.tm, self.p0, self.heights = tm, p0, np.ascontiguousarray(heights)
        n = len(heights)
        self.model = tm.Model(tm.model_type.basic_2d, [1.0, 1.0], [n, n])
        self.model.E, self.model.nu = 1.0, 0.0
        self.solve(1e-1, 3)

    def solve(self, tolerance: float, max_iterations: int = MAX_ITERATIONS) -> Solved:
        self.model.traction[...] = 0
        self.model.displacement[...] = 0
        solver = self.tm.PolonskyKeerRey(self.model, self.heights, tolerance)
        solver.max_iter, solver.dump_freq = max_iterations, 10 * max_iterations
        left = solver.solve(self.p0)
        return None, None, "converged" if left <= tolerance else "not converged"

    def pressure(self, _: object) -> np.ndarray:
        return np.asarray(self.model.traction).reshape(self.heights.shape)


class ContactMechanicsPK:
    """constrained_conjugate_gradients: Polonsky and Keer at a given force. Its three tolerances are
    tied to one relative number."""

    def __init__(self, heights: np.ndarray, p0: float, free: bool = False):
        import ContactMechanics
        from ContactMechanics.Factory import make_system
        from SurfaceTopography import Topography

        n = len(heights)
        kind = (
            ContactMechanics.FreeFFTElasticHalfSpace
            if free
            else ContactMechanics.PeriodicFFTElasticHalfSpace
        )
        self.substrate = kind((n, n), 1.0, (1.0, 1.0))
        self.surface = Topography(heights, (1.0, 1.0), periodic=not free)
        self.system = make_system(
            interaction="hardwall", substrate=self.substrate, surface=self.surface
        )
        self.h_rms, self.force = heights.std(), p0 / n**2  # force per pixel
        self.n, self.p0 = n, p0
        self.substrate.evaluate_disp(np.ones((n, n)))

    def solve(self, tolerance: float) -> Solved:
        result = self.system.minimize_proxy(
            external_force=self.p0,
            pentol=tolerance * self.h_rms,
            forcetol=tolerance * self.force,
            thermotol=tolerance,
            maxiter=MAX_ITERATIONS,
        )
        return result.jac, int(result.nit), "converged" if result.success else "not converged"

    def pressure(self, forces: Any) -> np.ndarray:
        points = math.isqrt(
            np.size(forces)
        )  # along an axis: with free edges also those beyond the surface
        return np.asarray(forces).reshape(points, points)[: self.n, : self.n] * self.n**2


class ContactMechanicsCCG(ContactMechanicsPK):
    """Constrained conjugate gradients without restart (Bugnicourt et al.) in the pixel forces, at a
    given mean force."""

    def solve(self, tolerance: float) -> Solved:
        from NuMPI.Optimization import CCGWithoutRestart

        result = CCGWithoutRestart.constrained_conjugate_gradients(
            self.system.dual_objective(0.0, gradient=True),
            self.system.dual_hessian_product,
            np.full((self.n, self.n), self.force),
            mean_val=self.force,
            gtol=tolerance * self.h_rms,
            maxiter=MAX_ITERATIONS,
        )
        return result.x, int(result.nit), "converged" if result.success else "not converged"


# With free edges: a convolution on the doubled cell, or fast multipoles of order q (6 by default),
# whose own error limits the pressure and which alone have an active set.
PEERS: dict[str, Callable[[np.ndarray, float], Any]] = {
    "aspher": Aspher,
    "aspher-float": partial(Aspher, precision="float"),
    "aspher-mixed": partial(Aspher, precision="float_then_double"),
    "tamaas": Tamaas,
    "contactmechanics-pk": ContactMechanicsPK,
    "contactmechanics-ccg": ContactMechanicsCCG,
    "aspher-fft": partial(Aspher, backend="fft"),
    "aspher-fft-mixed": partial(Aspher, backend="fft", precision="float_then_double"),
    "aspher-h2": partial(Aspher, backend="h2"),
    "aspher-h2-active": partial(Aspher, backend="h2", active_set=True),
    "aspher-h2-active-float": partial(Aspher, backend="h2", active_set=True, precision="float"),
    "aspher-h2-active-q8": partial(Aspher, backend="h2", active_set=True, q=8),
    "contactmechanics-free-pk": partial(ContactMechanicsPK, free=True),
    "contactmechanics-free-ccg": partial(ContactMechanicsCCG, free=True),
}


def main() -> None:
    """Answer until standard input ends."""
    # What the codes print must not mix with the answers.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    peer: Any = None
    for line in sys.stdin:
        asked = json.loads(line)
        try:
            if "heights" in asked:
                peer = None  # its memory is needed
                peer = PEERS[sys.argv[1]](np.load(asked["heights"]), float(asked["pressure"]))
                answer: dict[str, Any] = {"ready": True}
            else:
                begun, cpu = time.perf_counter(), time.process_time()
                result, iterations, status = peer.solve(float(asked["tolerance"]))
                answer = {
                    "seconds": time.perf_counter() - begun,
                    "cpu_seconds": time.process_time() - cpu,
                    "iterations": iterations,
                    "status": status,
                }
                np.save(asked["pressure_to"], peer.pressure(result))
        except Exception as error:  # whatever goes wrong in there is the caller's to report
            answer = {"error": f"{type(error).__name__}: {error}"}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
