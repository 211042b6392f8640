"""The contacts that are measured: self-affine surfaces of the paper's kind, pressed as a user does,
and the errors of what comes out."""

import time
import warnings
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

import hpc_gfmd
from hpc_gfmd.scene import Scene
from hpc_gfmd.surface import build_surface

WORST = 1e-6  # estimated error of the pressure that a reference may have


@dataclass(frozen=True)
class Case:
    """n x n points, p* = p/(E* g_rms); E* = 1, g_rms = 1 (where the surface ends, of what it is cut
    out of), a cell of size 1 x 1. hardness: the largest pressure over E* g_rms; 0: none."""

    n: int
    p_star: float
    hurst: float = 0.8
    boundary: str = "periodic"
    hardness: float = 0.0
    seed: int = 1

    @property
    def table(self):
        """Return [surface] of a scene."""
        return {
            "kind": "self-affine",
            "hurst": self.hurst,
            "L_over_lam_l": 2,
            "lam_l_over_lam_s": self.n / 4,
            "lam_s_over_a": 2,
            "seed": self.seed,
            "g_rms": 1.0,
            "boundary": self.boundary,
        }

    def scene(self, **tables):
        """Make the scene; tables: others than surface and load."""
        return Scene.from_dict({"surface": self.table, "load": {"p_star": self.p_star}} | tables)

    def build(self, comm, dtype, threads=1):
        """Make the wall as solvers take it, each rank its rows."""
        return build_surface(self.scene().surface, comm, dtype, threads)

    @cached_property
    def surface(self):
        """Make the wall, peaks up."""
        return hpc_gfmd.make_surface(**self.table)

    def press(self, **settings):
        """Return numbers of hpc_gfmd.solve, all of the call timed, and the pressure; settings: of
        solve."""
        usual = {"pressure": self.p_star, "hardness": self.hardness or None}
        begun, cpu = time.perf_counter(), time.process_time()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", hpc_gfmd.NotConverged)
            solution = hpc_gfmd.solve(self.surface, fields=["pressure"], **usual | settings)
        pressure = np.asarray(solution.pressure)
        row = {
            "seconds": time.perf_counter() - begun,
            "cpu_seconds": time.process_time() - cpu,
            "status": solution.status,
            "iterations": solution.iterations,
            "fft_pairs": solution.fft_pairs,
            "p_star": solution.p,
            "a_r": solution.a_r,
            "gap_mean": solution.gap_mean,
            "estimates": list(solution.errors),
        }
        return row, pressure

    def at_area(self, a_r):
        """Return the same surface at the load at which about a share a_r of it touches."""
        row, _ = self.press(pressure=None, a_r=a_r)
        return replace(self, p_star=float(f"{row['p_star']:.3g}"))

    @cached_property
    def reference(self):
        """Solve far tighter than any that is measured. Raises GfmdError where that fails."""
        row, pressure = self.press(precision="double", residual=1e-9)
        if not row["estimates"][2] < WORST:
            raise hpc_gfmd.GfmdError(
                f"reference of {self}: {row['status']} at an estimated error of the pressure of"
                f" {row['estimates'][2]:.1e}, allowed: below {WORST:g}"
            )
        return row, pressure

    def errors(self, row, pressure):
        """Return the true relative errors of a solution."""
        known, wanted = self.reference
        found = {
            "area_error": abs(row["a_r"] / known["a_r"] - 1),
            "gap_error": abs(row["gap_mean"] / known["gap_mean"] - 1) if known["gap_mean"] else 0.0,
            "pressure_error": distance(pressure, wanted),
        }
        return found | {"error": max(found.values())}


def distance(pressure, wanted):
    """Return the relative L2 distance of two fields."""
    difference = np.subtract(pressure, wanted, dtype=np.float64)
    return float(np.linalg.norm(difference) / np.linalg.norm(wanted))
