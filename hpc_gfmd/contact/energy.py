"""Elastic energy per area."""

from math import isfinite

from .base import Contact, Observable


def energy(contact: Contact) -> float | None:
    """Return the elastic energy per nominal area; None where it is undefined.

    On a half-space (E*/4) sum_q |q| |u_q|^2 (eq. elaEnerg2D), in the unit of E_star times length.
    It is undefined for a half-space that is periodic along one axis only.
    """
    return contact.energy if isfinite(contact.energy) else None


OBSERVABLES = {
    "energy": Observable(
        energy,
        "elastic energy of the deformation over the nominal area, positive",
        "pressure length",
    )
}
