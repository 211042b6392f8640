"""The contacts that are measured: self-affine surfaces of the paper's kind, one seed each."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..parallel.comm import SerialComm
from ..scene import Scene
from ..surface import build_surface

L_OVER_LAM_L, LAM_S_OVER_A = 2, 2
DTYPES = {"single": np.float32, "double": np.float64}


@dataclass(frozen=True)
class Case:
    """n x n points, Hurst exponent, p* = p0/(E* g_rms). E* = 1, g_rms = 1, a cell of size 1 x 1."""

    n: int
    hurst: float
    p_star: float
    seed: int = 1

    @cached_property
    def spec(self):
        """scene.surface of this case."""
        surface = {"kind": "self-affine", "hurst": self.hurst, "L_over_lam_l": L_OVER_LAM_L, "lam_s_over_a": LAM_S_OVER_A,
                   "lam_l_over_lam_s": self.n / (L_OVER_LAM_L * LAM_S_OVER_A), "seed": self.seed, "g_rms": 1.0}
        return Scene.from_dict({"surface": surface, "load": {"p_star": self.p_star}}).surface

    def surface(self, dtype, comm=None, threads=1):
        """surface.Surface in one precision."""
        return build_surface(self.spec, comm or SerialComm(), dtype, threads)

    def gap(self):
        """The gap under zero load, (n, n) float64, in units of the cell's size; peaks touch at 0."""
        surface = self.surface(np.float64)
        return surface.h * surface.height_unit

    @property
    def label(self):
        """What tells it from others, as part of a row."""
        return {"n": self.n, "hurst": self.hurst, "p_star": self.p_star, "seed": self.seed}
