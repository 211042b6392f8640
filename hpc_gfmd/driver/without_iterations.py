"""The contacts that need no iterations: bodies that are not loaded or have come apart."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..certificate.certificate import Certificate
from ..operators.state import State
from .nested import undeformed_gap

if TYPE_CHECKING:
    from ..contact.contact import Contact
    from .working_surface import WorkingSurface

EXACT = (0.0, 0.0, 0.0)  # errors of area, mean gap and pressure


def unloaded_contact(working: WorkingSurface, apart: float) -> Contact:
    """Return the contact, exactly known, of bodies that are `apart`. Collective."""
    state = _undeformed(working)
    state.g += state.g.dtype.type(apart)
    gap_mean = working.heights.top / working.surface.grid.a + apart
    certificate = Certificate(errors=EXACT, gap_mean=gap_mean, approach=-apart)
    return working.contact(0.0, state, "converged", certificate)


def separated_contact(
    working: WorkingSurface,
    p_mean: float,
    remark: str | None = None,
    iterations: int = 0,
    pairs: float = 0.0,
) -> Contact:
    """Return the contact of separated bodies: undeformed at touch, no pressure, a mean gap of nan.

    p_mean: the prescribed pressure, 0 at a gap or an approach.
    """
    certificate = Certificate(errors=EXACT, gap_mean=np.nan)
    state = _undeformed(working)
    return working.contact(p_mean, state, "separated", certificate, remark, iterations, pairs)


def _undeformed(working: WorkingSurface) -> State:
    """Return the state of a body without load that just touches."""
    g = undeformed_gap(working.problem(0.0))
    return State(working.surface.grid, g, np.zeros_like(g), 0.0)
