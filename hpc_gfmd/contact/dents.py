"""Dents of a body with a hardness: their mean depth, and the work that they have taken."""

from .base import Contact, Observable

WITHOUT = "without material.hardness nothing yields"


def dent_mean(contact: Contact) -> float | None:
    """Return the mean depth of the dents, of all loads so far where they stay. Collective."""
    return None if contact.hardness is None else contact.dent_sums[1]


def dissipated_work(contact: Contact) -> float | None:
    """Return the work per area that the dents have taken: hardness times depth. Collective."""
    return None if contact.hardness is None else contact.hardness * contact.dent_sums[1]


OBSERVABLES = {
    "dent_mean": Observable(
        dent_mean,
        "mean depth of the dents over the nominal area, with load.history of all loads so far",
        "length",
        absent=WITHOUT,
    ),
    "dissipated_work": Observable(
        dissipated_work,
        "work per nominal area that the dents have taken: the hardness times dent_mean",
        "pressure length",
        absent=WITHOUT,
    ),
}
