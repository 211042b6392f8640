"""What a load is to give in place of a given mean pressure, and what cannot be had."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..util.errors import SceneError
from ..util.quantities import format_quantity

if TYPE_CHECKING:
    from ..surface import Surface
    from .wall import Wall


@dataclass(frozen=True)
class Prescribed:
    """What a load is to give. quantity: "gap_mean", "a_r" or "approach"; value: in the scene's
    units."""

    quantity: str
    value: float

    @property
    def closes(self) -> bool:
        """Whether that is full contact."""
        return self.quantity == "a_r" and self.value == 1


def prescribed(
    name: str, values: Sequence[float], surface: Surface, wall: Wall, resolution: float
) -> tuple[Prescribed, ...]:
    """Prescribed loads from the key of a scene's [load] and its values; wall: of the surface;
    resolution: least length over the largest height that rounding errors leave as accurate as
    asked. A gap of 0 is full contact. Raises SceneError for what cannot be had."""
    if name == "a_r":
        for value in values:
            if value * surface.grid.N < 0.5:
                raise SceneError(
                    f"load.a_r: found {value:g}, less than half of one of {surface.grid.N} points, "
                    f"allowed: {1 / surface.grid.N:.3g} to 1"
                )
        return tuple(Prescribed(name, float(value)) for value in values)
    unit = surface.h_rms if name == "gap_over_h_rms" else 1.0
    largest, gap = wall.top * surface.slope / unit, name != "approach"
    for value in values:
        if gap and not value < largest:
            raise SceneError(
                f"load.{name}: found {format_quantity(value)}, allowed: below"
                f" {format_quantity(largest, value)}, where the highest peak touches"
            )
        if 0 < value < resolution * largest:
            raise SceneError(
                f"load.{name}: found {format_quantity(value)}, allowed: above"
                f" {format_quantity(resolution * largest, value)}, what rounding errors leave"
            )
    return tuple(
        (
            Prescribed("gap_mean" if gap else name, float(value) * unit)
            if value
            else Prescribed("a_r", 1.0)
        )
        for value in values
    )
