"""Comparison of the two branches of a load with attraction: approaching, or pulled apart."""

from typing import Any, NamedTuple

import numpy as np

SOLVED = "converged", "separated"  # a status that says which equilibrium there is


class OtherBranch(NamedTuple):
    """What the same load gives when it is reached from the other side (approach or retraction).

    Attributes
    ----------
    a_r : float
        Relative contact area on the other branch.
    agrees : bool
        Whether both branches have the same equilibrium, within the errors of both.
    """

    a_r: float
    agrees: bool


def compared(contact: Any, other: Any) -> OtherBranch | None:
    """Compare the contacts of one load on both branches. Collective.

    They agree if contact points, mean gap and pressure field differ by no more than the sum of
    their estimated errors (plus one point), or if both are separated.

    Parameters
    ----------
    contact, other : Contact
        On either branch, on the same grid.

    Returns
    -------
    OtherBranch or None
        With the area of `other`; None if one of the contacts is neither converged nor separated.
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
    """Return the L2 norm of the difference of two pressure fields over that of the first.

    inf if the first one is 0. Collective.
    """

    def squares(i0: int, i1: int) -> tuple[float, float]:
        """Return the sums of (p - q)^2 and p^2 over some local rows."""
        p, q = (one.pressure_rows(i0, i1).astype(np.float64) for one in (contact, other))
        return float(((p - q) ** 2).sum()), float((p**2).sum())

    grid = contact.grid
    parts = [(0.0, 0.0), *grid.by_rows(squares, grid.inside[0])]
    difference, whole = grid.comm.sum(np.sum(parts, axis=0)).tolist()
    return float(np.sqrt(difference / whole)) if whole > 0 else np.inf
