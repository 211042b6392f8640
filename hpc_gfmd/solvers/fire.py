"""GFMD with the fast inertial relaxation engine, FIRE (Bitzek et al., Phys. Rev. Lett. 97, 170201,
2006), at its standard parameters.

No damping force; instead the velocity v is turned towards the force F = -p (0 in contact),

    v <- (1 - alpha) v + alpha F |v|/|F|,    v <- v + F dt,    g <- max(g + v dt, 0),

and while the power F.v is positive the time step grows and alpha shrinks; when it is not, the
solids are stopped and the time step is halved. In terms of d = v dt this is again d <- b d - a p,
so time steps are those of `gfmd`, one FFT pair each.
"""

import numpy as np

from ..operators.problem import Problem
from .gfmd import Gfmd

DT_MAX = 0.7  # default largest time step, relative to the stability limit 2/sqrt(lambda)
DT_START = 0.1  # first time step, relative to the largest
N_MIN, GROW, SHRINK, ALPHA, ALPHA_SHRINK = 5, 1.1, 0.5, 0.1, 0.99


class Fire(Gfmd):
    """options: dt, the largest time step relative to the stability limit, 0.01 to 1 (default 0.7).
    Raises SceneError for others."""

    name = "fire"
    sources = (
        "Bitzek et al., Phys. Rev. Lett. 97 (2006) 170201, doi:10.1103/PhysRevLett.97.170201",
    )
    scalar_names = (*Gfmd.scalar_names, "dt", "dt_last", "alpha", "downhill")
    allowed = {"dt": (0.01, 1.0)}

    def __init__(self, problem: Problem, options: dict[str, float] | None = None):
        super().__init__(problem, options)
        self.dt_max = self.options.get("dt", DT_MAX) * 2 / np.sqrt(self.stiffest)

    def _begin(self) -> None:
        self.dt = self.dt_last = DT_START * self.dt_max
        self.alpha, self.downhill = ALPHA, 0

    def _coefficients(self) -> tuple[float, float]:
        mix, keep = 0.0, 0.0
        if self.pd < 0 < self.rr:
            mix = self.alpha * np.sqrt(self.dd / self.rr) / self.dt_last
            keep = (1 - self.alpha) / self.dt_last
            self.downhill += 1
            if self.downhill > N_MIN:
                self.dt = min(self.dt * GROW, self.dt_max)
                self.alpha *= ALPHA_SHRINK
        else:
            if self.dd > 0:
                self.dt *= SHRINK
            self.alpha, self.downhill = ALPHA, 0
        self.dt_last = self.dt
        return self.dt * (mix + self.dt), self.dt * keep
