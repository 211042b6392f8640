"""What is asked at one load, in the program's own units.

Units: in-plane length a = sqrt(a_x a_y), height g_rms a, pressure E* g_rms. Everything is then of order one whatever the scene's
units, and p0 is p*:

    K = |q|/2,    p = p0 + K u,    u >= -h,    g = u + h >= 0,    p >= 0,    p g = 0.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Problem:
    """h: local slab of the initial gap, >= 0 with minimum 0, in the working precision; p0: mean pressure."""

    grid: object
    h: np.ndarray
    p0: float

    @property
    def dtype(self):
        """The working precision."""
        return self.h.dtype
