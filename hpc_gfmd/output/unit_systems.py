"""Consistent systems of units, as finite-element programs need them: they convert nothing."""

import re
from math import log10
from typing import NamedTuple

from ..util.quantities import ratio


class System(NamedTuple):
    """Names of the units of a consistent system; a power is a force times a length per second."""

    length: str
    force: str
    pressure: str
    power: str


SYSTEMS = {
    "SI": System("m", "N", "Pa", "W"),
    "mm-N-MPa": System("mm", "N", "MPa", "mW"),
    "um-uN-MPa": System("um", "uN", "MPa", "pW"),
}


def system_of(length: str, pressure: str) -> System | None:
    """Return the system with these units of length and pressure, None if there is none."""
    units = {(system.length, system.pressure): system for system in SYSTEMS.values()}
    return units.get((length, pressure))


def converted(unit: str, old: System, new: System) -> tuple[float, str]:
    """Return one `unit`, such as "Pa/m", of the old system in the new: number and unit."""
    names = dict(zip(old, new))
    renamed = re.sub("[A-Za-z]+", lambda name: names.get(name[0], name[0]), unit)
    return 10.0 ** round(log10(ratio(unit, renamed))), renamed
