"""Codes that solve the same contact.

peers.py starts this file with the Python in which a code is installed. It answers lines of JSON:

    {"heights": path.npy, "pressure": p0, "kind": "Aspher", ...}
        Plan for a surface (float64, n x n, peaks up, of size 1 x 1, E* = 1) with a class of this
        file and its settings; "hardness" is that of an elastic, perfectly plastic body. The answer
        has the versions of the code.
    {"tolerance": t, "pressure_to": path.npy}
        Solve from scratch and save the pressure. The answer has seconds, cpu_seconds, iterations,
        status and peak_mib.

The times contain neither planning nor compilation.
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
    """This package: the whole of hpc_gfmd.solve.

    A residual is requested, because only the pressure is compared; with `accuracy` the solver would
    continue until area and mean gap are as accurate.
    """

    packages = ("hpc-gfmd", "numba", "mpi4py-fft")

    def __init__(self, heights, p0, **settings):
        import hpc_gfmd

        self.settings = settings | {"fields": ["pressure"], "threads": 1}
        self.press = partial(hpc_gfmd.solve, heights, p0)
        self.solve(0.5)

    def solve(self, tolerance):
        solution = self.press(residual=tolerance, **self.settings)
        return np.asarray(solution.pressure), solution.iterations, solution.status

    @staticmethod
    def pressure(field):
        return field


class Aspher:
    """ASPHER with solve_nested, its fastest solver for this problem."""

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
        self.solve(1e-2)  # makes the plans of FFTW

    def solve(self, tolerance):
        import aspher

        result = aspher.solve_nested(tol=tolerance, **self.settings)
        return result, int(result.iterations), str(result.status)

    @staticmethod
    def pressure(result):
        return np.asarray(result.pressure)


class Tamaas:
    """Tamaas with PolonskyKeerRey in the pressure, or KatoSaturated with a hardness."""

    packages = ("tamaas",)

    def __init__(self, heights, p0, hardness=None):
        import tamaas as tm

        tm.initialize(1)
        tm.set_log_level(tm.LogLevel.error)
        self.tm = tm
        self.p0 = p0
        self.heights = np.ascontiguousarray(heights)
        self.hardness = hardness
        self.model = tm.Model(tm.model_type.basic_2d, [1.0, 1.0], list(heights.shape))
        self.model.E = 1.0
        self.model.nu = 0.0
        self.solve(1e-1, max_iterations=3)

    def solve(self, tolerance, max_iterations=MAX_ITERATIONS):
        self.model.traction[...] = 0
        self.model.displacement[...] = 0
        if self.hardness:
            solver = self.tm.KatoSaturated(self.model, self.heights, tolerance, self.hardness)
        else:
            solver = self.tm.PolonskyKeerRey(self.model, self.heights, tolerance)
        solver.max_iter = max_iterations
        solver.dump_freq = 10 * max_iterations
        error = solver.solve(self.p0)
        return None, None, "converged" if error <= tolerance else "not converged"

    def pressure(self, _):
        return np.asarray(self.model.traction).reshape(self.heights.shape)


class ContactMechanicsPK:
    """ContactMechanics with the conjugate gradients of Polonsky and Keer at a given force.

    One relative tolerance sets its three tolerances.
    """

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
        self.h_rms = heights.std()
        self.p0 = p0
        self.force = p0 / n**2  # per pixel
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
        points = math.isqrt(np.size(forces))  # with free edges they reach beyond the surface
        return np.asarray(forces).reshape(points, points)[: self.n, : self.n] * self.n**2


class ContactMechanicsCCG(ContactMechanicsPK):
    """ContactMechanics with the conjugate gradients without restart of Bugnicourt et al., in the
    pixel forces at a given mean force."""

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


def versions_of(kind):
    """Return the versions of a code's packages and its build flags.

    scripts/bench-peers-setup stores the flags.
    """
    installed = {package.name: package.version for package in distributions()}
    path = Path(sys.prefix) / "build.json"
    flags = json.loads(path.read_text()) if path.exists() else {}
    return {
        "code_versions": {name: installed.get(name, "?") for name in kind.packages},
        "built": flags.get(kind.packages[0], ""),
    }


def solve(code, tolerance, pressure_to):
    """Solve once, save the pressure to a file and return the numbers of the solve; the tolerance
    has the meaning of the code."""
    wall_begin = time.perf_counter()
    cpu_begin = time.process_time()
    result, iterations, status = code.solve(tolerance)
    answer = {
        "seconds": time.perf_counter() - wall_begin,
        "cpu_seconds": time.process_time() - cpu_begin,
        "iterations": iterations,
        "status": status,
        "peak_mib": peak_mib(),
    }
    np.save(pressure_to, code.pressure(result))
    return answer


def main():
    """Answer until standard input ends."""
    answers = os.fdopen(os.dup(1), "w")  # apart from the output of the codes
    os.dup2(2, 1)
    code = None
    for line in sys.stdin:
        question = json.loads(line)
        try:
            if "heights" in question:
                kind = KINDS[question.pop("kind")]
                heights = np.load(question.pop("heights"))
                code = kind(heights, question.pop("pressure"), **question)
                answer = versions_of(kind)
            else:
                answer = solve(code, **question)
        except Exception as error:  # whatever fails in a code, peers.py reports it
            answer = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    main()
