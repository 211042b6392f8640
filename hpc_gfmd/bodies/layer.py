"""An elastic layer of finite thickness, bonded to a rigid base or sliding on it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..scene import Material
from .base import Body

TINY = 1e-8  # wave numbers times thickness below which a wave is as good as a uniform pressure


@dataclass(frozen=True)
class Layer(Body):
    """A layer on a rigid base: S = (2/|q|) f(|q| t). With x = |q| t

        bonded:        f = [b sinh 2x - 2x]/[b cosh 2x + 2 x^2 + 5 - 12 nu + 8 nu^2], b = 3 - 4 nu
        frictionless:  f = [cosh 2x - 1]/[sinh 2x + 2x]

    f -> 1 for short waves; for long ones K becomes the oedometric modulus (bonded) or E*
    (frictionless) over t. A uniform pressure compresses the layer as a whole: that is part of the
    approach, not of the gap.
    """

    thickness: float  # t, in the unit of the surface's lengths
    nu: float  # Poisson's ratio, below 1/2 if bonded
    base: str  # "bonded" or "frictionless"

    name = "layer"

    @classmethod
    def of(cls, material: Material, free: Sequence[bool]) -> Body | None:
        """Return the layer of a scene: a thickness on a rigid base, no free edges."""
        t = material.thickness
        nu = material.nu1
        if t is None or nu is None or not material.rigid_base or any(free):
            return None
        return cls(t, nu, material.base)

    @classmethod
    def examples(cls) -> list[Body]:
        """Return bonded and frictionless layers, for the contract tests."""
        return [
            cls(0.3, 0.3, "bonded"),
            cls(0.05, 0.0, "bonded"),
            cls(0.02, 0.45, "bonded"),
            cls(0.05, 0.5, "frictionless"),
        ]

    def stiffness(self, q: np.ndarray, a: float) -> np.ndarray:
        t = self.thickness / a
        x = np.maximum(np.asarray(q, np.float64) * t, TINY)
        # both parts of the fraction times e: nothing overflows; the upper one over x
        e = np.exp(-2 * x)
        if self.base == "bonded":
            k = 3 - 4 * self.nu
            upper = -k * np.expm1(-4 * x) / (2 * x) - 2 * e
            lower = k * (1 + e * e) / 2 + e * (2 * x * x + 5 - 12 * self.nu + 8 * self.nu**2)
        else:
            upper = np.expm1(-2 * x) ** 2 / (2 * x)
            lower = -np.expm1(-4 * x) / 2 + 2 * x * e
        return lower / (2 * t * upper)
