"""Notes on a contact with an attraction: what limits the meaning of its numbers."""

from __future__ import annotations

from math import ceil
from typing import Any

from ..laws.base import steepest

ABOUT_TO_JUMP = 0.1  # a stability
RESOLVED, FLIPPING = 0.5, 1.0  # softening over stiffness of one point: fine; flips alone


def attraction_notes(contact: Any) -> list[str]:
    """Return notes on stability, uniqueness and grid resolution of a Contact with an attraction.

    Empty without a law of attraction, for separated bodies, and if there is nothing to remark.
    """
    if contact.attraction is None or contact.is_separated:
        return []
    notes = []
    stability = contact.certificate.stability
    if stability < 0:
        notes.append(f"stability {stability:.2g}: a saddle, from which the energy falls further")
    elif stability < ABOUT_TO_JUMP:  # not of nan
        notes.append(
            f"stability {stability:.2g}: about to jump; errors are those of this equilibrium"
        )
    other = contact.other_branch
    if other is not None and not other.agrees:
        notes.append(f"not unique: {100 * other.a_r:.3g} % touch on the other branch")
    softness = resolution(contact)
    if softness > RESOLVED:
        finer = ceil(softness / RESOLVED)
        notes.append(
            f"range of the attraction not resolved ({softness:.2g}, at most {RESOLVED:g}): points"
            f" {finer} times as close"
            + "; single points jump, so that hysteresis is the grid's"
            * (softness > FLIPPING)
        )
    return notes


def resolution(contact: Any) -> float:
    """Return the largest softening of a point by the attraction over the point's elastic stiffness.

    Dimensionless. Above 1 a single point can jump without its neighbours. The contact must have a
    law of attraction.
    """
    law, grid = contact.attraction, contact.grid
    stiffness = float(contact.body.near(grid)[0]) * contact.E_star / grid.a
    return steepest(law) / stiffness
