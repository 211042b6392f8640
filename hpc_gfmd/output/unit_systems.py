"""Consistent systems of units, as finite-element programs need them: they convert nothing."""

from typing import NamedTuple

from ..util.quantities import factor


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
    size = 1.0
    parts = []
    for k, part in enumerate(unit.split("/")):
        name, _, power = part.partition("^")
        for dimension in ("length", "force", "pressure"):
            if name == getattr(old, dimension):
                name = getattr(new, dimension)
                exponent = int(power or 1) * (-1 if k else 1)
                ratio = factor(part.partition("^")[0], dimension) / factor(name, dimension)
                size *= ratio**exponent
                break
        parts.append(f"{name}^{power}" if power else name)
    return size, "/".join(parts)
