"""`accuracy = eps`: no error estimate is exceeded by the true error, and the solver stops hardly later than one who knows it would."""

import os
from dataclasses import dataclass

import numpy as np
import pytest
from slow.cases import rough_scenes

from hpc_gfmd.driver.nested import Nested
from hpc_gfmd.driver.sweep import Sweep
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.problem import Problem
from hpc_gfmd.scene import Solver
from hpc_gfmd.solvers.bpx import Bpx
from hpc_gfmd.surface import build_surface

PROBLEMS = float(os.environ.get("HPC_GFMD_PROBLEMS", 1))  # 1: all of them, 0.1: a tenth
SEED = int(os.environ.get("HPC_GFMD_SEED", 90210))
ACCURACIES = {"single": (1e-2, 1e-3, 1e-4), "double": (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)}
NAMES = ("area", "gap", "pressure")


@dataclass(frozen=True)
class Truth:
    """contact: points; gap_mean and pressure in the program's units; residual: how exact this is."""

    contact: int
    gap_mean: float
    pressure: np.ndarray
    residual: float

    def errors(self, contact, gap_mean, pressure):
        """True relative errors of area, mean gap, pressure field."""
        gap = abs(gap_mean - self.gap_mean) / self.gap_mean if self.gap_mean else float(gap_mean > 0)
        p = np.linalg.norm(np.subtract(pressure, self.pressure, dtype=np.float64)) / np.linalg.norm(self.pressure)
        return np.array([abs(contact - self.contact) / self.contact, gap, p])


def _started(surface, p_star):
    problem = Problem(surface.grid, surface.h, p_star)
    g, _ = Nested(surface.grid, surface.h.dtype).start(problem, Bpx)
    solver = Bpx(problem)
    solver.start(g)
    return solver


def _truth(surface, p_star):
    solver = _started(surface, p_star)
    for _ in range(200):
        if solver.progress().residual < 1e-11:
            break
        solver.step()
    now = solver.progress()
    return Truth(now.contact, now.gap_mean, solver.p, now.residual)


def _oracle_stops(surface, p_star, truth, accuracies):
    """For every accuracy the iterations at which all true errors, and at which all estimates, are below it for the first time."""
    solver = _started(surface, p_star)
    known, believed = {}, {}
    for _ in range(80):
        now = solver.progress()
        true = truth.errors(now.contact, now.gap_mean, solver.p).max()
        for eps in accuracies:
            if true < eps:
                known.setdefault(eps, solver.iterations)
            if max(now.estimates) < eps:
                believed.setdefault(eps, solver.iterations)
        if len(believed) == len(accuracies):
            break
        solver.step()
    return [believed[eps] - known.get(eps, believed[eps]) for eps in believed]


def _solved(scene, precision, eps):
    sweep = Sweep(lambda dtype: build_surface(scene.surface, SerialComm(), dtype), Solver(accuracy=eps, precision=precision))
    step = sweep.solve(sweep.pressures(scene.load)[0])
    return step.contact.outcome, step.contact


@pytest.mark.slow
def test_no_true_error_exceeds_its_estimate():
    scenes = rough_scenes(max(int(300 * PROBLEMS), 3), SEED)
    exceeded, unfinished, ratios, late = [], [], {}, {}
    for number, scene in enumerate(scenes):
        p_star = scene.load.p_star[0]
        surfaces = {name: build_surface(scene.surface, SerialComm(), np.dtype(dtype))
                    for name, dtype in (("double", np.float64), ("single", np.float32))}
        truth = _truth(surfaces["double"], p_star)
        for precision, accuracies in ACCURACIES.items():
            late.setdefault(precision, []).extend(_oracle_stops(surfaces[precision], p_star, truth, accuracies))
            for eps in accuracies:
                outcome, contact = _solved(scene, precision, eps)
                true = truth.errors(contact.contact_points, contact.certificate.gap_mean, contact.q)
                where = (number, precision, eps, p_star, scene.surface.n, outcome.status, outcome.errors, tuple(true), truth.residual)
                if outcome.status != "converged":
                    unfinished.append(where)
                ratios.setdefault((precision, eps), []).append(true / np.maximum(outcome.errors, 1e-11))
                # A reference has rounding errors too.
                if np.any(true > np.maximum(outcome.errors, 1e-11)):
                    exceeded.append(where)
    for (precision, eps), values in ratios.items():
        worst = ", ".join(f"{name} {x:.2f}" for name, x in zip(NAMES, np.max(values, axis=0), strict=True))
        print(f"{precision} {eps:g}: {len(values)} problems, largest true error over estimate: {worst}")
    for precision, extra in late.items():
        print(f"{precision}: stops {np.mean(extra):.2f} iterations after an oracle on average, at most {np.max(extra)}")
    print("not converged:", *unfinished, sep="\n  ")
    print("exceeded:", *exceeded, sep="\n  ")
    assert not exceeded
    assert all(np.mean(extra) <= 3 for extra in late.values())
    # In single precision an accuracy may be out of reach, which the status tells.
    assert not [where for where in unfinished if where[1] == "double"]
