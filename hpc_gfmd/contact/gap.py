"""Mean gap, as a length and relative to lengths of the surface, and how far the bodies approach."""

from math import isfinite

from .base import Contact, Observable


def gap_mean(contact: Contact) -> float | None:
    """Return the mean gap over the nominal area; points in contact and dents count as 0."""
    return None if contact.is_separated else contact.gap_mean


def gap_over_h_rms(contact: Contact) -> float | None:
    """Return the mean gap over the rms height; None on a flat surface and for separated bodies."""
    if contact.is_separated or contact.h_rms == 0:
        return None
    return contact.gap_mean / contact.h_rms


def gap_over_g_rms_lam_s(contact: Contact) -> float | None:
    """Return the mean gap over (g_rms lam_s), lam_s being the shortest wavelength."""
    return (
        contact.gap_mean / (contact.g_rms * contact.lam_s)
        if contact.lam_s and contact.g_rms > 0 and not contact.is_separated
        else None
    )


def approach(contact: Contact) -> float | None:
    """Return the approach since the undeformed touch; None (unbounded) on periodic half-spaces."""
    return contact.approach if isfinite(contact.approach) else None


OBSERVABLES = {
    "gap_mean": Observable(
        gap_mean, "mean gap over the nominal area, 0 or positive, contact included", "length"
    ),
    "gap_over_h_rms": Observable(gap_over_h_rms, "gap_mean over the rms height"),
    "gap_over_g_rms_lam_s": Observable(
        gap_over_g_rms_lam_s, "gap_mean over g_rms times the shortest wavelength"
    ),
    "approach": Observable(
        approach,
        "how far the bodies have come together since they touched undeformed, positive",
        "length",
    ),
}
