"""One load after another on one surface: which precision, which start, and what comes out."""

from dataclasses import dataclass, replace

import numpy as np

from ..contact import Contact
from ..errors import SceneError
from ..problem import Problem
from ..registry import solver_class
from .certificate import Certificate, certify
from .drive import Outcome, Target, drive
from .nested import cold_gap, nested_gap

SINGLE_ACCURACY = 1e-4  # the finest accuracy that is tried in single precision
WARM_RATIO = 1.25  # loads that differ by a smaller factor start from each other's solution, others from coarser grids
FULL_P_STAR = 0.5  # full contact needs p* above std(p)/(E* g_rms) = 1/2 (unless the surface is very skewed)


@dataclass(frozen=True)
class Step:
    """A solved load. contact: its fields; iterations on the fine grid; fft_pairs: everything counted, in fine-grid pairs."""

    contact: Contact
    iterations: int
    fft_pairs: float


def first_precision(settings):
    """The precision that a sweep begins with; settings: scene.Solver."""
    if settings.precision != "auto":
        return np.dtype({"single": np.float32, "double": np.float64}[settings.precision])
    loose = settings.accuracy is not None and settings.accuracy >= SINGLE_ACCURACY
    return np.dtype(np.float32 if loose else np.float64)


class Sweep:
    """Solves loads on one surface in the order given.

    make_surface(dtype) -> surface.Surface; settings: scene.Solver. Raises SceneError for what cannot be asked.
    """

    def __init__(self, make_surface, settings, E_star=1.0, lam_s=None):
        self.make_surface, self.settings = make_surface, settings
        self.E_star, self.lam_s = float(E_star), lam_s
        self.solver_class = solver_class(settings.name)
        self.target = Target(settings.accuracy, settings.residual, settings.max_iterations)
        self.surface = make_surface(first_precision(settings))
        self.solver = None
        self.before = None

    def pressures(self, load):
        """The absolute mean pressures of scene.Load on this surface. Raises SceneError for p_star on a flat surface."""
        if load.p_star and self.surface.g_rms == 0:
            raise SceneError("load.p_star: found a flat surface (g_rms = 0), allowed: load.pressure")
        return load.p0(self.E_star, self.surface.g_rms)

    def solve(self, p, watch=None):
        """The contact at mean pressure p (unit of E_star)."""
        if self.surface.g_rms == 0:
            return self._flat(p)
        step = self._solve(p, watch)
        promote = self.settings.precision == "auto" and self.surface.h.dtype == np.float32
        if promote and step.contact.outcome.status in ("stagnated", "nonfinite"):
            spent = step.fft_pairs
            self._to_double()
            step = self._solve(p, watch)
            step = replace(step, fft_pairs=step.fft_pairs + spent)
        self.before = (p, step.contact.gap_mean)
        return step

    def _solve(self, p, watch):
        p_star = p / (self.E_star * self.surface.g_rms)
        problem = Problem(self.surface.grid, self.surface.h, p_star)
        full, pairs = self._full_contact(problem)
        if full is not None:
            return self._step(p, *full, iterations=0, pairs=pairs)
        pairs += self._start(problem)
        solver = self.solver
        begun, first = solver.iterations, solver.pairs - self._start_pairs
        outcome = drive(solver, self.target, watch)
        pairs += solver.pairs - first + outcome.check_pairs
        return self._step(p, solver.g, solver.p, outcome, solver.iterations - begun, pairs)

    def _step(self, p, g, q, outcome, iterations, pairs):
        contact = Contact(self.surface, self.E_star, p, g, q, outcome, self.before, self.lam_s)
        return Step(contact, iterations, float(pairs))

    def _start(self, problem):
        """Make or reuse the solver and give it a start; returns the pairs that other grids took."""
        warm = self.solver is not None and self.solver.problem.h is problem.h and self._near(problem.p0)
        if warm:
            self._start_pairs = 0.0
            self.solver.continue_at(problem.p0)
            return 0.0
        nested = self.settings.nested
        if nested is True or nested == "auto":
            g, pairs = nested_gap(problem, self._make)
        else:
            g, pairs = cold_gap(problem), 0.0
        if self.solver is None or self.solver.problem.h is not problem.h:
            self.solver = self._make(problem)
        self.solver.p0 = problem.p0
        before = self.solver.pairs
        self.solver.start(g)
        self._start_pairs = self.solver.pairs - before
        return pairs

    def _make(self, problem):
        return self.solver_class(problem, self.settings.options)

    def _near(self, p_star):
        ratio = p_star / self.solver.p0
        return 1 / WARM_RATIO < ratio < WARM_RATIO

    def _full_contact(self, problem):
        """Whether u = -h is the solution, which needs no iteration; (g, p, outcome) or None, and the pairs spent on finding out."""
        if problem.p0 < FULL_P_STAR:
            return None, 0.0
        g, q = np.zeros_like(problem.h), np.empty_like(problem.h)
        certificate = certify(problem, g, q, dual=False)
        if certificate.contact < problem.grid.N:
            return None, certificate.pairs
        return (g, q, Outcome("converged", (0.0, 0.0, 0.0), certificate, 0.0)), certificate.pairs

    def _to_double(self):
        self.solver = None
        self.surface = self.make_surface(np.dtype(np.float64))

    def _flat(self, p):
        """A flat wall: full contact at any load, nothing to compute."""
        g = np.zeros_like(self.surface.h)
        certificate = Certificate(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, self.surface.grid.N, 0.0, 0.0)
        step = self._step(p, g, np.ones_like(g), Outcome("converged", (0.0, 0.0, 0.0), certificate, 0.0), 0, 0.0)
        self.before = (p, 0.0)
        return step

