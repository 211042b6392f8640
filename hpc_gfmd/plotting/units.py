"""What pictures are scaled with: units with SI prefixes where a result knows them, otherwise what
makes numbers dimensionless."""

from dataclasses import dataclass
from math import isfinite
from typing import Any

from ..output.read import Result
from ..util.quantities import prefixed


def good(value: Any) -> bool:
    """A finite positive number."""
    return isinstance(value, int | float) and isfinite(value) and value > 0


@dataclass(frozen=True)
class Scale:
    """Numbers over `unit`; name: of an absolute unit ("MPa"), or the formula of a relative one
    ("E^* \\bar{g}"), or "" for neither."""

    unit: float
    name: str = ""
    relative: bool = False

    @property
    def _formula(self) -> str:
        return f"({self.name})" if " " in self.name else self.name

    def label(self, symbol: str, power: int = 1) -> str:
        """Of an axis: "$p$ (MPa)" or "$p/(E^* \\bar{g})$"; power: of the unit, not below 1."""
        if not self.name:
            return f"${symbol}$"
        raised = "" if power == 1 else f"^{{{power}}}"
        if not self.relative:
            return f"${symbol}$ ({self.name}{f'${raised}$' if raised else ''})"
        return f"${symbol}/{self._formula}{raised}$"

    def density_label(self, symbol: str, power: int = 1) -> str:
        """Of a density over it: "$P(p)$ (1/MPa)" or "$P(p) \\cdot E^*$"."""
        raised = f"^{power}" if power > 1 else ""
        if not self.relative:
            return f"${symbol}$" + (
                f" (1/{self.name}{f'${raised}$' if raised else ''})" if self.name else ""
            )
        return f"${symbol} \\cdot {self._formula}{raised}$"

    def value(self, symbol: str, number: float) -> str:
        """ "$p = 20$ MPa"."""
        over = f"/{self._formula}" if self.relative else ""
        name = "" if self.relative else self.name
        return f"${symbol}{over} = {number / self.unit:.3g}$ {name}".rstrip()


class Units:
    """Of a Result: absolute where it has units and `dimensionless` does not say otherwise."""

    def __init__(self, result: Result, theory: Any = None, dimensionless: bool = False) -> None:
        surface = result.surface
        self.length_unit, self.pressure_unit = (
            "" if dimensionless else surface.get(unit, "") for unit in ("unit", "pressure_unit")
        )
        self.size = surface.get("physical_sizes", (1.0, 1.0))[0]
        self.height_scale = (
            theory.height
            if theory and theory.height
            else Scale(surface.get("h_rms") or 0.0, r"\bar{h}", True)
        )
        slope = surface.get("g_rms")
        moduli = [
            step["p"] / step["p_star"] / slope
            for step in result.steps
            if good(slope) and good(step.get("p_star")) and good(step.get("p"))
        ]
        self.rough = surface.get("kind", "self-affine") not in ("wave", "sphere")
        name, factor = (r"E^* \bar{g}", slope) if self.rough else ("E^*", 1.0)
        self.pressure_scale = Scale(moduli[0] * factor, name, True) if moduli else Scale(1.0)

    def lengths(self, values: Any = ()) -> Scale:
        """Of positions."""
        return (
            _absolute(values or [self.size], self.length_unit)
            if self.length_unit
            else Scale(self.size, "L_x", True)
        )

    def heights(self, values: Any) -> Scale:
        """Of gaps and heights."""
        if self.length_unit:
            return _absolute(values, self.length_unit)
        return self.height_scale if good(self.height_scale.unit) else Scale(1.0)

    def pressures(self, values: Any) -> Scale:
        """Of pressures."""
        return _absolute(values, self.pressure_unit) if self.pressure_unit else self.pressure_scale

    def of(self, name: str, values: Any) -> Scale:
        """Of a field by its name."""
        return self.pressures(values) if name == "pressure" else self.heights(values)


def _absolute(values: Any, unit: str) -> Scale:
    factor, name = prefixed(values, unit)
    return Scale(factor, name.replace("u", "µ", 1) if name.startswith("u") else name)
