"""Notes on a contact that a reader needs before its numbers: what limits their meaning."""

from __future__ import annotations

from math import ceil
from typing import Any

import numpy as np

from ..laws.base import steepest
from ..scene.model import TOUCHING
from ..surface.doubtful_numbers import load_notes
from ..util.quantities import prefixed

METALLIC = 1.5e10  # Pa: least effective modulus of metals; polymers are softer
YIELDS_AT = 50  # metals yield where the contact pressure is E* over about this
ABOUT_TO_JUMP = 0.1  # a stability
RESOLVED, FLIPPING = 0.5, 1.0  # softening over stiffness of one point: fine; flips alone


def notes_on(contact: Any) -> list[str]:
    """Return all notes on a Contact, most important first, without those on its surface."""
    doubt = _doubt(contact)
    notes = [
        doubt,
        _limit(contact) if doubt is None or contact.status == "stagnated" else None,
        *_on_attraction(contact),
        contact.remark,
        *load_notes(contact.p_mean, contact.E_star, contact.g_rms),
        _yields(contact),
    ]
    return [str(note) for note in notes if note]


def _doubt(contact: Any) -> str | None:
    """Return the first reason why even a converged solution may be of little use, or None."""
    points = contact.contact_points
    if contact.is_separated and contact.p_mean < 0:
        return "separated: the load pulls more than the attraction holds"
    if contact.is_separated:  # at a mean gap or an approach
        return "separated: the bodies are too far apart for the attraction to hold them"
    if points == 0 and contact.p_mean == 0 and contact.attraction is None:
        return "no load: nothing touches"
    if contact.g_rms == 0 and points == contact.N:
        return "flat surface: every point touches at any load, and p* has no value, as g_rms is 0"
    if points == contact.N:
        return "full contact: every point touches, the gap is zero"
    if points < TOUCHING:
        touch = "touches" if points == 1 else "touch"
        return (
            f"only {points} point{'s' * (points != 1)} {touch}: the area is known to"
            f" {100 / max(points, 1):.0f} % at best"
        )
    if contact.gap_is_rounding:
        precision = "single" if contact.g.dtype == np.float32 else "double"
        return f"the gap is all rounding at this load in {precision} precision"
    return None


def _limit(contact: Any) -> str | None:
    """Return which relative error of a Contact is large, by what iterations cannot reduce."""
    gap, pressure = contact.certificate.attainable
    why = "rounding errors, and those of free edges and of loads before"
    for name, best in {"mean gap": gap, "pressure": pressure}.items():
        if contact.accuracy < best < np.inf:
            return f"the {name} is known to {best:.1g} at best: {why}"
    area = contact.certificate.errors[0]
    is_few = contact.contact_points < TOUCHING
    if contact.status == "stagnated" and pressure > 0 and contact.accuracy < area and not is_few:
        return f"the area is known to {area:.1g}: {why} leave open which points touch"
    return None


def _yields(contact: Any) -> str | None:
    """Return a note if a metal without a hardness would yield at the mean contact pressure."""
    is_soft = contact.E_star < METALLIC
    if contact.hardness is not None or is_soft or contact.contact_points == 0:
        return None
    pressure = contact.wall_pressure * contact.N / contact.contact_points
    if pressure * YIELDS_AT < contact.E_star:
        return None
    scale, unit = prefixed([pressure], "Pa")
    share = contact.E_star / pressure
    return (
        f"mean contact pressure {pressure / scale:.3g} {unit} = E*/{share:.2g}: metals yield"
        f" from about E*/{YIELDS_AT}; give the hardness"
    )


def _on_attraction(contact: Any) -> list[str]:
    """Return notes on stability, uniqueness and grid resolution of a Contact with an attraction."""
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
    other_branch = contact.other_branch
    if other_branch is not None and not other_branch.agrees:
        notes.append(f"not unique: {100 * other_branch.a_r:.3g} % touch on the other branch")
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
    """Return softening by attraction over a point's stiffness: above 1 a point can jump alone."""
    law, grid = contact.attraction, contact.grid
    stiffness = float(contact.body.near(grid)[0]) * contact.E_star / grid.a
    return steepest(law) / stiffness
