"""The same load on the other branch, where there is an attraction."""

from typing import Any, NamedTuple

import numpy as np

SOLVED = "converged", "separated"  # a status that says which equilibrium there is


class OtherBranch(NamedTuple):
    """The same load, reached from the other side.

    Attributes
    ----------
    a_r : float
        Relative contact area.
    agrees : bool
        Whether it is the same equilibrium, within the errors of both.
    """

    a_r: float
    agrees: bool


def compared(contact: Any, other: Any) -> OtherBranch | None:
    """Compare two contacts at one load; None where one of them is not solved. Collective.

    Parameters
    ----------
    contact, other : Contact
        On both branches, on the same grid.

    Returns
    -------
    OtherBranch or None
        About `other`.
    """
    if contact.status not in SOLVED or other.status not in SOLVED:
        return None
    a_r = other.contact_points / other.N
    if contact.is_separated or other.is_separated:
        return OtherBranch(a_r, contact.status == other.status)
    area, gap, pressure = np.add(contact.certificate.errors, other.certificate.errors)
    points = abs(contact.contact_points - other.contact_points)
    gaps = abs(contact.gap_mean - other.gap_mean)
    agrees = (
        points <= area * contact.contact_points + 1
        and gaps <= gap * contact.gap_mean
        and _difference_of_pressures(contact, other) <= pressure
    )
    return OtherBranch(a_r, bool(agrees))


def _difference_of_pressures(contact: Any, other: Any) -> float:
    """Return the L2 norm of the difference of two pressure fields, over that of the first.
    Collective."""

    def squares(i0: int, i1: int) -> tuple[float, float]:
        p, q = (one.pressure_rows(i0, i1).astype(np.float64) for one in (contact, other))
        return float(((p - q) ** 2).sum()), float((p**2).sum())

    grid = contact.grid
    parts = [(0.0, 0.0), *grid.by_rows(squares, grid.inside[0])]
    difference, whole = grid.comm.sum(np.sum(parts, axis=0)).tolist()
    return float(np.sqrt(difference / whole)) if whole > 0 else np.inf
