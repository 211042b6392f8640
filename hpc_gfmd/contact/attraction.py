"""Numbers of a contact with an attraction of the surfaces (material.adhesion)."""

from math import isfinite

from .base import Contact, Observable


def attraction(contact: Contact) -> float | None:
    """Return the mean attractive pressure over the nominal area, in the unit of E_star, positive.

    The mean pressure on the wall is the mean pressure of the load plus this attraction. None
    without a law of attraction and for separated bodies.
    """
    if contact.attraction is None or contact.is_separated:
        return None
    return contact.certificate.attraction * contact.pressure_unit


def separation_work(contact: Contact) -> float | None:
    """Return the work per nominal area needed to separate the bodies and remove their deformation.

    It is minus the sum of the elastic energy and the energy of attraction, in the unit of E_star
    times length. None without a law of attraction, for separated bodies, and where the elastic
    energy is undefined (a half-space that is periodic along one axis only).
    """
    if contact.attraction is None or contact.is_separated or not isfinite(contact.energy):
        return None
    unit = contact.pressure_unit * contact.surface.height_unit
    return -contact.energy - contact.certificate.energy_of_attraction * unit


def stability(contact: Contact) -> float | None:
    """Return the stability of an equilibrium with attraction: 0 at a jump, negative at a saddle.

    At most 1, its value for a vanishing attraction; see certificate/stability.py. None without a
    law of attraction, or if it was not computed.
    """
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
