"""Power spectra and autocorrelations of heights, pressure and gap, averaged over directions: see operators/spectra.py."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from . import Counted

PERIODIC = True
FIELDS = ("heights", "pressure", "gap")


def _power(name: str) -> Counted:
    return lambda contact: contact.spectra.power(name)


def _autocorrelation(name: str) -> Counted:
    return lambda contact: contact.spectra.autocorrelation(name)


DISTRIBUTIONS = {f"{name}_spectrum": _power(name) for name in FIELDS} | {
    f"{name}_autocorrelation": _autocorrelation(name) for name in FIELDS}
