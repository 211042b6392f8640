"""Attraction of finite range: the energy is a cubic of the gap."""

from typing import Any

import numpy as np

from .base import Law


class Cubic(Law):
    """phi = -work (1 - g/range)^3 for g < range, 0 beyond; at g = 0 it attracts by 3 work/range."""

    name = "cubic"

    def energy(self, g: Any) -> Any:
        left = np.maximum(1 - g / self.range, 0)
        return -self.work * left * left * left

    def traction(self, g: Any) -> Any:
        left = np.maximum(1 - g / self.range, 0)
        return 3 * self.work / self.range * left * left

    def curvature(self, g: Any) -> Any:
        left = np.maximum(1 - g / self.range, 0)
        return -6 * self.work / (self.range * self.range) * left
