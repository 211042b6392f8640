"""Whether an equilibrium with attraction is the only one at its load, by the other branch
(load.unique).
"""

from .base import Contact, Observable


def unique(contact: Contact) -> float | None:
    """Return 1 if both branches have the same equilibrium, 0 if not, None if one is unknown.

    The other branch is unknown unless the scene requests it (load.unique) and its load converged.
    """
    return None if contact.other_branch is None else float(contact.other_branch.agrees)


def a_r_other_branch(contact: Contact) -> float | None:
    """Return the relative contact area on the other branch; None if that was not solved."""
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
