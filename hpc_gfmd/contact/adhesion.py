"""Contacts with adhesion: work, stability, the other branch, and whether a rough wall sticks."""

from math import isfinite, pi

from .base import Contact, Observable
from .patches import perimeter

ON_REQUEST = ("stickiness",)


def attraction(contact: Contact) -> float | None:
    """Return the mean attraction over the nominal area, positive; it adds to p on the wall."""
    if contact.attraction is None or contact.is_separated:
        return None
    return contact.certificate.attraction * contact.pressure_unit


def separation_work(contact: Contact) -> float | None:
    """Return the work per area to separate the bodies: minus elastic energy and attraction's."""
    if contact.attraction is None or contact.is_separated or not isfinite(contact.energy):
        return None
    unit = contact.pressure_unit * contact.surface.height_unit
    return -contact.energy - contact.certificate.energy_of_attraction * unit


def stability(contact: Contact) -> float | None:
    """Return the stability with attraction, at most 1: 0 at a jump, negative at a saddle."""
    share = contact.certificate.stability
    return share if isfinite(share) else None


def unique(contact: Contact) -> float | None:
    """Return 1 if both branches have the same equilibrium, 0 if not, None if one is unknown."""
    return None if contact.other_branch is None else float(contact.other_branch.agrees)


def a_r_other_branch(contact: Contact) -> float | None:
    """Return the relative contact area on the other branch; None if that was not solved."""
    return None if contact.other_branch is None else contact.other_branch.a_r


def stickiness(contact: Contact) -> float | None:
    """Return attraction around the contact over repulsion in it (Pastewka and Robbins): the wall
    sticks above 1; None without a contact edge. Collective.
    """
    from ..theory.adhesion import stickiness as of_ring

    law = contact.attraction
    if law is None or contact.is_separated or contact.g_rms == 0:
        return None
    edge = perimeter(contact)
    if edge == 0:
        return None
    area = contact.contact_points * contact.grid.spacings[0] * contact.grid.spacings[1]
    reach = law.work / float(law.traction(0.0))
    share = contact.contact_points / contact.N
    return float(
        of_ring(share, contact.wall_pressure, contact.g_rms, pi * area / edge, law.work, reach)
    )


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
    "unique": Observable(
        unique,
        "1: both branches have the same equilibrium, so that, but for what a grid adds, there is no"
        " other; 0: they have not (load.unique)",
    ),
    "a_r_other_branch": Observable(
        a_r_other_branch, "relative contact area at this load on the other branch (load.unique)"
    ),
    "stickiness": Observable(
        stickiness,
        "attraction beside the contact over the repulsion in it, by the criterion of Pastewka and"
        " Robbins; the wall sticks above 1",
        sources=("Pastewka, Robbins, PNAS 111 (2014) 3298, doi:10.1073/pnas.1320846111",),
    ),
}
