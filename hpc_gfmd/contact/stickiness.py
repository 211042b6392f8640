"""The criterion of Pastewka and Robbins for whether a rough wall sticks, applied to a contact."""

from .base import Contact, Observable
from .perimeter import perimeter

ON_REQUEST = True


def stickiness(contact: Contact) -> float | None:
    """Return the attraction in a ring around the contact over the repulsion in the contact.

    The wall sticks above 1; far below 1 adhesion is negligible. Computed from the area, the
    perimeter and the load of this contact. None without a law of attraction, for separated bodies,
    on a flat surface, and if no contact edge exists (nothing or everything touches). Collective.
    """
    from math import pi

    from ..theory.adhesion import stickiness as of_ring

    law = contact.attraction
    if law is None or contact.is_separated or contact.g_rms == 0:
        return None
    edge = perimeter(contact)
    if edge == 0:
        return None
    area = contact.contact_points * contact.grid.spacings[0] * contact.grid.spacings[1]
    reach = law.work / float(law.traction(0.0))
    share = contact.contact_points / contact.N
    return float(
        of_ring(share, contact.wall_pressure, contact.g_rms, pi * area / edge, law.work, reach)
    )


OBSERVABLES = {
    "stickiness": Observable(
        stickiness,
        "attraction beside the contact over the repulsion in it, by the criterion of Pastewka and"
        " Robbins; the wall sticks above 1",
        sources=("Pastewka, Robbins, PNAS 111 (2014) 3298, doi:10.1073/pnas.1320846111",),
    )
}
