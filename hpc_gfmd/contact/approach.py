"""How far the bodies have come together: the rigid displacement."""

from math import isfinite

from .base import Contact, Observable


def approach(contact: Contact) -> float | None:
    """Return how far the bodies have come together since they touched undeformed: against a base,
    or infinity where the surface ends along both axes; None on a half-space that is periodic along
    an axis, which gives way without end."""
    return contact.approach if isfinite(contact.approach) else None


OBSERVABLES = {
    "approach": Observable(
        approach,
        "how far the bodies have come together since they touched undeformed, positive",
        "length",
    )
}
