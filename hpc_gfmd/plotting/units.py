"""Scales of pictures: units with SI prefixes, or factors that make numbers dimensionless."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite
from typing import Any

from ..output.result import Result
from ..util.quantities import prefixed


def good(value: Any) -> bool:
    """Whether a value is a finite positive number."""
    return finite(value) and value > 0


def finite(value: Any) -> bool:
    """Whether a value is a finite int or float."""
    return isinstance(value, int | float) and isfinite(value)


def tex_number(x: float, form: str = ".3g") -> str:
    """Return a number as TeX, with an exponent as a power of ten.

    Parameters
    ----------
    x : float
    form : str
        Format of the number.

    Returns
    -------
    str
        Without dollar signs.
    """
    mantissa, _, exponent = f"{x:{form}}".partition("e")
    factor = "" if mantissa == "1" else rf"{mantissa} \cdot "
    return f"{factor}10^{{{int(exponent)}}}" if exponent else mantissa


@dataclass(frozen=True)
class Scale:
    """A unit by which numbers are divided, and how axes name it.

    Attributes
    ----------
    unit : float
        Numbers are divided by it.
    name : str
        An absolute unit, such as "MPa", or the formula of a relative one, such as "E^* g"; "" if
        there is none.
    relative : bool
        Whether the name is a formula.
    """

    unit: float = 1.0
    name: str = ""
    relative: bool = False

    def label(self, symbol: str, power: int = 1) -> str:
        """Return the label of an axis, such as "$p$ (MPa)" or "$p/E^*$".

        Parameters
        ----------
        symbol : str
            In TeX.
        power : int
            Power of the unit.

        Returns
        -------
        str
        """
        return label(symbol, (self, power))

    def value(self, symbol: str, number: float) -> str:
        """Return an equation such as "$p = 20$ MPa" or, of a relative unit, "$p/E^* = 0.2$".

        Parameters
        ----------
        symbol : str
            In TeX.
        number : float
            In the unit of the result; it is divided by `unit`.

        Returns
        -------
        str
        """
        name = "" if self.relative else self.name
        left = label(symbol, (self, 1)).split("$")[1]
        return f"${left} = {tex_number(number / self.unit)}$ {name}".rstrip()


def label(symbol: str, *scales: tuple[Scale, int]) -> str:
    """Return the label of an axis whose unit is a product: "$P(p)$ (MPa$^{-1}$)", "$q L_x$".

    Parameters
    ----------
    symbol : str
        In TeX.
    *scales : (Scale, int)
        Factors of the unit and their powers.

    Returns
    -------
    str
    """
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

    Parameters
    ----------
    result : Result
    theory : Theory, optional
        Its `height` is the scale of heights if these have no unit; default: h_rms.
    dimensionless : bool
        Whether to ignore the units of the result.

    Attributes
    ----------
    size : float
        L_x, in the unit of the result.
    rough : bool
        Whether the surface is rough: p* has a meaning, and pressures scale with E* g_rms.
    """

    def __init__(self, result: Result, theory: Any = None, dimensionless: bool = False) -> None:
        surface = result.surface
        length, pressure = (
            "" if dimensionless else surface.get(unit, "") for unit in ("unit", "pressure_unit")
        )
        self.size = surface.get("physical_sizes", (1.0, 1.0))[0]
        self.rough = surface.get("kind", "self-affine") not in ("wave", "sphere")
        h_rms = Scale(surface.get("h_rms") or 0.0, r"h_\mathrm{rms}", True)
        slope = surface.get("g_rms")
        unit = (
            step["p"] / step["p_star"] / (1.0 if self.rough else slope)
            for step in result.steps
            if good(slope) and good(step.get("p_star")) and good(step.get("p"))
        )
        name = r"E^* g_\mathrm{rms}" if self.rough else "E^*"
        self._scales = {
            "length": (length, Scale(self.size, "L_x", True)),
            "pressure": (pressure, Scale(next(unit, 0.0), name, True)),
            "height": (length, (theory and theory.height) or h_rms),
            "force": ("N" if length and pressure else "", Scale(0.0, "", True)),
        }

    def of(self, name: str, values: Iterable[Any]) -> Scale:
        """Return the scale of numbers of one kind.

        Parameters
        ----------
        name : str
            "length" (positions), "pressure" or "force"; any other name means heights and gaps.
        values : iterable
            Numbers in the unit of the result, which decide the prefix.

        Returns
        -------
        Scale
            With unit 1 and no name if neither a unit nor a relative scale is known.
        """
        unit, relative = self._scales.get(name, self._scales["height"])
        if unit:
            factor, name = prefixed(values, unit)
            return Scale(factor, name.replace("u", "µ"))
        return relative if good(relative.unit) else Scale()
