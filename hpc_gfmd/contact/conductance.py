"""Contact conductance, of heat and of electric current.

The potential of a steady flow into a half-space and the normal displacement of one that is pressed
solve the same problem: both are constant over the contact, with no flow and no pressure beside it.
So the conductance per nominal area, without films and with an insulating gap, is the contact
stiffness times 2 k1 k2/(k1 + k2) over E* (Barber 2003), k1 and k2 being the conductivities.
"""

from math import inf

from .base import Contact, Observable

ON_REQUEST = True


def conductance(contact: Contact) -> float | None:
    """Return the contact conductance per nominal area over 2 k1 k2/(k1 + k2), in 1/length.

    It is the contact stiffness over E_star: that of the mean gap for a periodic surface, that of
    the approach for a surface with free edges along both axes. None for layers and coatings, for
    free edges along one axis only, if no point or every point touches, and if the accuracy was not
    reached. Collective; the first call that needs `contact.tangent` takes FFT pairs.
    """
    from ..bodies.halfspace import HalfSpace

    if not isinstance(contact.body, HalfSpace):
        return None
    tangent = contact.tangent
    compliance = tangent.compliance if all(contact.periodic) else tangent.approach
    slope = contact.surface.slope / contact.surface.height_unit
    return slope / compliance if 0 < compliance < inf else None


OBSERVABLES = {
    "conductance": Observable(
        conductance,
        "contact conductance per nominal area, over 2 k1 k2/(k1 + k2) or 2/(rho1 + rho2)",
        "1/length",
        ("Barber, Proc. R. Soc. A 459 (2003) 53, doi:10.1098/rspa.2002.1038",),
        absent="layers and coatings have none (heat passes through another body than pressure),"
        " nor have full contact, no contact, and free edges along one axis alone",
    )
}
