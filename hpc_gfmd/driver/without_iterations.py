"""Contacts that need no iteration: of a flat surface, in full contact, and pulled apart."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..certificate.certificate import Certificate
from ..certificate.error_estimates import full_contact_error
from ..contact.contact import Contact
from .full_contact import CLOSED, closed_contact, tension_of
from .nested import undeformed_gap

if TYPE_CHECKING:
    from ..certificate.criterion import StoppingCriterion
    from .load import Load
    from .working_surface import WorkingSurface

EXACT = (0.0, 0.0, 0.0)  # errors of area, mean gap and pressure


class Attempt(NamedTuple):
    """What came of a load in one precision.

    Attributes
    ----------
    contact : Contact or None
        The solution; None where another way has to be taken.
    pairs : float
        All FFT pairs that the load has taken.
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
    """Return what a load has come to.

    Parameters
    ----------
    working : WorkingSurface
        The surface.
    load : Load
        What was asked for.
    criterion : StoppingCriterion
        What the solution had to reach.
    p0 : float
        Its mean pressure, in the program's unit.
    g, p : ndarray
        Its gap and pressure, local slabs of the grid.
    status : str
        See `Contact`.
    certificate : Certificate
        Of the gap.
    iterations : int
    pairs : float
        That the load has taken.

    Returns
    -------
    Contact
        Its mean pressure is as it was given, where it was, without rounding errors of the unit.
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
        remark=load.note,
        iterations=iterations,
        pairs=float(pairs),
        hardness=model.hardness,
        attraction=model.attraction,
    )


def flat_contact(working: WorkingSurface, load: Load, criterion: StoppingCriterion) -> Contact:
    """Return the contact of a flat surface, which is closed at any load.

    Parameters
    ----------
    working : WorkingSurface
        The surface.
    load : Load
        A pressure.
    criterion : StoppingCriterion
        What the solution has to reach.

    Returns
    -------
    Contact
        Without errors.
    """
    g = np.zeros_like(working.surface.gap)
    p = np.full_like(g, load.value / working.model.E_star)
    certificate = Certificate(contact=working.surface.grid.N, errors=EXACT, duality_gap=0.0)
    return contact_of(working, load, criterion, load.value, g, p, "converged", certificate)


def separated_contact(
    working: WorkingSurface, load: Load, criterion: StoppingCriterion, iterations: int, pairs: float
) -> Contact:
    """Return what is left where the load pulls more than the attraction: undeformed bodies.

    Parameters
    ----------
    working : WorkingSurface
        The surface.
    load : Load
        That pulls.
    criterion : StoppingCriterion
        What the solution had to reach.
    iterations : int
    pairs : float
        That the load has taken.

    Returns
    -------
    Contact
        Without contact.
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
    """Return the contact where u = -h is the solution.

    The load that closes the gap is known then, also where points yield. Collective.

    Parameters
    ----------
    working : WorkingSurface
        The surface.
    load : Load
        Whose mean pressure is given, or which is to close the gap.
    criterion : StoppingCriterion
        What the solution has to reach.
    pairs : float
        FFT pairs that the load has taken so far.

    Returns
    -------
    Attempt
        Without a contact where u = -h is not the solution.
    """
    none = Attempt(None, pairs)
    attracts = working.model.attraction is not None
    if load.search is not None or attracts or not working.full_contact_is_known:
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
    is_doubtful = abs(tension) <= CLOSED * problem.rounding
    if is_doubtful and problem.dtype != np.float64 and not load.closes:
        return Attempt(None, pairs)
    if load.closes or (is_doubtful and tension >= 0):
        problem = working.problem(load.p0 + tension + rounding)
        g, p, certificate = closed_contact(problem, dual=criterion.duality)
        pairs += certificate.pairs
    if load.closes:
        load.given_p0 = problem.p0
    if certificate.contact - certificate.yielded < problem.grid.N:
        return Attempt(None, pairs)
    exact = replace(certificate, errors=(0.0, 0.0, full_contact_error(problem)))
    contact = contact_of(
        working, load, criterion, problem.p0, g, p, "converged", exact, pairs=pairs
    )
    return Attempt(contact, pairs)
