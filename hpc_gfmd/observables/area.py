"""Relative contact area, kappa = a_r/p*, and both with the edge correction."""

import numpy as np

EDGE_CORRECTION = (np.pi - 1 + np.log(2)) / 24  # Yastrebov, Anciaux, Molinari 2017: area per boundary segment, in a^2


def a_r(contact):
    """Points in contact over all points."""
    return contact.contact_points / contact.N


def a_r_corrected(contact):
    """a_r less the area that the pixels on the contact boundary do not fill."""
    return a_r(contact) - EDGE_CORRECTION * contact.boundary_segments / contact.N


def _over_p_star(area):
    return lambda contact: area(contact) / contact.p_star if contact.g_rms > 0 else None


OBSERVABLES = {
    "a_r": a_r,
    "kappa": _over_p_star(a_r),
    "a_r_corrected": a_r_corrected,
    "kappa_corrected": _over_p_star(a_r_corrected),
}
