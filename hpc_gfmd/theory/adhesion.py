"""Adhesive contacts to compare with: a ball by Johnson, Kendall and Roberts, by Derjaguin, Muller
and Toporov, and by Maugis between them; a wave by Johnson; and when a rough wall sticks, by
Pastewka and Robbins.

Scalars or arrays; numbers out of range raise SceneError. `w` is the work of adhesion per area,
E_star in the unit of pressure, w in that times the unit of length. Forces pull where they are
negative.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from .checks import within

WIDEST = 1e4  # radius of the ring that attracts over that of the contact
SMALLEST, LARGEST = 1e-3, 1e2  # Maugis' parameter


def tabor(R: ArrayLike, w: ArrayLike, length: ArrayLike, E_star: ArrayLike = 1.0) -> np.ndarray:
    """Compute Tabor's parameter: how far a ball bulges before contact, over the range of the
    attraction.

    Above 5 the ball is one of Johnson, Kendall and Roberts, below 0.1 one of Derjaguin, Muller and
    Toporov.

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
        For numbers out of range.
    """
    names = (("R", R), ("w", w), ("length", length), ("E_star", E_star))
    R, w, length, E_star = (within(name, x, 0, np.inf, True) for name, x in names)
    return np.cbrt(R * w**2 / (E_star**2 * length**3))


class JohnsonKendallRoberts:
    """Ball on a half-space with an attraction of no range.

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
        """Compute the radius of the contact, the larger of two, under a force F; nan below
        `pull_off`."""
        F = np.asarray(F, float)
        pull = 3 * np.pi * self.w * self.R
        with np.errstate(invalid="ignore"):
            load = F + pull + np.sqrt(2 * pull * F + pull**2)
        return np.cbrt(3 * self.R / (4 * self.E_star) * load)


def dmt_pull_off(R: ArrayLike, w: ArrayLike) -> np.ndarray:
    """Compute the force at which a ball of Derjaguin, Muller and Toporov comes off.

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
        For numbers out of range.
    """
    R, w = (within(name, x, 0, np.inf, True) for name, x in (("R", R), ("w", w)))
    return -2 * np.pi * w * R


def maugis_pull_off(lam: float) -> float:
    """Compute the force at which a ball comes off that is attracted by the same traction up to a
    range (Maugis 1992).

    Parameters
    ----------
    lam : float
        Maugis' parameter, traction times (9 R/(2 pi w E*^2))^(1/3): 1.157 times Tabor's with the
        range w/traction.

    Returns
    -------
    float
        Over pi w R: from -2 (lam to 0) to -3/2 (lam to infinity).

    Raises
    ------
    SceneError
        For a lam that is not between 1e-3 and 100.
    """
    lam = float(within("lam", within("lam", lam, SMALLEST, np.inf), -np.inf, LARGEST))

    def radius(m: float) -> float:
        """Radius of the contact over (pi w R^2/K)^(1/3), m: that of the attracting ring over it."""
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
    """z = A cos(2 pi x/L) with an attraction of no range (Johnson 1995).

    Parameters
    ----------
    w, A, L, E_star : float
        Work of adhesion, amplitude, wavelength, effective modulus (> 0).

    Attributes
    ----------
    p_full : float
        Mean pressure that closes the gap without attraction, pi E* A/L.
    alpha : float
        sqrt(2 w L/(pi^2 E* A^2)).
    pull_off : float
        The least mean pressure of an equilibrium with little contact.
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
        """Mean pressure over p_full at a contact area."""
        phase = np.pi * a_r / 2
        return float(np.sin(phase) ** 2 - self.alpha * np.sqrt(np.tan(phase)))

    def a_r(self, p0: float) -> float:
        """Compute the relative contact area under a mean pressure, on the stable branch that begins
        at `pull_off`; nan where there is none."""
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
    """Compute how much a wall attracts beside its contact, over what it repels: the criterion of
    Pastewka and Robbins (2014), by which it sticks above 1.

    The attraction is w/reach in a ring around the contact, where the gap is below `reach`. Far
    below 1 adhesion can be neglected.

    Parameters
    ----------
    a_r : float or array
        Relative contact area.
    p : float or array
        Mean pressure of the contact over the nominal area, attraction not taken off, in the unit of
        w/reach.
    g_rms : float or array
        Rms slope of the wall.
    diameter : float or array
        Mean chord of the contact, pi times its area over its perimeter.
    w, reach : float or array
        Work of adhesion, and the length over which it is done: w over the largest attraction.

    Returns
    -------
    array
        a_r (w/reach)/p times pi (3 reach/(4 g_rms diameter))^(2/3).

    Raises
    ------
    SceneError
        For numbers out of range.
    """
    names = (("p", p), ("g_rms", g_rms), ("diameter", diameter), ("w", w), ("reach", reach))
    a_r = within("a_r", a_r, 0, 1)
    p, g_rms, diameter, w, reach = (within(name, x, 0, np.inf, True) for name, x in names)
    ring = np.cbrt(3 * reach / (4 * g_rms * diameter)) ** 2
    return a_r * w / reach / p * np.pi * ring
