"""What the loads of a scene ask for: mean pressures, or what is to be given in place of one; and
what cannot be had."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..surface.number_range import require_range, single_solves
from ..util.errors import SceneError
from ..util.quantities import format_quantity

if TYPE_CHECKING:
    from ..scene import Load
    from ..solvers.base import Solver
    from .start import Start

FLAT_HAS_NONE = ("p_star", "gap_mean", "gap_over_h_rms", "a_r")
LENGTHS = 100.0  # rounding errors of the largest height that a gap or an approach may have


@dataclass(frozen=True)
class LoadTarget:
    """What a load is to give. quantity: "gap_mean", "a_r" or "approach"; value: in the scene's
    units."""

    quantity: str
    value: float


def loads_of(load: Load, start: Start) -> Sequence[float | LoadTarget]:
    """Return what `Sweep.solve` takes for the loads of a scene: mean pressures, or LoadTarget where
    they have to be found. A gap of 0 is an area of 1. start: what the Sweep solves with.

    Raises SceneError for what a flat surface does not have, what the precision cannot hold, and
    what no pressure gives. Collective.
    """
    (name, values), surface, settings = load.given, start.surface, start.settings
    has_none = name in FLAT_HAS_NONE or (name == "approach" and start.is_flat)
    if surface.g_rms == 0 and has_none:
        raise SceneError(f"load.{name}: found a flat surface (g_rms = 0), allowed: load.pressure")
    pressures = load.p0(start.E_star, surface.g_rms, float(np.prod(surface.sizes)))
    require_range(start.E_star, surface, pressures)
    if start.hardness is not None:
        require_dents(start.solver_class, start.hardness, name, values, pressures)
    if settings.precision == "single" and surface.g_rms > 0:
        for p_mean in pressures:
            if not single_solves(p_mean / (start.E_star * surface.g_rms), surface.grid.N):
                raise SceneError(
                    'solver.precision: found "single", too little for a pressure of'
                    f' {p_mean:g}, allowed: "auto", "double"'
                )
    if pressures:
        return pressures
    if name == "a_r":
        for value in values:
            if value * surface.grid.N < 0.5:
                raise SceneError(
                    f"load.a_r: found {value:g}, less than half of one of {surface.grid.N} points, "
                    f"allowed: {1 / surface.grid.N:.3g} to 1"
                )
        return tuple(LoadTarget(name, float(value)) for value in values)
    only = settings.precision == "single" or settings.low_memory
    rounding = float(np.finfo(start.dtype if only else np.float64).eps)
    # the least length over the largest that rounding errors leave as accurate as asked
    resolution = LENGTHS * rounding / settings.tolerance
    top = start.heights.top * surface.slope  # the mean gap where the highest peak just touches
    unit = surface.h_rms if name == "gap_over_h_rms" else 1.0
    largest, quantity = top / unit, "approach" if name == "approach" else "gap_mean"
    for value in values:
        allowed = None
        if quantity == "gap_mean" and not value < largest:
            allowed = f"below {format_quantity(largest, value)}, where the highest peak touches"
        elif 0 < value < resolution * largest:
            allowed = (
                f"above {format_quantity(resolution * largest, value)}, what rounding errors leave"
            )
        if allowed:
            raise SceneError(f"load.{name}: found {format_quantity(value)}, allowed: {allowed}")
    return tuple(
        LoadTarget(quantity, float(value) * unit) if value else LoadTarget("a_r", 1.0)
        for value in values
    )


def require_dents(
    solver: type[Solver],
    hardness: float,
    name: str,
    values: Sequence[float],
    pressures: Sequence[float],
) -> None:
    """Raise SceneError where a solver cannot do with a hardness, or no pressure below it gives what
    the key of a scene's [load] asks for."""
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
    if min(values) == 0 or (name == "a_r" and max(values) == 1):
        raise SceneError(
            f"load.{name}: found full contact, allowed with material.hardness: less, as at a"
            " pressure"
        )
