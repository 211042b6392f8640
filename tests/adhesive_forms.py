"""Closed forms of adhesive contacts: a ball by Johnson, Kendall and Roberts, by Derjaguin, Muller
and Toporov, and by Maugis between them; a wave by Johnson. Forces pull where they are negative.
"""

import numpy as np
from scipy.optimize import brentq, minimize_scalar

WIDEST = 1e4  # radius of the ring that attracts over that of the contact


class JohnsonKendallRoberts:
    """An adhesive ball on a half-space, the attraction having no range; arrays are allowed."""

    def __init__(self, R, w, E_star=1.0):
        self.R = R
        self.w = w
        self.E_star = E_star
        self.pull_off = -1.5 * np.pi * self.w * self.R

    def radius(self, F):
        """Return the contact radius of stable equilibrium under the force F; nan below pull_off."""
        F = np.asarray(F, float)
        pull = 3 * np.pi * self.w * self.R
        with np.errstate(invalid="ignore"):
            load = F + pull + np.sqrt(2 * pull * F + pull**2)
        return np.cbrt(3 * self.R / (4 * self.E_star) * load)


def maugis_pull_off(lam):
    """Return the pull-off force of a ball over pi w R; the traction is constant up to a range.

    By Maugis (1992); lam is his parameter, traction times (9 R/(2 pi w E*^2))^(1/3), from 1e-3 to
    100, 1.157 times Tabor's with the range w/traction.
    """

    def radius(m):
        """Return the contact radius over (pi w R^2/K)^(1/3), with K = 4 E*/3.

        m: outer radius of the attracting ring over that of the contact.
        """
        root, angle = np.sqrt(m * m - 1), np.arccos(1 / m)
        square = lam / 2 * (root + (m * m - 2) * angle)
        linear = 4 * lam * lam / 3 * (root * angle - m + 1)
        return (-linear + np.sqrt(linear * linear + 4 * square)) / (2 * square)

    def force(log):
        m = 1 + np.exp(log)
        root, angle, a = np.sqrt(m * m - 1), np.arccos(1 / m), radius(m)
        return a**3 - lam * a * a * (root + m * m * angle)

    logs = np.linspace(np.log(1e-6), np.log(WIDEST), 400)
    lowest = int(np.argmin([force(log) for log in logs]))
    near = logs[max(lowest - 1, 0)], logs[min(lowest + 1, len(logs) - 1)]
    return float(minimize_scalar(force, bounds=near, method="bounded").fun)


class AdhesiveWave:
    """A wave z = A cos(2 pi x/L) on a half-space, the attraction having no range (Johnson 1995).

    p_full closes the gap without attraction, alpha is the strength of the adhesion, and pull_off
    the least mean pressure at which an equilibrium with a_r < 1/2 exists.
    """

    def __init__(self, w, A=1.0, L=1.0, E_star=1.0):
        self.p_full = np.pi * E_star * A / L
        self.alpha = float(np.sqrt(2 * w * L / (np.pi**2 * E_star * A**2)))
        at = minimize_scalar(self._pressure, bounds=(1e-9, 0.5), method="bounded").x
        self._at_pull_off = float(at)
        self.pull_off = self._pressure(at) * self.p_full

    def _pressure(self, a_r):
        """Return the mean pressure, in units of p_full, at the relative contact area a_r."""
        phase = np.pi * a_r / 2
        return float(np.sin(phase) ** 2 - self.alpha * np.sqrt(np.tan(phase)))

    def a_r(self, p0):
        """Return the relative contact area under the mean pressure p0 on the stable branch.

        nan below `pull_off`, and where the contact has jumped to full contact.
        """
        areas = np.linspace(self._at_pull_off, 1 - 1e-9, 2001)
        pressures = np.array([self._pressure(x) for x in areas]) - p0 / self.p_full
        if pressures[0] > 0 or pressures.max() < 0:
            return float("nan")
        k = int(np.argmax(pressures >= 0))
        if k == 0:
            return float(areas[0])
        return float(brentq(lambda x: self._pressure(x) - p0 / self.p_full, areas[k - 1], areas[k]))
