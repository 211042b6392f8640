"""What an attraction of the surfaces (material.adhesion) does in a contact."""

from math import isfinite

from .base import Contact, Observable


def attraction(contact: Contact) -> float | None:
    """Return the mean attraction over the nominal area, by which the mean pressure where the
    surfaces touch exceeds that of the load; None without an attraction."""
    if contact.attraction is None or contact.is_separated:
        return None
    return contact.certificate.attraction * contact.pressure_unit


def separation_work(contact: Contact) -> float | None:
    """Return the work per nominal area that takes the bodies from here to where they do not
    attract each other, undeformed: minus their energy, elastic and of attraction.

    None without an attraction, and where the elastic energy has no end.
    """
    if contact.attraction is None or contact.is_separated or not isfinite(contact.energy):
        return None
    unit = contact.pressure_unit * contact.surface.height_unit
    return -contact.energy - contact.certificate.energy_of_attraction * unit


def stability(contact: Contact) -> float | None:
    """Return how far the equilibrium is from a jump, see certificate/stability.py; None without an
    attraction, and where it was not looked for."""
    share = contact.certificate.stability
    return share if isfinite(share) else None


OBSERVABLES = {
    "attraction": Observable(
        attraction, "mean attraction of the surfaces over the nominal area, positive", "pressure"
    ),
    "separation_work": Observable(
        separation_work,
        "work per nominal area that separates the bodies: minus elastic energy and that of"
        " attraction",
        "pressure length",
    ),
    "stability": Observable(
        stability,
        "of an equilibrium with attraction: least curvature of the energy over the elastic part of"
        " it; 1 without attraction, 0 at a jump",
    ),
}
