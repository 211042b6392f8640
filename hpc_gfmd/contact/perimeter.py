"""Length of the edge of the contact."""

import numpy as np

from .base import Contact, Observable

ON_REQUEST = True


def perimeter(contact: Contact) -> float:
    """Return the length of the edges of all patches, from the sides between points that touch and
    points that do not.

    By Cauchy and Crofton: a line of length S with no preferred direction crosses the rows and the
    columns of a grid as often as the sides of grid points say, whose lengths add up to 4/pi S,
    whatever the shape of a point. So it is pi/4 of those lengths (as in Yastrebov, Anciaux,
    Molinari 2017), an average over directions: an edge along x or y alone counts pi/4 of its
    length. Contacts that vary along one axis only have such edges alone: there it is the lengths
    themselves.
    """
    along_x, along_y = contact.edges
    a_x, a_y = contact.grid.spacings
    return average_direction(contact) * (along_x * a_x + along_y * a_y)


def average_direction(contact: Contact) -> float:
    """Return the length of an edge over that of the sides of points along it, see `perimeter`."""
    return 1.0 if 1 in contact.grid.nominal else np.pi / 4


OBSERVABLES = {
    "perimeter": Observable(
        perimeter, "length of the edges of all patches, average over directions", "length"
    )
}
