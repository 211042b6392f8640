"""The loads that a scene prescribes, and the refusal of those that are impossible."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..surface.number_range import require_range, single_solves
from ..util.errors import SceneError
from ..util.quantities import format_quantity
from .load import Load

if TYPE_CHECKING:
    from ..scene import LoadTable
    from ..solvers.base import Solver
    from ..surface import Surface
    from .working_surface import WorkingSurface

FLAT_HAS_NONE = ("p_star", "gap_mean", "gap_over_h_rms", "a_r")
LENGTHS = 100.0  # rounding error of a gap or an approach, over that of the largest height


def loads_of(table: LoadTable, working: WorkingSurface, solver: type[Solver]) -> list[Load]:
    """Return a scene's loads in order, without searches; a mean gap of 0 is an area of 1.
    Collective. SceneError for what surface, precision, pressure or solver does not allow.
    """
    name, values = table.prescribed
    surface = working.surface
    E_star = working.model.E_star
    has_none = name in FLAT_HAS_NONE or (name == "approach" and working.is_flat)
    if surface.g_rms == 0 and has_none:
        raise SceneError(f"load.{name}: found a flat surface (g_rms = 0), allowed: load.pressure")
    pressures = table.p0(E_star, surface.g_rms, float(np.prod(surface.sizes)))
    require_range(E_star, surface, [abs(p_mean) for p_mean in pressures if p_mean != 0])
    if working.model.attraction is not None and working.is_flat:
        raise SceneError(
            "material.adhesion: found a flat surface (g_rms = 0), allowed: a rough one"
        )
    if working.model.attraction is not None and not solver.attracts:
        raise SceneError(
            f'solver.name: found "{solver.name}" with material.adhesion, allowed: "bpx"'
        )
    if working.model.hardness is not None:
        require_dents(solver, working.model.hardness, name, values, pressures)
    if working.settings.precision == "single" and surface.g_rms > 0:
        _require_single(pressures, E_star * surface.g_rms, surface.grid.N)
    if pressures:
        return [Load("pressure", p_mean) for p_mean in pressures]
    if name == "a_r":
        _require_areas(values, surface)
        return [Load("a_r", float(value)) for value in values]
    quantity = "approach" if name == "approach" else "gap_mean"
    unit = surface.h_rms if name == "gap_over_h_rms" else 1.0
    _require_lengths(name, quantity, values, unit, working)
    if quantity == "approach":
        return [Load(quantity, float(value)) for value in values]
    return [Load(quantity, float(value) * unit) if value else Load("a_r", 1.0) for value in values]


def _require_single(pressures: Sequence[float], unit: float, points: int) -> None:
    """Raise SceneError for a pressure that single precision cannot solve; unit: E* g_rms."""
    for p_mean in pressures:
        if p_mean > 0 and not single_solves(p_mean / unit, points):
            raise SceneError(
                'solver.precision: found "single", too little for a pressure of'
                f' {p_mean:g}, allowed: "auto", "double"'
            )


def _require_areas(values: Sequence[float], surface: Surface) -> None:
    """Raise SceneError for areas of less than half a point, or half a line (one axis only)."""
    points = surface.grid.N
    kind = "points" if points == np.prod(surface.n) else "lines"
    for value in values:
        if value * points < 0.5:
            raise SceneError(
                f"load.a_r: found {value:g}, less than half of one of {points} {kind}, "
                f"allowed: {1 / points:.3g} to 1"
            )


def _require_lengths(
    name: str, quantity: str, values: Sequence[float], unit: float, working: WorkingSurface
) -> None:
    """Raise SceneError for lengths that no pressure gives, or rounding spoils. Collective."""
    settings = working.settings
    stays = settings.precision == "single" or settings.low_memory
    rounding = float(np.finfo(working.dtype if stays else np.float64).eps)
    # the least length over the largest that rounding errors leave as accurate as asked
    resolution = LENGTHS * rounding / settings.tolerance
    # the mean gap where the highest peak just touches
    largest = working.heights.top * working.surface.slope / unit
    for index, value in enumerate(values):
        # on retraction and in a cycle the attraction may hold the bodies together beyond that
        may_be_larger = working.model.always_continues and index > 0
        if quantity == "gap_mean" and not (value < largest or may_be_larger):
            allowed = f"below {format_quantity(largest, value)}, where the highest peak touches"
        elif 0 < value < resolution * largest:
            allowed = (
                f"above {format_quantity(resolution * largest, value)}, what rounding errors leave"
            )
        else:
            continue
        raise SceneError(f"load.{name}: found {format_quantity(value)}, allowed: {allowed}")


def require_dents(
    solver: type[Solver],
    hardness: float,
    name: str,
    values: Sequence[float],
    pressures: Sequence[float],
) -> None:
    """Raise SceneError if the solver has no hardness, a pressure (unit of E_star) reaches it, or
    full contact is prescribed.
    """
    if not solver.dents:
        raise SceneError(
            f'solver.name: found "{solver.name}" with material.hardness, allowed: "bpx"'
        )
    for p_mean in pressures:
        if p_mean >= hardness:
            raise SceneError(
                f"load.{name}: found a pressure of {format_quantity(p_mean)}, allowed: below"
                f" material.hardness, {format_quantity(hardness)}"
            )
    closes = min(values) == 0 if name.startswith("gap") else name == "a_r" and max(values) == 1
    if closes:
        raise SceneError(
            f"load.{name}: found full contact, allowed with material.hardness: less, as at a"
            " pressure"
        )
