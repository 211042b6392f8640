"""The duality gap of the certificate: half an FFT pair, so only on request (and for solvers without
error estimates of their own)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .base import Observable

if TYPE_CHECKING:
    from .contact import Contact


def duality_gap(contact: Contact) -> float | None:
    """G/(p0 gap_mean): bounds the error of the energy from above (see certificate/certificate.py);
    None where it was not asked for."""
    return contact.certificate.duality_gap


OBSERVABLES = {
    "duality_gap": Observable(
        duality_gap, "bound of the error of the energy, over mean pressure times mean gap"
    )
}
