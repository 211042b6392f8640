"""Relative contact area a_r, kappa = a_r/p*, their edge correction, and the error by the grid.

Points touch as a whole, and along the edge of the contact more touch than on a finer grid: by
EDGE_CORRECTION a^2 per side between contact and open points (Yastrebov, Anciaux, Molinari 2017), an
average over directions of the edge on square points: invalid for contacts that vary along one axis
only, and on points that are not square. Beyond a free edge the surface is open, too.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from .base import Contact, Observable
from .peak import may_open

EDGE_CORRECTION = (np.pi - 1 + np.log(2)) / 24
EDGE_1D = 0.7  # points by which whole points miss one edge in one dimension, at most
SOURCES = (
    "Yastrebov et al., J. Mech. Phys. Solids 107 (2017) 469, doi:10.1016/j.jmps.2017.07.016",
)
LATTICE = 12**-0.5  # rms by which whole points miss one edge, in points
BY_CHANCE = 3  # times that rms: what an error contains
SQUARE = 0.01  # relative difference of a_x and a_y up to which points count as square


def a_r(contact: Contact) -> float:
    """Return the fraction of the surface's points that are in contact."""
    return contact.contact_points / contact.N


def contact_area(contact: Contact) -> float:
    """Return the contact area in the unit of length squared: a_r times the nominal area."""
    L_x, L_y = contact.surface.sizes
    return a_r(contact) * L_x * L_y


def a_plastic(contact: Contact) -> float | None:
    """Return the fraction of points that yield or, where dents stay, have a dent (collective)."""
    if contact.dents is not None:
        return contact.dent_sums[0] / contact.N
    return None if contact.hardness is None else contact.certificate.yielded / contact.N


def a_r_corrected(contact: Contact) -> float | None:
    """Return a_r minus the excess area along the contact edge; None if invalid. Collective."""
    a_x, a_y = contact.grid.spacings
    if 1 in contact.grid.nominal or abs(a_x / a_y - 1) > SQUARE:
        return None
    return a_r(contact) - EDGE_CORRECTION * _sides_to_open(contact) / contact.N


def _sides_to_open(contact: Contact) -> int:
    """Return the number of sides between contact and open points, the surface beyond free edges
    among them; 0 if all points touch, as they do on any grid. Collective.
    """
    if contact.contact_points == contact.N:
        return 0
    return contact.boundary_segments + contact.edges.free


def _straight_sides(contact: Contact) -> float:
    """Return how many sides more run along one axis than along the other, per length, than by
    chance: edges that are straight on the grid, as of a lay along an axis.
    """
    a_x, a_y = contact.grid.spacings
    edges = contact.edges
    along_x = edges.along_x - edges.along_y * a_y / a_x
    along_y = edges.along_y - edges.along_x * a_x / a_y
    return max(along_x, along_y) - float(np.sqrt(edges.along_x + edges.along_y))


def a_r_discretisation(contact: Contact) -> float:
    """Estimate the relative error of a_r by the grid spacing; inf if nothing touches. Collective.

    The estimate is (b S + 3 sqrt(m (S + M)/12))/n_c for n_c points in contact, S sides to open
    points and M to mirror images: the full edge correction, and three times the random error of
    rounding each side to whole points, which m mirror images share. In one dimension it is
    EDGE_1D S/n_c, as the edges of one wave miss alike; so do straight ones in two. Next to full
    contact points are added that may open between them (peak.py: may_open). docs/accuracy.md has
    the measurements.
    """
    sides = _sides_to_open(contact)
    if contact.contact_points == 0:
        return float("inf")
    opening = may_open(contact)
    if 1 in contact.grid.nominal:
        return (EDGE_1D * sides + opening) / contact.contact_points
    rounded = sides + contact.edges.mirrored if sides else 0
    by_chance = BY_CHANCE * LATTICE * np.sqrt(contact.surface.images * rounded)
    alike = (EDGE_1D - EDGE_CORRECTION) * max(_straight_sides(contact), 0.0) if sides else 0.0
    error = EDGE_CORRECTION * sides + by_chance + alike + opening
    return float(error) / contact.contact_points


def kappa(area: Callable[[Contact], float | None], contact: Contact) -> float | None:
    """Return a relative contact area, by the function `area`, divided by p_star."""
    if contact.g_rms == 0 or contact.p_mean == 0:
        return None
    value = area(contact)
    return None if value is None else value / contact.p_star


OBSERVABLES = {
    "a_r": Observable(a_r, "relative contact area: points in contact over all points"),
    "contact_area": Observable(
        contact_area, "contact area: a_r times the nominal area", "length^2"
    ),
    "kappa": Observable(partial(kappa, a_r), "a_r/p_star"),
    "a_plastic": Observable(
        a_plastic,
        "share of the area where the pressure is the hardness: the part of a_r that yields; with"
        " load.history the share that has a dent",
        absent="without material.hardness nothing yields",
        sources=("Almqvist, Tribol. Int. 40 (2007) 574, doi:10.1016/j.triboint.2005.11.008",),
    ),
    "a_r_corrected": Observable(
        a_r_corrected,
        "a_r less what points on the edge of the contact count too much",
        sources=SOURCES,
    ),
    "kappa_corrected": Observable(
        partial(kappa, a_r_corrected), "a_r_corrected/p_star", sources=SOURCES
    ),
}
