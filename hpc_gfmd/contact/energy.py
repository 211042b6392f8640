"""Elastic energy per area."""

from math import isfinite

from .base import Contact, Observable


def energy(contact: Contact) -> float | None:
    """Return U/A, on a half-space (E*/4) sum_q |q| |u_q|^2 (eq. elaEnerg2D); None where it has no
    end."""
    return contact.energy if isfinite(contact.energy) else None


OBSERVABLES = {
    "energy": Observable(
        energy,
        "elastic energy of the deformation over the nominal area, positive",
        "pressure length",
    )
}
