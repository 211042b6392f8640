"""The indicator s of the nominal area on the levels of a grid, and sums with it.

s is 1 on the surface and 0 in the padding beyond free edges: a product of two functions of one
coordinate. The error of a mean gap (certificate/error_estimates.py) needs its norm on all levels.
"""

from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..parallel.coarsening import Level, restrict_axis


class NominalArea:
    """Norm and sums of s. `s`: its factors (s_x, s_y) on each level; `weights`: softness N/N_l."""

    def __init__(self, grid: Any, levels: Sequence[Level], softness: Iterable[float]):
        self.weights = [
            softness_l * grid.cell_points / (level.n[0] * level.n[1])
            for softness_l, level in zip(softness, levels)
        ]
        self.s = [[(np.arange(n) < m).astype(float) for n, m in zip(grid.n, grid.nominal)]]
        for level in levels[1:]:
            self.s.append([restrict_axis(s, n) for s, n in zip(self.s[-1], level.n)])

    @cached_property
    def norm(self) -> float:
        """Sum over the coarse levels of softness <s, s> N/N_l."""
        return float(
            sum(
                weight * np.dot(x, x) * np.dot(y, y)
                for weight, (x, y) in zip(self.weights[1:], self.s[1:])
            )
        )
