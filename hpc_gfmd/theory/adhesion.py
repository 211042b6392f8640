"""Whether a ball or a rough wall sticks: Tabor's parameter, Pastewka and Robbins' criterion. `w` is
the work of adhesion per area, in the unit of E_star times length. Numbers out of range raise
SceneError.
"""

import numpy as np
from numpy.typing import ArrayLike

from .checks import within


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
    """
    names = (("R", R), ("w", w), ("length", length), ("E_star", E_star))
    R, w, length, E_star = (within(name, x, 0, np.inf, True) for name, x in names)
    return np.cbrt(R * w**2 / (E_star**2 * length**3))


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
    """
    names = (("p", p), ("g_rms", g_rms), ("diameter", diameter), ("w", w), ("reach", reach))
    a_r = within("a_r", a_r, 0, 1)
    p, g_rms, diameter, w, reach = (within(name, x, 0, np.inf, True) for name, x in names)
    ring = np.cbrt(3 * reach / (4 * g_rms * diameter)) ** 2
    return a_r * w / reach / p * np.pi * ring
