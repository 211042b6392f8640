"""Contact stiffness: the tangent of the load curve."""

from math import inf

from .base import Contact, Observable

ON_REQUEST = True


def stiffness(contact: Contact) -> float | None:
    """Return -dp/d(mean gap) while no point changes sides, with a relative error of at most the
    accuracy asked for.

    None with an attraction, which it does not count in, in full contact, where it is infinite,
    where nothing touches, and where it was not found to that accuracy.
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
        absent="full contact has an infinite one, no contact has none",
    )
}
