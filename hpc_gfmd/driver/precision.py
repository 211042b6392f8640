"""Whether a load needs double precision, and whether its certificate does.

Rounding errors of the heights, of the transforms, and of points that single precision cannot tell
apart are compared with the accuracy asked for. With precision = "auto" a sweep begins with
`first_precision`, and goes on in double for good once a load `needs_double`.
"""

from __future__ import annotations

import math
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from ..bodies.halfspace import HALF_SPACE
from ..operators.problem import ROUNDING
from ..surface import ByHeights
from ..surface.number_range import single_solves
from .full_contact import tension_of
from .target import DISTINCT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..contact.contact import Contact
    from ..operators.problem import Problem
    from ..scene import LoadTable, SolverTable
    from ..surface import Precision, Surface
    from .contact_model import ContactModel
    from .target import Target
    from .working_surface import WorkingSurface

DOUBLE = np.dtype(np.float64)
# Limits of single precision, measured on the true errors of the campaign. They cost or save time
# only: a load that single precision cannot solve stagnates and is solved again in double precision.
FINEST = 2e-4  # accuracy that is tried in single; below it indistinguishable heights spoil the area
FEW_POINTS = 6  # number of points that single precision may put into the wrong set
# Largest rounding error of transforms, over the pressure error that the accuracy allows, with which
# a certificate may be in single precision.
NOISE = 0.2


# -- of a load


def initial_dtype(settings: SolverTable, share: float = 1.0) -> np.dtype:
    """Return the precision that settings try first, for a share of the accuracy; "auto": single
    from an accuracy of 2e-4 on.
    """
    if settings.precision != "auto":
        return np.dtype({"single": np.float32, "double": np.float64}[settings.precision])
    loose = settings.accuracy is not None and share * settings.accuracy >= FINEST
    return np.dtype(np.float32 if loose else np.float64)


def first_precision(
    settings: SolverTable, model: ContactModel, table: LoadTable | None
) -> Precision:
    """Return the precision of the first surface of a sweep; if single is tried, by the first load
    of the table and the heights, which are then not made twice.
    """
    dtype = initial_dtype(settings)
    stays = settings.precision != "auto" or settings.low_memory
    if table is None or stays or dtype == DOUBLE:
        return dtype

    def by_heights(surface: Surface) -> np.dtype:
        p_star, *_ = p_stars_of(table, model.E_star, surface.g_rms, surface.sizes)
        if is_unloaded(p_star, model.attraction) or surface.g_rms == 0:
            return dtype
        return DOUBLE if _single_fails_on(surface, model, settings, p_star) else dtype

    return ByHeights(by_heights)


def needs_double(
    working: WorkingSurface,
    target: Target,
    gap: np.ndarray | None = None,
    solved: tuple[Contact, Problem] | None = None,
) -> bool:
    """Return whether a load has to go on in double precision, by what is known of it so far: its
    target, the gap to start from, its contact in single with its problem. Collective.
    """
    if working.settings.precision != "auto" or working.dtype == DOUBLE:
        return False
    if target.needs_double or (gap is not None and gap.dtype == DOUBLE):
        return True
    if solved is not None and _is_spoilt(*solved, target):
        return True
    return _single_fails_on(working.surface, working.model, working.settings, target.half_area)


def _is_spoilt(contact: Contact, problem: Problem, target: Target) -> bool:
    """Return whether rounding errors spoil a contact: it stagnated, is not finite, has a mean gap
    or (if closed) a tension below them. Collective.
    """
    if contact.status in ("stagnated", "nonfinite") or contact.gap_is_rounding:
        return True
    if target.closes or contact.contact_points < contact.N:
        return False
    tension, _ = tension_of(contact.grid, contact.p)
    return tension > -DISTINCT * problem.rounding


def _single_fails_on(
    surface: Surface, model: ContactModel, settings: SolverTable, p_star: float | None
) -> bool:
    """Return `single_fails` for a load of a model on a surface."""
    h_rms = surface.h_rms / surface.height_unit
    hardness = (model.hardness or inf) / (model.E_star * surface.slope)
    return single_fails(settings, surface.grid.N, p_star, h_rms, hardness)


def single_fails(
    settings: SolverTable, N: int, p_star: float | None, h_rms: float, hardness: float
) -> bool:
    """Return whether single precision certainly does not suffice for a load: by p_star, if it is
    known, or because the heights are stored too roughly for a hardness (over E* g_rms).

    h_rms: over g_rms times the grid spacing.
    """
    accuracy = settings.accuracy
    if accuracy is not None and rounding_in_single(h_rms) > accuracy * hardness:
        return True
    if p_star is None:
        return False
    return too_few_points(N, p_star, accuracy) or not single_solves(p_star, N)


def is_unloaded(p_star: float | None, attraction: object | None) -> bool:
    """Return whether there is nothing to solve at a load: no pressure and no attraction."""
    return p_star == 0 and attraction is None


def too_few_points(N: int, p_star: float, accuracy: float | None) -> bool:
    """Return whether too few points touch at p_star for the area in single precision, which may
    misplace a few; True if p_star <= 0, False without an accuracy.
    """
    if p_star <= 0:
        return True
    expected = N * min(1.0, 2 * p_star)  # a_r is about 2 p*
    return accuracy is not None and FEW_POINTS / expected > accuracy


def rounding_in_single(h_rms: float) -> float:
    """Return the rms pressure error, over E* g_rms, of heights in single; h_rms: over g_rms a."""
    return ROUNDING * float(np.finfo(np.float32).eps) * h_rms


def p_stars_of(
    load: LoadTable, E_star: float, g_rms: float | None, sizes: Sequence[float]
) -> list[float | None]:
    """Return p* of each load, half of a prescribed area; None for gaps, approaches, and pressures
    without `g_rms`.
    """
    name, values = load.prescribed
    if name == "p_star":
        return list(values)
    if name == "a_r":
        return [value / 2 for value in values]
    if load.is_searched or not g_rms:
        return [None] * len(values)
    unit = E_star * g_rms
    return [p / unit for p in load.p0(unit, 1.0, math.prod(sizes))]


# -- of a certificate


def certificate_dtype(working: WorkingSurface, problem: Problem) -> np.dtype:
    """Return the precision of a load's certificate: double if rounding looks like pressure out of
    contact, where transforms are noisy, few points touch or few are open.

    With low memory only noise counts, and not for bodies whose K takes a table.
    """
    if working.saves_memory:
        spoils = not working.model.body.table_share and _is_noisy(working, problem)
    elif problem.p0 <= 0:  # only with an attraction: how many touch is unknown
        spoils = True
    else:
        few_touch = too_few_points(problem.grid.N, problem.p0, working.settings.accuracy)
        few_are_open = problem.p0 >= HALF_SPACE.full_p_star
        spoils = few_touch or few_are_open or _is_noisy(working, problem)
    return DOUBLE if spoils else working.dtype


def _is_noisy(working: WorkingSurface, problem: Problem) -> bool:
    """Return whether transforms' rounding exceeds a share of the allowed pressure error."""
    noise = problem.noise(working.surface.h_rms / working.surface.height_unit)
    return noise > NOISE * pressure_that_counts(working.settings, problem.p0)


def pressure_that_counts(settings: SolverTable, p_star: float) -> float:
    """Return the rms pressure error, over E* g_rms, that the accuracy allows: residual p_star or
    accuracy sqrt(p_star) (0 without one).
    """
    if settings.residual:
        return settings.residual * p_star
    return (settings.accuracy or 0.0) * max(p_star, 0.0) ** 0.5
