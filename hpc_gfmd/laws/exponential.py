"""Attraction that falls exponentially with the gap."""

from typing import Any

from ..kernels.attraction import decay
from .base import Law


class Exponential(Law):
    """phi = -work exp(-g/range): the attraction is largest at g = 0, work/range."""

    name = "exponential"
    sources = ("Wang, Zhou, Müser, Lubricants 9 (2021) 17, doi:10.3390/lubricants9020017",)

    def energy(self, g: Any) -> Any:
        return -self.work * decay(g / self.range)

    def traction(self, g: Any) -> Any:
        return self.work / self.range * decay(g / self.range)

    def curvature(self, g: Any) -> Any:
        return -self.work / (self.range * self.range) * decay(g / self.range)
