"""Scales of pictures: units with SI prefixes, or factors that make numbers dimensionless."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any

from ..util.quantities import prefixed


def good(value: Any) -> bool:
    """Whether a value is a finite positive number."""
    return finite(value) and value > 0


def finite(value: Any) -> bool:
    """Whether a value is a finite int or float."""
    return isinstance(value, int | float) and isfinite(value)


def tex_number(x: float, form: str = ".3g") -> str:
    """Return a number in this format as TeX, with an exponent as a power of ten."""
    mantissa, _, exponent = f"{x:{form}}".partition("e")
    factor = "" if mantissa == "1" else rf"{mantissa} \cdot "
    return f"{factor}10^{{{int(exponent)}}}" if exponent else mantissa


@dataclass(frozen=True)
class Scale:
    """A unit that divides numbers, and its name: "MPa", if `relative` as "E^* g", or ""."""

    unit: float = 1.0
    name: str = ""
    relative: bool = False

    def label(self, symbol: str, power: int = 1) -> str:
        """Return the label of an axis, such as "$p$ (MPa)" or "$p/E^*$"; the symbol is in TeX."""
        return label(symbol, (self, power))

    def value(self, symbol: str, number: float) -> str:
        """Return a number as "$p = 20$ MPa" or, of a relative unit, "$p/E^* = 0.2$"."""
        name = "" if self.relative else self.name
        left = label(symbol, (self, 1)).split("$")[1]
        return f"${left} = {tex_number(number / self.unit)}$ {name}".rstrip()


def label(symbol: str, *scales: tuple[Scale, int]) -> str:
    """Return the label of an axis for factors of its unit: "$P(p)$ (MPa$^{-1}$)", "$q L_x$"."""
    above: list[str] = []
    below: list[str] = []
    units: list[str] = []
    for scale, power in scales:
        formula = f"({scale.name})" if " " in scale.name else f"{{{scale.name}}}"
        if scale.relative:
            raised = formula + (f"^{{{abs(power)}}}" if abs(power) > 1 else "")
            (below if power > 0 else above).append(raised)
        elif scale.name:
            units.append(scale.name + (f"$^{{{power}}}$" if power != 1 else ""))
    divisor = " ".join(below) if len(below) < 2 else f"({' '.join(below)})"
    formula = r" \, ".join([symbol, *above]) + (f"/{divisor}" if below else "")
    return f"${formula}$" + (f" ({' '.join(units)})" if units else "")


class Units:
    """The scales of a result: units with SI prefixes if it has units, otherwise relative ones.
    `height`: scale of heights without a unit (default: h_rms); `rough`: pressures scale with E*
    g_rms.
    """

    def __init__(
        self,
        surface: Mapping[str, Any],
        steps: Iterable[Mapping[str, Any]] = (),
        height: Scale | None = None,
        dimensionless: bool = False,
    ) -> None:
        length, pressure = (
            "" if dimensionless else surface.get(unit, "") for unit in ("unit", "pressure_unit")
        )
        self.size = surface.get("physical_sizes", (1.0, 1.0))[0]
        self.rough = surface.get("kind", "self-affine") not in ("wave", "sphere")
        h_rms = Scale(surface.get("h_rms") or 0.0, r"h_\mathrm{rms}", True)
        slope = surface.get("g_rms")
        unit = (
            step["p"] / step["p_star"] / (1.0 if self.rough else slope)
            for step in steps
            if good(slope) and good(step.get("p_star")) and good(step.get("p"))
        )
        name = r"E^* g_\mathrm{rms}" if self.rough else "E^*"
        self._scales = {
            "length": (length, Scale(self.size, "L_x", True)),
            "pressure": (pressure, Scale(next(unit, 0.0), name, True)),
            "height": (length, height or h_rms),
            "force": ("N" if length and pressure else "", Scale(0.0, "", True)),
        }

    def of(self, name: str, values: Iterable[Any]) -> Scale:
        """Return the scale of "length", "pressure", "force" or heights, prefixed for the values."""
        unit, relative = self._scales.get(name, self._scales["height"])
        if unit:
            factor, name = prefixed(values, unit)
            return Scale(factor, name.replace("u", "µ"))
        return relative if good(relative.unit) else Scale()
