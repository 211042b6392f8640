"""The Contact of a load from its fields, and those that need no iterations: flat surfaces, bodies
that are not loaded or have come apart.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..certificate.certificate import Certificate
from ..contact.contact import Contact
from ..operators.state import State
from .nested import undeformed_gap

if TYPE_CHECKING:
    from .load import Load
    from .working_surface import WorkingSurface

EXACT = (0.0, 0.0, 0.0)  # errors of area, mean gap and pressure


def contact_of(
    working: WorkingSurface,
    load: Load,
    state: State,
    status: str,
    certificate: Certificate,
    iterations: int = 0,
    pairs: float = 0.0,
) -> Contact:
    """Assemble the Contact of a solved load, with the arrays of the state."""
    model = working.model
    return Contact(
        working.surface,
        model.E_star,
        load.value if load.is_pressure else state.p0 * working.pressure_unit,
        state.g,
        state.p,
        status,
        certificate,
        accuracy=working.settings.tolerance,
        lam_s=model.lam_s,
        body=model.body,
        remark=load.target.note,
        iterations=iterations,
        pairs=float(pairs),
        hardness=model.hardness,
        attraction=model.attraction,
    )


def flat_contact(working: WorkingSurface, load: Load) -> Contact:
    """Return the contact of a flat periodic surface: closed at any pressure, without errors."""
    grid = working.surface.grid
    g = np.zeros_like(working.surface.gap)
    p0 = load.value / working.model.E_star
    state = State(grid, g, np.full_like(g, p0), p0)
    certificate = Certificate(contact=grid.N, errors=EXACT, duality_gap=0.0)
    uniform = float(working.model.body.stiffness(np.zeros(1), grid.a)[0])
    if uniform > 0:  # a layer is compressed as a whole
        certificate = replace(certificate, energy=0.5 * p0**2 / uniform, approach=p0 / uniform)
    return contact_of(working, load, state, "converged", certificate)


def unloaded_contact(working: WorkingSurface, load: Load, apart: float) -> Contact:
    """Return the contact, exactly known, of bodies that are `apart`. Collective."""
    surface = working.surface
    g = undeformed_gap(working.problem(0.0))
    g += g.dtype.type(apart)
    gap_mean = working.heights.top / surface.grid.a + apart
    certificate = Certificate(errors=EXACT, gap_mean=gap_mean, approach=-apart)
    no_load = replace(load, quantity="pressure", value=0.0)
    state = State(surface.grid, g, np.zeros_like(g), 0.0)
    return contact_of(working, no_load, state, "converged", certificate)


def separated_contact(
    working: WorkingSurface, load: Load, iterations: int = 0, pairs: float = 0.0
) -> Contact:
    """Return the contact of separated bodies: undeformed at touch, no pressure, a mean gap of nan,
    the prescribed pressure or 0.
    """
    g = undeformed_gap(working.problem(load.p0))
    certificate = Certificate(errors=EXACT, gap_mean=np.nan)
    state = State(working.surface.grid, g, np.zeros_like(g), load.p0 if load.is_pressure else 0.0)
    return contact_of(working, load, state, "separated", certificate, iterations, pairs)
