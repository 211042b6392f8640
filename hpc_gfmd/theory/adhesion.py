"""Adhesive contacts to compare with: a ball by Johnson, Kendall and Roberts, by Derjaguin, Muller
and Toporov, and by Maugis between them; a wave by Johnson; and when a rough wall sticks, by
Pastewka and Robbins.

Arguments are numbers or arrays, but numbers alone where the signature says float; those out of
range raise SceneError. `w` is the work of adhesion per area, E_star in the unit of pressure, w in
that times the unit of length. Forces pull where they are negative.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from .checks import within

WIDEST = 1e4  # radius of the ring that attracts over that of the contact
SMALLEST, LARGEST = 1e-3, 1e2  # Maugis' parameter


def tabor(R: ArrayLike, w: ArrayLike, length: ArrayLike, E_star: ArrayLike = 1.0) -> np.ndarray:
    """Compute Tabor's parameter of a ball: its elastic bulge over the range of the attraction.

    Above 5 the theory of Johnson, Kendall and Roberts applies, below 0.1 that of Derjaguin, Muller
    and Toporov.

    Parameters
    ----------
    R, w, length, E_star : float or array
        Radius, work of adhesion, range of the attraction, effective modulus (> 0).

    Returns
    -------
    array
        (R w^2/(E*^2 length^3))^(1/3).

    Raises
    ------
    SceneError
        If a number is out of range.
    """
    names = (("R", R), ("w", w), ("length", length), ("E_star", E_star))
    R, w, length, E_star = (within(name, x, 0, np.inf, True) for name, x in names)
    return np.cbrt(R * w**2 / (E_star**2 * length**3))


class JohnsonKendallRoberts:
    """An adhesive ball on a half-space, the attraction having no range.

    Raises SceneError if a number is out of range.

    Parameters
    ----------
    R, w, E_star : float or array
        Radius, work of adhesion, effective modulus (> 0).

    Attributes
    ----------
    pull_off : float or array
        Force at which the ball comes off, -3/2 pi w R.
    """

    def __init__(self, R: ArrayLike, w: ArrayLike, E_star: ArrayLike = 1.0):
        names = (("R", R), ("w", w), ("E_star", E_star))
        self.R, self.w, self.E_star = (within(name, x, 0, np.inf, True) for name, x in names)
        self.pull_off = -1.5 * np.pi * self.w * self.R

    def radius(self, F: ArrayLike) -> np.ndarray:
        """Compute the contact radius of stable equilibrium under the force F; nan if F < pull_off.

        F may be any number or array; below 0 it pulls. Of the two equilibria between `pull_off` and
        0 it is the one with the larger radius.
        """
        F = np.asarray(F, float)
        pull = 3 * np.pi * self.w * self.R
        with np.errstate(invalid="ignore"):
            load = F + pull + np.sqrt(2 * pull * F + pull**2)
        return np.cbrt(3 * self.R / (4 * self.E_star) * load)


def dmt_pull_off(R: ArrayLike, w: ArrayLike) -> np.ndarray:
    """Compute the pull-off force of a ball by the theory of Derjaguin, Muller and Toporov.

    Parameters
    ----------
    R, w : float or array
        Radius and work of adhesion (> 0).

    Returns
    -------
    array
        -2 pi w R.

    Raises
    ------
    SceneError
        If a number is out of range.
    """
    R, w = (within(name, x, 0, np.inf, True) for name, x in (("R", R), ("w", w)))
    return -2 * np.pi * w * R


def maugis_pull_off(lam: float) -> float:
    """Compute the pull-off force of a ball under a traction that is constant up to a range.

    This is the theory of Maugis (1992), between those of Derjaguin, Muller and Toporov and of
    Johnson, Kendall and Roberts.

    Parameters
    ----------
    lam : float
        Maugis' parameter, traction times (9 R/(2 pi w E*^2))^(1/3): 1.157 times Tabor's with the
        range w/traction.

    Returns
    -------
    float
        Force divided by pi w R, negative: -2 for lam -> 0, -3/2 for lam -> infinity.

    Raises
    ------
    SceneError
        If lam is not between 1e-3 and 100.
    """
    lam = float(within("lam", within("lam", lam, SMALLEST, np.inf), -np.inf, LARGEST))

    def radius(m: float) -> float:
        """Return the contact radius over (pi w R^2/K)^(1/3), with K = 4 E*/3.

        m: outer radius of the attracting ring over that of the contact.
        """
        root, angle = np.sqrt(m * m - 1), np.arccos(1 / m)
        square = lam / 2 * (root + (m * m - 2) * angle)
        linear = 4 * lam * lam / 3 * (root * angle - m + 1)
        return (-linear + np.sqrt(linear * linear + 4 * square)) / (2 * square)

    def force(log: float) -> float:
        m = 1 + np.exp(log)
        root, angle, a = np.sqrt(m * m - 1), np.arccos(1 / m), radius(m)
        return a**3 - lam * a * a * (root + m * m * angle)

    logs = np.linspace(np.log(1e-6), np.log(WIDEST), 400)
    lowest = int(np.argmin([force(log) for log in logs]))
    near = logs[max(lowest - 1, 0)], logs[min(lowest + 1, len(logs) - 1)]
    return float(minimize_scalar(force, bounds=near, method="bounded").fun)


class AdhesiveWave:
    """A wave z = A cos(2 pi x/L) on a half-space, the attraction having no range (Johnson 1995).

    Raises SceneError if a number is out of range.

    Parameters
    ----------
    w, A, L, E_star : float
        Work of adhesion, amplitude, wavelength, effective modulus (> 0).

    Attributes
    ----------
    p_full : float
        Mean pressure that closes the gap without attraction, pi E* A/L.
    alpha : float
        Strength of the adhesion, sqrt(2 w L/(pi^2 E* A^2)).
    pull_off : float
        The least mean pressure at which an equilibrium with a_r < 1/2 exists, negative.
    """

    def __init__(self, w: float, A: float = 1.0, L: float = 1.0, E_star: float = 1.0):
        names = (("w", w), ("A", A), ("L", L), ("E_star", E_star))
        w, A, L, E_star = (float(within(name, x, 0, np.inf, True)) for name, x in names)
        self.p_full = np.pi * E_star * A / L
        self.alpha = float(np.sqrt(2 * w * L / (np.pi**2 * E_star * A**2)))
        at = minimize_scalar(self._pressure, bounds=(1e-9, 0.5), method="bounded").x
        self._at_pull_off = float(at)
        self.pull_off = self._pressure(at) * self.p_full

    def _pressure(self, a_r: float) -> float:
        """Return the mean pressure, in units of p_full, at the relative contact area a_r."""
        phase = np.pi * a_r / 2
        return float(np.sin(phase) ** 2 - self.alpha * np.sqrt(np.tan(phase)))

    def a_r(self, p0: float) -> float:
        """Compute the relative contact area under the mean pressure p0 on the stable branch.

        p0 is in the unit of E_star, negative if it pulls.
        The branch begins at `pull_off` and ends at the pressure at which the contact jumps to full
        contact; nan below and above.
        """
        areas = np.linspace(self._at_pull_off, 1 - 1e-9, 2001)
        pressures = np.array([self._pressure(x) for x in areas]) - p0 / self.p_full
        if pressures[0] > 0 or pressures.max() < 0:
            return float("nan")
        k = int(np.argmax(pressures >= 0))
        if k == 0:
            return float(areas[0])
        return float(brentq(lambda x: self._pressure(x) - p0 / self.p_full, areas[k - 1], areas[k]))


def stickiness(
    a_r: ArrayLike,
    p: ArrayLike,
    g_rms: ArrayLike,
    diameter: ArrayLike,
    w: ArrayLike,
    reach: ArrayLike,
) -> np.ndarray:
    """Compute the attraction around a rough contact over its repulsion; above 1 the wall sticks.

    This is the criterion of Pastewka and Robbins (2014). The attraction is w/reach in the ring
    around the contact where the gap is below `reach`. Adhesion is negligible if the result is far
    below 1.

    Parameters
    ----------
    a_r : float or array
        Relative contact area.
    p : float or array
        Mean repulsive pressure over the nominal area (the attraction is not subtracted), in the
        unit of w/reach.
    g_rms : float or array
        Rms slope of the wall.
    diameter : float or array
        Mean chord of the contact, pi times its area over its perimeter.
    w, reach : float or array
        Work of adhesion, and the range of the attraction: w over the largest attraction.

    Returns
    -------
    array
        a_r (w/reach)/p times pi (3 reach/(4 g_rms diameter))^(2/3).

    Raises
    ------
    SceneError
        If a number is out of range.
    """
    names = (("p", p), ("g_rms", g_rms), ("diameter", diameter), ("w", w), ("reach", reach))
    a_r = within("a_r", a_r, 0, 1)
    p, g_rms, diameter, w, reach = (within(name, x, 0, np.inf, True) for name, x in names)
    ring = np.cbrt(3 * reach / (4 * g_rms * diameter)) ** 2
    return a_r * w / reach / p * np.pi * ring
