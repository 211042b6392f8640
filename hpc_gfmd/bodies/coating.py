"""An elastic coating that is bonded to an elastic half-space."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..scene import Material
from .base import Body


@dataclass(frozen=True)
class Coating(Body):
    """thickness: in the unit of the surface's lengths; nu, base_nu: Poisson's ratios of the coating
    and of what it lies on; ratio: shear modulus of the coating over that of the base.

    With x = |q| t, e = exp(-2x), b = 3 - 4 nu,

        K = |q|/2 [1 - (l + k + 4 k x^2) e + l k e^2]/[1 + 4 k x e - l k e^2],
        k = (ratio - 1)/(ratio + b),    l = (ratio b_base - b)/(1 + ratio b_base)

    (Chen 1971; O'Sullivan and King 1988). Long waves see the half-space alone: K -> |q|/2 times its
    modulus over that of the coating.
    """

    thickness: float
    nu: float
    ratio: float
    base_nu: float

    name = "coating"
    sources = (*Body.sources, "O'Sullivan, King, J. Tribol. 110 (1988) 235, doi:10.1115/1.3261591")

    @classmethod
    def of(cls, material: Material, free: Sequence[bool]) -> Body | None:
        t, nu, base_E, base_nu = (
            getattr(material, name) for name in ("thickness", "nu1", "base_E", "base_nu")
        )
        if t is None or base_E is None or any(free):
            return None
        return cls(t, nu, material.E_star * (1 - nu) * (1 + base_nu) / base_E, base_nu)

    @classmethod
    def examples(cls) -> list[Body]:
        return [cls(0.1, 0.3, 0.05, 0.2), cls(0.03, 0.0, 2.0, 0.5), cls(0.02, 0.5, 20.0, 0.3)]

    def stiffness(self, q: np.ndarray, a: float) -> np.ndarray:
        x = np.asarray(q, np.float64) * (self.thickness / a)
        b, base = 3 - 4 * self.nu, self.ratio * (3 - 4 * self.base_nu)
        k, s, e = (self.ratio - 1) / (self.ratio + b), (base - b) / (1 + base), np.exp(-2 * x)
        upper = 1 - (s + k + 4 * k * x * x) * e + s * k * e * e
        return q / 2 * upper / (1 + 4 * k * x * e - s * k * e * e)
