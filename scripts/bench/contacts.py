"""The contacts that are measured: self-affine surfaces like those of the paper, solved with
hpc_gfmd.solve, and the true errors of the solutions."""

import time
import warnings
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

import hpc_gfmd
from hpc_gfmd.scene import Scene
from hpc_gfmd.surface import build_surface

LARGEST_REFERENCE_ERROR = 1e-6  # estimated error of the pressure that a reference may have


@dataclass(frozen=True)
class RoughContact:
    """A self-affine surface of size 1 x 1 and its load, with E* = 1 and g_rms = 1.

    Attributes
    ----------
    n : int
        Points along an axis.
    p_star : float
        p/(E* g_rms).
    hurst : float
        Hurst exponent.
    boundary : str
        "periodic" or "free". With free edges g_rms is that of the periodic surface from which the
        heights are cut out.
    hardness : float
        Largest pressure over E* g_rms; 0 for an elastic body.
    seed : int
        Seed of the surface.
    L_over_lam_l, lam_s_over_a : float
        Longest waves along an axis and grid spacings in the shortest one.
    """

    n: int
    p_star: float
    hurst: float = 0.8
    boundary: str = "periodic"
    hardness: float = 0.0
    seed: int = 1
    L_over_lam_l: float = 2.0
    lam_s_over_a: float = 2.0

    @property
    def table(self):
        """Return the table [surface] of a scene."""
        return {
            "kind": "self-affine",
            "hurst": self.hurst,
            "L_over_lam_l": self.L_over_lam_l,
            "lam_l_over_lam_s": self.n / (self.L_over_lam_l * self.lam_s_over_a),
            "lam_s_over_a": self.lam_s_over_a,
            "seed": self.seed,
            "g_rms": 1.0,
            "boundary": self.boundary,
        }

    def scene(self, **tables):
        """Return the scene; **tables are those beside [surface] and [load]."""
        return Scene.from_dict({"surface": self.table, "load": {"p_star": self.p_star}} | tables)

    def build(self, comm, dtype, threads=1):
        """Return the surface as solvers take it, each rank with its rows. Collective."""
        return build_surface(self.scene().surface, comm, dtype, threads)

    @cached_property
    def surface(self):
        """The surface as hpc_gfmd.make_surface returns it, peaks up."""
        return hpc_gfmd.make_surface(**self.table)

    def press(self, **settings):
        """Return the row and the pressure of `timed_solve`; **settings replace the contact's."""
        contact = {"pressure": self.p_star, "hardness": self.hardness or None}
        return timed_solve(self.surface, **contact | settings)

    def at_area(self, a_r):
        """Return the same surface at a load with about this contact area."""
        row, _ = self.press(pressure=None, a_r=a_r)
        return replace(self, p_star=float(f"{row['p_star']:.3g}"))

    @cached_property
    def reference(self):
        """The row and the pressure of a solution far more accurate than those that are measured.
        Raises GfmdError if the solver does not reach that accuracy."""
        row, pressure = self.press(precision="double", residual=1e-9)
        if not row["estimates"][2] < LARGEST_REFERENCE_ERROR:
            raise hpc_gfmd.GfmdError(
                f"reference of {self}: {row['status']} at an estimated error of the pressure of"
                f" {row['estimates'][2]:.1e}, allowed: below {LARGEST_REFERENCE_ERROR:g}"
            )
        return row, pressure

    def errors(self, row, pressure):
        """Return the true relative errors of a solution, as returned by `press`."""
        exact_row, exact_pressure = self.reference
        gap_error = 0.0
        if exact_row["gap_mean"]:
            gap_error = abs(row["gap_mean"] / exact_row["gap_mean"] - 1)
        errors = {
            "area_error": abs(row["a_r"] / exact_row["a_r"] - 1),
            "gap_error": gap_error,
            "pressure_error": distance(pressure, exact_pressure),
        }
        return errors | {"error": max(errors.values())}


def timed_solve(heights, **settings):
    """Solve with hpc_gfmd.solve and time the whole call.

    **settings are its arguments. Return a row of times and numbers of the solution, and its
    pressure.
    """
    wall_begin = time.perf_counter()
    cpu_begin = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hpc_gfmd.NotConverged)
        solution = hpc_gfmd.solve(heights, fields=["pressure"], **settings)
    pressure = np.asarray(solution.pressure)
    row = {
        "seconds": time.perf_counter() - wall_begin,
        "cpu_seconds": time.process_time() - cpu_begin,
        "status": solution.status,
        "iterations": solution.iterations,
        "fft_pairs": solution.fft_pairs,
        "p_star": solution.p,
        "a_r": solution.a_r,
        "gap_mean": solution.gap_mean,
        "estimates": list(solution.errors),
    }
    return row, pressure


def distance(pressure, exact_pressure):
    """Return the L2 norm of the difference of two fields over that of the second one."""
    difference = np.subtract(pressure, exact_pressure, dtype=np.float64)
    return float(np.linalg.norm(difference) / np.linalg.norm(exact_pressure))
