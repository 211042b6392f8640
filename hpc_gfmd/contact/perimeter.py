"""Length of the contact edge."""

import numpy as np

from .base import Contact, Observable

ON_REQUEST = True


def perimeter(contact: Contact) -> float:
    """Return the length of the edges of all contact patches, in the unit of length. Collective.

    The grid-cell sides between points in contact and open points add up to 4/pi times the length of
    an edge that has no preferred direction (Cauchy and Crofton), whatever the shape of a point. So
    the result is pi/4 of these sides (as in Yastrebov, Anciaux, Molinari 2017). This is an average
    over directions: a straight edge along x or y gives pi/4 of its length. Contacts that vary along
    one axis only have no other edges, and for these the sides are not multiplied by pi/4.
    """
    along_x, along_y = contact.edges
    a_x, a_y = contact.grid.spacings
    return average_direction(contact) * (along_x * a_x + along_y * a_y)


def average_direction(contact: Contact) -> float:
    """Return the length of an edge over the length of the grid-cell sides along it, on average.

    pi/4, and 1 on a grid of one point along an axis; see `perimeter`.
    """
    return 1.0 if 1 in contact.grid.nominal else np.pi / 4


OBSERVABLES = {
    "perimeter": Observable(
        perimeter, "length of the edges of all patches, average over directions", "length"
    )
}
