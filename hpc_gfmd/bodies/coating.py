"""An elastic coating that is bonded to an elastic half-space."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..scene import Material
from .base import Body


@dataclass(frozen=True)
class Coating(Body):
    """A coating on a half-space (Chen 1971; O'Sullivan and King 1988).

    With x = |q| t, e = exp(-2x), b = 3 - 4 nu,

        K = |q|/2 [1 - (l + k + 4 k x^2) e + l k e^2]/[1 + 4 k x e - l k e^2],
        k = (ratio - 1)/(ratio + b),    l = (ratio b_base - b)/(1 + ratio b_base)

    Long waves are resisted by the half-space alone: K -> |q|/2 times its modulus over that of the
    coating.
    """

    thickness: float  # t, in the unit of the surface's lengths
    nu: float  # Poisson's ratio of the coating
    ratio: float  # shear modulus of the coating over that of the base
    base_nu: float  # Poisson's ratio of the base

    name = "coating"
    sources = (*Body.sources, "O'Sullivan, King, J. Tribol. 110 (1988) 235, doi:10.1115/1.3261591")

    @classmethod
    def of(cls, material: Material, free: Sequence[bool]) -> Body | None:
        """Return the coating of a scene: a thickness on a base with a modulus, no free edges."""
        t = material.thickness
        nu = material.nu1
        base_E = material.base_E
        base_nu = material.base_nu
        if t is None or nu is None or base_E is None or base_nu is None or any(free):
            return None
        ratio = material.E_star * (1 - nu) * (1 + base_nu) / base_E
        return cls(t, nu, ratio, base_nu)

    @classmethod
    def examples(cls) -> list[Body]:
        """Return a soft, a stiff and a very stiff coating, for the contract tests."""
        return [cls(0.1, 0.3, 0.05, 0.2), cls(0.03, 0.0, 2.0, 0.5), cls(0.02, 0.5, 20.0, 0.3)]

    def stiffness(self, q: np.ndarray, a: float) -> np.ndarray:
        x = np.asarray(q, np.float64) * (self.thickness / a)
        e = np.exp(-2 * x)
        b = 3 - 4 * self.nu
        ratio_b_base = self.ratio * (3 - 4 * self.base_nu)
        k = (self.ratio - 1) / (self.ratio + b)
        s = (ratio_b_base - b) / (1 + ratio_b_base)  # l above
        upper = 1 - (s + k + 4 * k * x * x) * e + s * k * e * e
        return q / 2 * upper / (1 + 4 * k * x * e - s * k * e * e)
