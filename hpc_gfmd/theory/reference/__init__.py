"""Reference data: contact area and mean gap of self-affine surfaces against p_star, H and eps_f,
with uncertainties.

    from hpc_gfmd import reference
    a_r, sigma = reference.contact_area(0.05, hurst=0.8, eps_f=1 / 256)

Extrapolated to large cells and fine grids, interpolated along all three. The mean gap ends at a
smaller p_star than the contact area: above, it closes (contact everywhere) in some cells. The data
file is made from stored runs by `python scripts/paper curves --level desk --no-run --reference
FILE`. Reading it needs neither MPI nor compiled kernels.
"""

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from .. import persson
from .data import Reference, load

__all__ = ["Reference", "contact_area", "load", "mean_gap"]

_shipped = cache(load)  # is read once


def contact_area(
    p_star: ArrayLike, hurst: float, eps_f: float
) -> tuple[float | np.ndarray, float | np.ndarray]:
    """Interpolate the relative contact area of a self-affine surface in the shipped data.

    Parameters
    ----------
    p_star : float or array
        p0/(E* g_rms).
    hurst, eps_f : float
        Hurst exponent and lam_s/lam_l.

    Returns
    -------
    a_r, sigma : float or array
        The area and its absolute standard uncertainty, in the shape of p_star.

    Raises
    ------
    SceneError
        If a number is outside of the range of the data.
    """
    return _shipped().at("a_r", p_star, hurst, eps_f)


def mean_gap(
    p_star: ArrayLike, hurst: float, eps_f: float, unit: str = "h_rms"
) -> tuple[float | np.ndarray, float | np.ndarray]:
    """Interpolate the mean gap of a self-affine surface in the shipped data.

    Parameters
    ----------
    p_star, hurst, eps_f
        As for `contact_area`.
    unit : {"h_rms", "g_rms_lam_s"}
        The length that the gap is given in. The data are in h_rms; they are converted by the ratio
        that the two have for sharp cutoffs in a large cell.

    Returns
    -------
    gap, sigma : float or array
        The mean gap and its absolute standard uncertainty, in that unit and the shape of p_star.

    Raises
    ------
    SceneError
        As `contact_area`, and if the unit is unknown.
    """
    gap, sigma = _shipped().at("gap_over_h_rms", p_star, hurst, eps_f)
    theory = [persson.mean_gap(1.0, hurst, eps_f, unit=name) for name in (unit, "h_rms")]
    scale = float(theory[0] / theory[1])
    return gap * scale, sigma * scale
