"""Contact stiffness: the slope of the load against the mean gap."""

from math import inf

from .base import Contact, Observable

ON_REQUEST = True


def stiffness(contact: Contact) -> float | None:
    """Return the stiffness -dp/d(mean gap) at a fixed set of points in contact.

    A pressure per length. Its relative error is at most `contact.accuracy`. Collective; the first
    call that needs `contact.tangent` takes FFT pairs. None with an attraction (whose slope it
    would have to include), in full contact (where it is infinite), if nothing touches, and if the
    accuracy was not reached.
    """
    if contact.attraction is not None:
        return None
    compliance = contact.tangent.compliance
    return (
        contact.pressure_unit / (compliance * contact.surface.height_unit)
        if 0 < compliance < inf
        else None
    )


OBSERVABLES = {
    "stiffness": Observable(
        stiffness,
        "-dp/d(gap_mean), the tangent of the load curve, positive",
        "pressure/length",
        absent="full contact has an infinite one, no contact has none, and with adhesion it is not"
        " computed",
    )
}
