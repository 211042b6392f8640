"""Whether the equilibrium with an attraction is the only one: the same load on the other branch
(load.unique)."""

from typing import NamedTuple

import numpy as np

from .base import Contact, Observable

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


def compared(contact: Contact, other: Contact) -> OtherBranch | None:
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


def _difference_of_pressures(contact: Contact, other: Contact) -> float:
    """Return the L2 norm of the difference of two pressure fields, over that of the first.
    Collective."""

    def squares(i0: int, i1: int) -> tuple[float, float]:
        p, q = (one.pressure_rows(i0, i1).astype(np.float64) for one in (contact, other))
        return float(((p - q) ** 2).sum()), float((p**2).sum())

    grid = contact.grid
    parts = [(0.0, 0.0), *grid.by_rows(squares, grid.inside[0])]
    difference, whole = grid.comm.sum(np.sum(parts, axis=0)).tolist()
    return float(np.sqrt(difference / whole)) if whole > 0 else np.inf


def unique(contact: Contact) -> float | None:
    """Return 1 where both branches have the same equilibrium, 0 where they have not; None where
    the other one was not asked for, or not found."""
    return None if contact.other_branch is None else float(contact.other_branch.agrees)


def a_r_other_branch(contact: Contact) -> float | None:
    """Return the relative contact area on the other branch; None as `unique`."""
    return None if contact.other_branch is None else contact.other_branch.a_r


OBSERVABLES = {
    "unique": Observable(
        unique,
        "1: both branches have the same equilibrium, so that, but for what a grid adds, there is no"
        " other; 0: they have not (load.unique)",
    ),
    "a_r_other_branch": Observable(
        a_r_other_branch, "relative contact area at this load on the other branch (load.unique)"
    ),
}
