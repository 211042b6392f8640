"""Reference data: contact area and mean gap of self-affine surfaces against p_star, with uncertainties and provenance.

    from hpc_gfmd import reference
    a_r, sigma = reference.contact_area(0.05, hurst=0.8, eps_f=1 / 256)

The data file is made from stored runs by `hpc-gfmd study all --level desk --no-run -o docs/study --reference FILE`. Reading it needs
neither MPI nor compiled kernels.
"""

from .data import Curve, Reference, load

__all__ = ["Curve", "Reference", "contact_area", "curve", "load", "mean_gap"]


def curve(hurst, eps_f):
    """The Curve of the shipped data at this H and eps_f. Raises SceneError for others than the tabulated ones."""
    return load().curve(hurst, eps_f)


def contact_area(p_star, hurst, eps_f, edge_corrected=True):
    """(a_r, its standard uncertainty) at p_star, interpolated along the curve; edge_corrected: less the pixels' share of the contact
    boundary, which is nearer to the continuum limit. Raises SceneError outside the curves and their range of p_star."""
    return load().curve(hurst, eps_f).at(p_star, "a_r_edge" if edge_corrected else "a_r")


def mean_gap(p_star, hurst, eps_f, unit="h_rms"):
    """(mean gap, its standard uncertainty) at p_star in units of "h_rms" or "g_rms_lam_s"; see contact_area."""
    return load().curve(hurst, eps_f).at(p_star, f"gap_over_{unit}")
