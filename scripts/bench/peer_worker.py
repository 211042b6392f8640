"""Codes that solve the same contact, each in its own way; started by peers.py with the Python that
has the code. Answers lines of JSON:

    {"heights": path.npy, "pressure": p0, "kind": "Aspher", ...}   plan for this surface (float64,
        n x n, peaks up, of size 1 x 1, E* = 1) with a class of this file and settings of it;
        "hardness": of an elastic - perfectly plastic body
    {"tolerance": t, "pressure_to": path.npy}   solve from scratch; answers seconds, cpu_seconds,
        iterations, status, peak_mib

Planning and compilation are never inside of the times.
"""

import json
import math
import os
import sys
import time
from functools import partial
from importlib.metadata import distributions
from pathlib import Path

os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")

import numpy as np  # reads the variables above
from peak import peak_mib  # beside this file

MAX_ITERATIONS = 20000


class Ours:
    """hpc_gfmd.solve, all of it. Asked for a residual: only the pressure is wanted, as of the
    others; `accuracy` goes on until area and mean gap are as good."""

    packages = ("hpc-gfmd", "numba", "mpi4py-fft")

    def __init__(self, heights, p0, **settings):
        import hpc_gfmd

        self.settings = settings | {"fields": ["pressure"]}
        self.press = partial(hpc_gfmd.solve, heights, p0)
        self.solve(0.5)

    def solve(self, tolerance):
        found = self.press(residual=tolerance, **self.settings)
        return np.asarray(found.pressure), found.iterations, found.status

    @staticmethod
    def pressure(field):
        return field


class Aspher:
    """solve_nested, ASPHER's fastest for this problem; settings: others of its arguments."""

    packages = ("aspher",)

    def __init__(self, heights, p0, **settings):
        self.settings = {
            "backend": "periodic",
            "grid_size": len(heights),
            "gap": np.ascontiguousarray(heights.max() - heights).ravel(),
            "p_nominal": p0,
            "coarsest": min(64, len(heights)),
            "max_iter": MAX_ITERATIONS,
            "light_result": True,
        } | settings
        self.solve(1e-2)  # FFTW keeps the plans

    def solve(self, tolerance):
        import aspher

        result = aspher.solve_nested(tol=tolerance, **self.settings)
        return result, int(result.iterations), str(result.status)

    @staticmethod
    def pressure(result):
        return np.asarray(result.pressure)


class Tamaas:
    """PolonskyKeerRey with the pressure as its variable; with a hardness KatoSaturated."""

    packages = ("tamaas",)

    def __init__(self, heights, p0, hardness=None):
        import tamaas as tm

        tm.initialize(1)
        tm.set_log_level(tm.LogLevel.error)
        self.tm, self.p0, self.heights = tm, p0, np.ascontiguousarray(heights)
        self.hardness = hardness
        self.model = tm.Model(tm.model_type.basic_2d, [1.0, 1.0], list(heights.shape))
        self.model.E, self.model.nu = 1.0, 0.0
        self.solve(1e-1, 3)

    def solve(self, tolerance, max_iterations=MAX_ITERATIONS):
        self.model.traction[...] = 0
        self.model.displacement[...] = 0
        if self.hardness:
            solver = self.tm.KatoSaturated(self.model, self.heights, tolerance, self.hardness)
        else:
            solver = self.tm.PolonskyKeerRey(self.model, self.heights, tolerance)
        solver.max_iter, solver.dump_freq = max_iterations, 10 * max_iterations
        left = solver.solve(self.p0)
        return None, None, "converged" if left <= tolerance else "not converged"

    def pressure(self, _):
        return np.asarray(self.model.traction).reshape(self.heights.shape)


class ContactMechanicsPK:
    """constrained_conjugate_gradients: Polonsky and Keer at a given force. Its three tolerances are
    tied to one relative number."""

    packages = ("ContactMechanics", "SurfaceTopography", "NuMPI", "muGrid")

    def __init__(self, heights, p0, free=False, hardness=None):
        import ContactMechanics as cm
        from ContactMechanics.Factory import make_system
        from SurfaceTopography import Topography

        self.n = n = len(heights)
        kind = cm.FreeFFTElasticHalfSpace if free else cm.PeriodicFFTElasticHalfSpace
        substrate = kind((n, n), 1.0, (1.0, 1.0))
        surface = Topography(heights, (1.0, 1.0), periodic=not free)
        self.system = make_system(interaction="hardwall", substrate=substrate, surface=surface)
        self.h_rms, self.p0, self.force = heights.std(), p0, p0 / n**2  # force per pixel
        self.hardness = {"hardness": hardness / n**2} if hardness else {}
        substrate.evaluate_disp(np.ones((n, n)))

    def solve(self, tolerance):
        result = self.system.minimize_proxy(
            external_force=self.p0,
            pentol=tolerance * self.h_rms,
            forcetol=tolerance * self.force,
            thermotol=tolerance,
            maxiter=MAX_ITERATIONS,
            **self.hardness,
        )
        return result.jac, int(result.nit), "converged" if result.success else "not converged"

    def pressure(self, forces):
        points = math.isqrt(np.size(forces))  # with free edges also those beyond the surface
        return np.asarray(forces).reshape(points, points)[: self.n, : self.n] * self.n**2


class ContactMechanicsCCG(ContactMechanicsPK):
    """Constrained conjugate gradients without restart (Bugnicourt et al.) in the pixel forces, at a
    given mean force."""

    def solve(self, tolerance):
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


KINDS = {
    kind.__name__: kind for kind in (Ours, Aspher, Tamaas, ContactMechanicsPK, ContactMechanicsCCG)
}


def about(kind):
    """Return versions of a code, and how it was built, as scripts/bench-peers-setup left it."""
    there = {found.name: found.version for found in distributions()}
    built = Path(sys.prefix) / "build.json"
    flags = json.loads(built.read_text()) if built.exists() else {}
    return {
        "code_versions": {name: there.get(name, "?") for name in kind.packages},
        "built": flags.get(kind.packages[0], ""),
    }


def solve(code, tolerance, pressure_to):
    """Solve once and write the pressure."""
    begun, cpu = time.perf_counter(), time.process_time()
    result, iterations, status = code.solve(tolerance)
    answer = {
        "seconds": time.perf_counter() - begun,
        "cpu_seconds": time.process_time() - cpu,
        "iterations": iterations,
        "status": status,
        "peak_mib": peak_mib(),
    }
    np.save(pressure_to, code.pressure(result))
    return answer


def main():
    """Answer until standard input ends."""
    answers = os.fdopen(os.dup(1), "w")  # what the codes print must not mix with the answers
    os.dup2(2, 1)
    code = None
    for line in sys.stdin:
        asked = json.loads(line)
        try:
            if "heights" in asked:
                kind, heights = KINDS[asked.pop("kind")], np.load(asked.pop("heights"))
                code = kind(heights, asked.pop("pressure"), **asked)
                answer = about(kind)
            else:
                answer = solve(code, **asked)
        except Exception as error:  # whatever goes wrong in there is the caller's to report
            answer = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    main()
