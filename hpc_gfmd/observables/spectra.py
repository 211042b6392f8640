"""Power spectra and autocorrelations of heights, pressure and gap, averaged over directions: see
operators/spectra.py."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from . import Counted

PERIODIC = True
FIELDS = ("heights", "pressure", "gap")


def _of(name: str, what: str) -> Counted:
    return lambda contact: getattr(contact.spectra, what)(name)


DISTRIBUTIONS = {
    f"{name}_{end}": _of(name, what)
    for end, what in (("spectrum", "power"), ("autocorrelation", "autocorrelation"))
    for name in FIELDS
}
