"""Persson's theory of elastic - perfectly plastic contact (Persson 2001).

With growing resolution the distribution of pressures diffuses between two absorbing ends: 0, where
the gap opens, and the hardness H, where a point yields. The variance is that of full contact, (E*
g_rms/2)^2; the solution is a sum over the images of p0 in both ends. Pressures are in one arbitrary
unit; numbers out of range raise SceneError.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erfc

from ..util.errors import SceneError
from .checks import within

FAR = 6.5  # standard deviations beyond which an image has no weight in double precision


def pressure_distribution(
    p: ArrayLike, p0: float, hardness: float, g_rms: float = 1.0, E_star: float = 1.0
) -> np.ndarray:
    """Compute the probability density of the pressure in elastic contact, 0 < p < hardness.

    Parameters
    ----------
    p : float or array
        Local pressures.
    p0, hardness : float
        Mean pressure and largest pressure, 0 <= p0 < hardness.
    g_rms, E_star : float
        Rms gradient and effective modulus, > 0.

    Returns
    -------
    float or array
        Density per unit of pressure, in the shape of p; 0 outside of 0 < p < hardness. Its integral
        is the area in elastic contact, a_r - a_plastic of `areas`.
    """
    p = np.asarray(p, dtype=float)
    width, images = _images(p0, hardness, g_rms, E_star)
    x = p[..., None] / width
    shifts = 2 * images * hardness / width
    density = np.exp(-((x - p0 / width - shifts) ** 2) / 2)
    density -= np.exp(-((x + p0 / width - shifts) ** 2) / 2)
    inside = (p > 0) & (p < hardness)
    return np.where(inside, density.sum(axis=-1) / (np.sqrt(2 * np.pi) * width), 0.0)[()]


def areas(
    p0: float, hardness: float, g_rms: float = 1.0, E_star: float = 1.0
) -> tuple[float, float]:
    """Compute the relative contact area and the share of the nominal area that yields.

    Parameters
    ----------
    p0, hardness, g_rms, E_star : float
        As for `pressure_distribution`.

    Returns
    -------
    a_r, a_plastic : float
        a_r includes the points that yield.
    """
    width, images = _images(p0, hardness, g_rms, E_star)
    ends = 2 * hardness * images[images >= 0]

    def beyond(x: np.ndarray) -> np.ndarray:
        return erfc(x / (np.sqrt(2) * width))

    is_open = np.sum(beyond(ends + p0) - beyond(ends + 2 * hardness - p0))
    yielded = np.sum(beyond(ends + hardness - p0) - beyond(ends + hardness + p0))
    return float(1 - is_open), float(yielded)


def _images(p0: float, hardness: float, g_rms: float, E_star: float) -> tuple[float, np.ndarray]:
    """Return the standard deviation of the pressure in full contact, and the k of images 2 k
    hardness +- p0 with weight in double precision.
    """
    for name, value in (("hardness", hardness), ("g_rms", g_rms), ("E_star", E_star)):
        within(name, value, 0, np.inf, open_low=True)
    within("p0", p0, 0, np.inf)
    if not p0 < hardness:
        raise SceneError(f"p0: found {p0:g}, allowed: below the hardness, {hardness:g}")
    width = E_star * g_rms / 2
    farthest = int(np.ceil(FAR * width / hardness)) + 1
    return width, np.arange(-farthest, farthest + 1)
