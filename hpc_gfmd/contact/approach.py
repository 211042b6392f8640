"""How far the bodies have come together: the rigid displacement."""

from math import isfinite

from .base import Contact, Observable


def approach(contact: Contact) -> float | None:
    """Return how far the bodies have approached since they touched undeformed; None if unbounded.

    A length, positive when they are pressed together. It is unbounded, and None, for a half-space
    that is periodic along at least one axis. It has a value for an elastic layer on a base, and for
    a half-space under a surface with free edges along both axes.
    """
    return contact.approach if isfinite(contact.approach) else None


OBSERVABLES = {
    "approach": Observable(
        approach,
        "how far the bodies have come together since they touched undeformed, positive",
        "length",
    )
}
