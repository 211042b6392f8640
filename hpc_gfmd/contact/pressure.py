"""The pressure in contact: its mean and its largest value."""

from .base import Contact, Observable


def contact_pressure_mean(contact: Contact) -> float | None:
    """Return the mean pressure over the contact area, attraction included; None without contact."""
    if contact.contact_points == 0:
        return None
    return contact.wall_pressure * contact.N / contact.contact_points


def contact_pressure_max(contact: Contact) -> float:
    """Return the largest pressure at a grid point, 0 if nothing touches. Collective."""
    return contact.peak.p * contact.pressure_unit


OBSERVABLES = {
    "contact_pressure_mean": Observable(
        contact_pressure_mean, "mean pressure where the surfaces touch: p/a_r", "pressure"
    ),
    "contact_pressure_max": Observable(
        contact_pressure_max, "largest pressure of a grid point", "pressure"
    ),
}
