"""Exact elastic contacts to compare with: Hertz, Westergaard, Johnson-Greenwood-Higginson, full contact.

Also the constants of the theories of the contact area at low load. Heights z are peaks up; E_star in the unit
of pressure. Scalars or arrays; numbers out of range raise SceneError. Sources: Johnson, Contact Mechanics
(1985); Johnson, Greenwood, Higginson, Int. J. Mech. Sci. 27 (1985); Yastrebov, Anciaux, Molinari,
arXiv:1701.02727 (2017).
"""

import numpy as np

from hpc_gfmd.errors import SceneError
from hpc_gfmd.theory.checks import within

KAPPA_BGT = np.sqrt(2 * np.pi)  # Bush, Gibson, Thomas 1975: a_r = kappa p_star for p_star -> 0
KAPPA_PERSSON = np.sqrt(8 / np.pi)
EDGE_CORRECTION = (
    np.pi - 1 + np.log(2)
) / 24  # Yastrebov et al.: excess area per boundary segment, in grid cells


def edge_corrected_area(a_r, boundary_segments, points):
    """a_r less the mean excess of counting grid points: boundary_segments is the number of nearest-neighbour
    pairs of one point in and one out of contact (periodic), points the number of grid points."""
    return a_r - EDGE_CORRECTION * np.asarray(boundary_segments) / points


class Hertz:
    """Sphere of radius R on a half-space under the force F: radius a, peak_pressure, approach."""

    def __init__(self, R, F, E_star=1.0):
        R, F, E_star = (
            within(name, x, 0, np.inf, name != "F") for name, x in (("R", R), ("F", F), ("E_star", E_star))
        )
        self.a = np.cbrt(3 * R * F / (4 * E_star))
        self.peak_pressure = 2 * E_star * self.a / (np.pi * R)
        self.approach = self.a**2 / R

    def pressure(self, r):
        """p(r) at the distance r from the axis."""
        return self.peak_pressure * np.sqrt(np.maximum(1 - (np.asarray(r) / self.a) ** 2, 0))


class Westergaard:
    """z = A cos(2 pi x/L) under the mean pressure p0; beyond p_full = pi E* A/L contact is full and stays so.

    p_full; a_r; gap_mean (unit of A); peak_pressure; energy (elastic, per area); compliance -d(gap_mean)/dp0.
    """

    def __init__(self, p0, A=1.0, L=1.0, E_star=1.0):
        p0 = within("p0", p0, 0, np.inf)
        A, L, E_star = (
            within(name, x, 0, np.inf, True) for name, x in (("A", A), ("L", L), ("E_star", E_star))
        )
        self.L, self.p0, self.p_full = L, p0, np.pi * E_star * A / L
        x = self._ratio = np.minimum(p0 / self.p_full, 1.0)
        log = np.log(np.where(x > 0, x, 1.0))  # x ln x = 0 at x = 0
        self.a_r = 2 / np.pi * np.arcsin(np.sqrt(x))
        self.gap_mean = A * (1 - x + x * log)
        self.peak_pressure = np.where(x < 1, 2 * np.sqrt(x) * self.p_full, p0 + self.p_full)
        self.energy = A * self.p_full * x**2 * (0.25 - log / 2)
        self.compliance = np.where(x > 0, -A / self.p_full * log, np.inf) + 0.0

    def pressure(self, x):
        """p(x); the peak of the surface is at x = 0. For scalar p0."""
        phase = np.pi * np.asarray(x) / self.L
        if self._ratio >= 1:
            return self.p0 + self.p_full * np.cos(2 * phase)
        inside = np.maximum(self._ratio - np.sin(phase) ** 2, 0)
        return 2 * self.p_full * np.abs(np.cos(phase)) * np.sqrt(inside)


class JohnsonGreenwoodHigginson:
    """z = A cos(2 pi x/L) cos(2 pi y/L): the two limits that are known in closed form.

    p_full = sqrt(2) pi E* A/L; a_r_low for p0/p_full -> 0 (Hertz); a_r_high for p0/p_full -> 1.
    """

    def __init__(self, p0, A=1.0, L=1.0, E_star=1.0):
        p0 = within("p0", p0, 0, np.inf)
        A, L, E_star = (
            within(name, x, 0, np.inf, True) for name, x in (("A", A), ("L", L), ("E_star", E_star))
        )
        self.p_full = np.sqrt(2) * np.pi * E_star * A / L
        x = np.minimum(p0 / self.p_full, 1.0)
        self.a_r_low = np.pi * (3 * x / (8 * np.pi)) ** (2 / 3)
        self.a_r_high = 1 - 3 / (2 * np.pi) * (1 - x)


class FullContact:
    """The flattened surface: heights z, shape (n_x, n_y), whole period; physical sizes (L_x, L_y).

    pressure_deviation: p(r) - p0, shape of z, with standard deviation E* g_rms/2; p_full: smallest mean
    pressure with full contact; energy: elastic energy per area; g_rms: rms gradient. Wave vectors of the
    minimal image.
    """

    def __init__(self, z, physical_sizes=(1.0, 1.0), E_star=1.0):
        z = np.asarray(z, dtype=float)
        if z.ndim != 2 or z.size == 0:
            raise SceneError(f"heights: found shape {z.shape}, allowed: two dimensions, none of them empty")
        q_x, q_y = (
            2 * np.pi * np.fft.fftfreq(n, L / n) for n, L in zip(z.shape, physical_sizes, strict=True)
        )
        q = np.hypot(q_x[:, None], q_y)
        z_q = np.fft.fft2(z) / z.size
        self.g_rms = np.sqrt(np.sum(np.abs(q * z_q) ** 2))
        self.energy = E_star / 4 * np.sum(q * np.abs(z_q) ** 2)
        self.pressure_deviation = np.fft.ifft2(E_star / 2 * q * z_q).real * z.size
        self.p_full = -self.pressure_deviation.min()
