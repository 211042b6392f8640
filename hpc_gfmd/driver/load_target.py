"""What a load is to give in place of a given mean pressure, and what cannot be had."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..util.errors import SceneError
from ..util.quantities import format_quantity

if TYPE_CHECKING:
    from ..solvers.base import Solver
    from ..surface import Surface


@dataclass(frozen=True)
class LoadTarget:
    """What a load is to give. quantity: "gap_mean", "a_r" or "approach"; value: in the scene's
    units."""

    quantity: str
    value: float


def load_targets(
    name: str, values: Sequence[float], surface: Surface, top: float, resolution: float
) -> tuple[LoadTarget, ...]:
    """Targets from the key of a scene's [load] and its values; top: mean gap where the highest peak
    just touches; resolution: least length over it that rounding errors leave as accurate as asked.
    A gap of 0 is an area of 1. Raises SceneError for what cannot be had."""
    if name == "a_r":
        for value in values:
            if value * surface.grid.N < 0.5:
                raise SceneError(
                    f"load.a_r: found {value:g}, less than half of one of {surface.grid.N} points, "
                    f"allowed: {1 / surface.grid.N:.3g} to 1"
                )
        return tuple(LoadTarget(name, float(value)) for value in values)
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
