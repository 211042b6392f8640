"""Reference data: contact area and mean gap of self-affine surfaces against p_star, H and eps_f, with uncertainties.

    from hpc_gfmd import reference
    a_r, sigma = reference.contact_area(0.05, hurst=0.8, eps_f=1 / 256)

Extrapolated to large cells and fine grids, interpolated along all three. The data file is made from stored runs by
`hpc-gfmd study curves --level desk --no-run --reference FILE`. Reading it needs neither MPI nor compiled kernels.
"""

from .data import Reference, load

__all__ = ["Reference", "contact_area", "load", "mean_gap"]


def contact_area(p_star, hurst, eps_f):
    """(relative contact area, its standard uncertainty) at p_star (number or array). Raises SceneError outside the ranges of the data."""
    return load().at("a_r", p_star, hurst, eps_f)


def mean_gap(p_star, hurst, eps_f, unit="h_rms"):
    """(mean gap, its standard uncertainty) at p_star in units of "h_rms" or "g_rms_lam_s" (that of sharp cutoffs in a large cell).

    Raises SceneError outside the ranges of the data, and for other units.
    """
    from ..theory import persson

    gap, sigma = load().at("gap_over_h_rms", p_star, hurst, eps_f)
    if unit == "h_rms":
        return gap, sigma
    persson.mean_gap(1.0, hurst, eps_f, unit=unit)  # refuses other units
    length = persson.g_rms_lam_s_over_h_rms(hurst, eps_f)
    return gap / length, sigma / length
