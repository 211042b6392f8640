"""Attraction that is the same up to its range, as in the model of Dugdale and Maugis."""

from typing import Any

import numpy as np

from .base import Law

WIDTH = 0.1  # of the range: half of the ramp over which the attraction ends


class Dugdale(Law):
    """An attraction of work/range up to a gap of 0.9 ranges, which falls linearly to 0 at 1.1."""

    name = "dugdale"
    sources = (
        "Maugis, J. Colloid Interface Sci. 150 (1992) 243, doi:10.1016/0021-9797(92)90285-T",
    )

    def energy(self, g: Any) -> Any:
        x = g / self.range
        ramp = np.minimum(np.maximum((1 + WIDTH - x) / (2 * WIDTH), 0), 1)
        return -self.work * (np.maximum(1 - WIDTH - x, 0) + WIDTH * ramp * ramp)

    def traction(self, g: Any) -> Any:
        x = g / self.range
        return self.work / self.range * np.minimum(np.maximum((1 + WIDTH - x) / (2 * WIDTH), 0), 1)

    def curvature(self, g: Any) -> Any:
        x = g / self.range
        on_ramp = np.abs(x - 1) < WIDTH
        return -self.work / (2 * WIDTH * self.range * self.range) * on_ramp
