"""Exact elastic contacts to compare with: Hertz and Westergaard; the constant of Bush, Gibson and
Thomas' theory.

Heights z are peaks up; E_star in the unit of pressure. Scalars or arrays; numbers out of range
raise SceneError. Source: Johnson, Contact Mechanics (1985).
"""

import numpy as np
from numpy.typing import ArrayLike

from .checks import within

KAPPA_BGT = np.sqrt(2 * np.pi)  # Bush, Gibson, Thomas 1975: a_r = kappa p_star for p_star -> 0


class Hertz:
    """A sphere on a half-space without adhesion. Raises SceneError if a number is out of range.

    Parameters
    ----------
    R, F, E_star : float or array
        Radius (> 0), force (>= 0), effective modulus (> 0).

    Attributes
    ----------
    a, peak_pressure, approach : float or array
        Radius of the contact, largest pressure, approach of distant points.
    """

    def __init__(self, R: ArrayLike, F: ArrayLike, E_star: ArrayLike = 1.0):
        R, F, E_star = (
            within(name, x, 0, np.inf, name != "F")
            for name, x in (("R", R), ("F", F), ("E_star", E_star))
        )
        self.a = np.cbrt(3 * R * F / (4 * E_star))
        self.peak_pressure = 2 * E_star * self.a / (np.pi * R)
        self.approach = self.a**2 / R

    def pressure(self, r: ArrayLike) -> np.ndarray:
        """Compute the pressure at the distance r from the axis; nan at r = 0 without force."""
        return self.peak_pressure * np.sqrt(np.maximum(1 - (np.asarray(r) / self.a) ** 2, 0))


class HertzLine:
    """A cylinder on a half-space without adhesion: the contact is a strip.

    Raises SceneError if a number is out of range.

    Parameters
    ----------
    R : float or array
        Radius (> 0).
    F : float or array
        Force per length of the cylinder (>= 0).
    E_star : float or array
        Effective modulus (> 0).

    Attributes
    ----------
    a : float or array
        Half width of the contact, sqrt(4 F R/(pi E*)).
    peak_pressure : float or array
        Largest pressure, 2 F/(pi a).
    """

    def __init__(self, R: ArrayLike, F: ArrayLike, E_star: ArrayLike = 1.0):
        radius = within("R", R, 0, np.inf, open_low=True)
        force = within("F", F, 0, np.inf)
        modulus = within("E_star", E_star, 0, np.inf, open_low=True)
        self.a = np.sqrt(4 * force * radius / (np.pi * modulus))
        self.peak_pressure = modulus * self.a / (2 * radius)

    def pressure(self, x: ArrayLike) -> np.ndarray:
        """Compute the pressure at the distance x from the middle; nan at x = 0 without force."""
        return self.peak_pressure * np.sqrt(np.maximum(1 - (np.asarray(x) / self.a) ** 2, 0))


class Westergaard:
    """A wave z = A cos(2 pi x/L) pressed against a half-space: Westergaard's solution.

    Contact is full from the mean pressure p_full = pi E* A/L on. Raises SceneError if a number is
    out of range.

    Parameters
    ----------
    p0 : float or array
        Mean pressure, >= 0.
    A : float or array
        Amplitude of the wave, half of its height from valley to peak.
    L : float or array
        Wavelength.
    E_star : float or array
        Effective modulus, in the unit of p0.

    Attributes
    ----------
    p_full : float or array
        Smallest mean pressure of full contact.
    a_r, gap_mean, peak_pressure : float or array
        Relative contact area, mean gap (unit of A), largest pressure.
    energy, compliance : float or array
        Elastic energy per area, and -d(gap_mean)/dp0, which is inf at p0 = 0 and 0 in full contact.
    """

    def __init__(
        self, p0: ArrayLike, A: ArrayLike = 1.0, L: ArrayLike = 1.0, E_star: ArrayLike = 1.0
    ):
        p0 = within("p0", p0, 0, np.inf)
        A, L, E_star = (
            within(name, x, 0, np.inf, True) for name, x in (("A", A), ("L", L), ("E_star", E_star))
        )
        self.L = L
        self.p0 = p0
        self.p_full = np.pi * E_star * A / L
        x = self._ratio = np.minimum(p0 / self.p_full, 1.0)
        log = np.log(np.where(x > 0, x, 1.0))  # x ln x = 0 at x = 0
        self.a_r = 2 / np.pi * np.arcsin(np.sqrt(x))
        self.gap_mean = A * (1 - x + x * log)
        self.peak_pressure = np.where(x < 1, 2 * np.sqrt(x) * self.p_full, p0 + self.p_full)
        self.energy = A * self.p_full * x**2 * (0.25 - log / 2)
        self.compliance = np.where(x > 0, -A / self.p_full * log, np.inf) + 0.0

    def pressure(self, x: ArrayLike) -> np.ndarray:
        """Compute the pressure at x (crest at 0), of a wave made with numbers, not arrays."""
        phase = np.pi * np.asarray(x) / self.L
        if self._ratio >= 1:
            return self.p0 + self.p_full * np.cos(2 * phase)
        inside = np.maximum(self._ratio - np.sin(phase) ** 2, 0)
        return 2 * self.p_full * np.abs(np.cos(phase)) * np.sqrt(inside)
