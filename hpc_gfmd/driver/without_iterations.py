"""Contacts that need no iterations: of a flat surface, in full contact, and of separated bodies."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..certificate.certificate import Certificate
from ..certificate.error_estimates import full_contact_error
from ..contact.contact import Contact
from .full_contact import closed_contact, tension_of
from .nested import undeformed_gap
from .target import ROUNDING

if TYPE_CHECKING:
    from ..certificate.criterion import StoppingCriterion
    from .load import Load
    from .working_surface import WorkingSurface

EXACT = (0.0, 0.0, 0.0)  # errors of area, mean gap and pressure


class Attempt(NamedTuple):
    """The result of an attempt to solve a load.

    Attributes
    ----------
    contact : Contact or None
        The contact; None if the attempt does not apply: iterations or double precision are needed.
    pairs : float
        All FFT pairs that the load has taken so far.
    """

    contact: Contact | None
    pairs: float


def contact_of(
    working: WorkingSurface,
    load: Load,
    criterion: StoppingCriterion,
    p0: float,
    g: np.ndarray,
    p: np.ndarray,
    status: str,
    certificate: Certificate,
    iterations: int = 0,
    pairs: float = 0.0,
) -> Contact:
    """Assemble the Contact of a solved load. Nothing is computed or copied.

    Parameters
    ----------
    working : WorkingSurface
        The surface, with the model.
    load : Load
        The load; the note of its target becomes the remark of the contact.
    criterion : StoppingCriterion
        The accuracy that the solution had to reach.
    p0 : float
        Mean pressure of the solution, in the program's unit.
    g, p : ndarray
        Gap and pressure of the solution, local slabs of the grid.
    status : str
        Status of the load, see `Contact`.
    certificate : Certificate
        Certificate of the gap.
    iterations : int
        Iterations that the load has taken.
    pairs : float
        FFT pairs that the load has taken.

    Returns
    -------
    Contact
        Its mean pressure is exactly the prescribed one if a pressure was prescribed.
    """
    model = working.model
    return Contact(
        working.surface,
        model.E_star,
        load.value if load.is_pressure else p0 * working.pressure_unit,
        g,
        p,
        status,
        certificate,
        accuracy=criterion.tolerance,
        lam_s=model.lam_s,
        body=model.body,
        remark=load.target.note,
        iterations=iterations,
        pairs=float(pairs),
        hardness=model.hardness,
        attraction=model.attraction,
    )


def flat_contact(working: WorkingSurface, load: Load, criterion: StoppingCriterion) -> Contact:
    """Return the contact of a flat periodic surface, which is closed at any load.

    Parameters
    ----------
    working : WorkingSurface
        The surface.
    load : Load
        The load, a pressure.
    criterion : StoppingCriterion
        The requested accuracy.

    Returns
    -------
    Contact
        Converged, with a uniform pressure and errors of 0. Of a layer on a rigid base the energy
        and the approach are those of its compression, otherwise 0 and nan.
    """
    grid = working.surface.grid
    g = np.zeros_like(working.surface.gap)
    p0 = load.value / working.model.E_star
    p = np.full_like(g, p0)
    certificate = Certificate(contact=grid.N, errors=EXACT, duality_gap=0.0)
    uniform = float(working.model.body.stiffness(np.zeros(1), grid.a)[0])
    if uniform > 0:  # a layer is compressed as a whole
        certificate = replace(certificate, energy=0.5 * p0**2 / uniform, approach=p0 / uniform)
    return contact_of(working, load, criterion, load.value, g, p, "converged", certificate)


def separated_contact(
    working: WorkingSurface, load: Load, criterion: StoppingCriterion, iterations: int, pairs: float
) -> Contact:
    """Return the contact of bodies that have come apart, because the load exceeds the attraction.

    Parameters
    ----------
    working : WorkingSurface
        The surface.
    load : Load
        The load that pulls the bodies apart.
    criterion : StoppingCriterion
        The requested accuracy.
    iterations : int
        Iterations that the load has taken.
    pairs : float
        FFT pairs that the load has taken.

    Returns
    -------
    Contact
        With the status "separated", the gap of undeformed bodies that just touch, no pressure, and
        a mean gap of nan. Its mean pressure is the prescribed one, 0 if none was.
    """
    g = undeformed_gap(working.problem(load.p0))
    certificate = Certificate(errors=EXACT, gap_mean=np.nan)
    p = np.zeros_like(g)
    p0 = load.p0 if load.is_pressure else 0.0
    return contact_of(
        working, load, criterion, p0, g, p, "separated", certificate, iterations, pairs
    )


def full_contact(
    working: WorkingSurface, load: Load, criterion: StoppingCriterion, pairs: float
) -> Attempt:
    """Return the contact of a load if full contact, u = -h, is its solution.

    Tried if the load is large enough, or if it is the smallest one that closes the gap, which is
    computed here; not with an attraction or a search, nor in low memory. Collective.

    Parameters
    ----------
    working : WorkingSurface
        The surface.
    load : Load
        The load. If it `closes` the gap, its target gets the load that does.
    criterion : StoppingCriterion
        Whether the certificate has the duality gap.
    pairs : float
        FFT pairs that the load has taken so far.

    Returns
    -------
    Attempt
        Without a contact if full contact was not tried, if u = -h is not the solution, or if single
        precision cannot tell.
    """
    none = Attempt(None, pairs)
    attracts = working.model.attraction is not None
    if load.target.is_sought or attracts or not working.full_contact_is_known:
        return none
    if not load.closes and load.p0 < working.model.body.full_p_star:
        return none
    problem = working.problem(load.p0)
    nested = working.nested()
    if not load.closes and nested is not None:
        is_likely, pairs_of_coarse = nested.may_be_full(problem)
        pairs += pairs_of_coarse
        if not is_likely:
            return Attempt(None, pairs)
    g, p, certificate = closed_contact(problem, dual=criterion.duality)
    pairs += certificate.pairs
    tension, rounding = tension_of(problem.grid, p)
    is_doubtful = abs(tension) <= ROUNDING * problem.rounding
    if is_doubtful and problem.dtype != np.float64 and not load.closes:
        return Attempt(None, pairs)
    if load.closes or (is_doubtful and tension >= 0):
        problem = working.problem(load.p0 + tension + rounding)
        g, p, certificate = closed_contact(problem, dual=criterion.duality)
        pairs += certificate.pairs
    if load.closes:
        load.target.p0 = problem.p0
    if certificate.contact - certificate.yielded < problem.grid.N:
        return Attempt(None, pairs)
    exact = replace(certificate, errors=(0.0, 0.0, full_contact_error(problem)))
    contact = contact_of(
        working, load, criterion, problem.p0, g, p, "converged", exact, pairs=pairs
    )
    return Attempt(contact, pairs)
