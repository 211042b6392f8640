"""Whether the equilibrium with an attraction is the only one: the same load on the other branch
(load.unique)."""

from .base import Contact, Observable


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
