"""Power spectra and autocorrelations of heights, pressure and gap, averaged over directions: see
operators/spectra.py."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from .base import Arrays, Distribution

if TYPE_CHECKING:
    from .contact import Contact

PERIODIC = True
FIELDS = {"heights": "length", "pressure": "pressure", "gap": "length"}


def _of(name: str, what: str) -> Callable[[Contact], Arrays | None]:
    return lambda contact: getattr(contact.spectra, what)(name)


DISTRIBUTIONS = {
    f"{name}_spectrum": Distribution(
        _of(name, "power"),
        f"radial power spectrum of the {name}: L_x L_y <|f_q|^2>, over the wave number",
        {"q": "1/length", "power": f"{unit}^2 length^2"},
    )
    for name, unit in FIELDS.items()
} | {
    f"{name}_autocorrelation": Distribution(
        _of(name, "autocorrelation"),
        f"radial autocorrelation of the {name}, without their mean, over the distance",
        {"r": "length", "correlation": f"{unit}^2"},
    )
    for name, unit in FIELDS.items()
}
