"""Reference data: contact area and mean gap of self-affine surfaces against p_star, with uncertainties and provenance.

    from hpc_gfmd import reference
    a_r, sigma = reference.contact_area(0.05, hurst=0.8, eps_f=1 / 256)

The data file is made from stored runs by `hpc-gfmd study all --level desk --no-run -o docs/study --reference FILE`. Reading it needs
neither MPI nor compiled kernels.
"""

import numpy as np
from numpy.typing import ArrayLike

from .data import Curve, Reference, load

__all__ = ["Curve", "Reference", "contact_area", "curve", "load", "mean_gap"]


def curve(hurst: float, eps_f: float) -> Curve:
    """The curve of the shipped data at one Hurst exponent and fractal parameter.

    Parameters
    ----------
    hurst, eps_f : float
        Hurst exponent, and lam_s/lam_l.

    Returns
    -------
    Curve

    Raises
    ------
    SceneError
        For others than the tabulated ones.
    """
    return load().curve(hurst, eps_f)


def contact_area(p_star: ArrayLike, hurst: float, eps_f: float,
                 edge_corrected: bool = True) -> tuple[float | np.ndarray, float | np.ndarray]:
    """Relative contact area of a self-affine surface, interpolated along a curve of the shipped data.

    Parameters
    ----------
    p_star : float or array
        p0/(E* g_rms).
    hurst, eps_f : float
        Hurst exponent, and lam_s/lam_l: of a tabulated curve.
    edge_corrected : bool
        Less the pixels' share of the contact boundary, which is nearer to the continuum limit.

    Returns
    -------
    a_r, sigma : float or array
        The area over the nominal one and its standard uncertainty, in the shape of p_star.

    Raises
    ------
    SceneError
        Outside the curves and their range of p_star.
    """
    return load().curve(hurst, eps_f).at(p_star, "a_r_edge" if edge_corrected else "a_r")


def mean_gap(p_star: ArrayLike, hurst: float, eps_f: float, unit: str = "h_rms") -> tuple[float | np.ndarray, float | np.ndarray]:
    """Mean gap of a self-affine surface, interpolated along a curve of the shipped data.

    Parameters
    ----------
    p_star, hurst, eps_f
        As of `contact_area`.
    unit : {"h_rms", "g_rms_lam_s"}
        The length that the gap is given in.

    Returns
    -------
    gap, sigma : float or array
        The mean gap and its standard uncertainty, in that unit and the shape of p_star.

    Raises
    ------
    SceneError
        As `contact_area`, and for other units.
    """
    return load().curve(hurst, eps_f).at(p_star, f"gap_over_{unit}")
