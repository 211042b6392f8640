"""What the panels of a picture share: scales, labels, and the result with its window and theory.

A scale is a unit with an SI prefix, or a factor that makes numbers dimensionless.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from ..output.result import Result
from ..output.summary import converged, last_held
from ..util.errors import SceneError, one_line
from ..util.quantities import parse, prefixed


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


@dataclass(frozen=True)
class Theory:
    """A theory of a surface, in the units of the result. `curves`: functions of the mean pressure
    by the numbers that they predict; density(x, p), of the local pressure x > 0, integrates to a_r;
    `height`: the scale of heights, None for h_rms; `text`: the name without TeX.
    """

    name: str
    curves: dict[str, Callable]
    density: Callable | None = None
    height: Scale | None = None
    sources: tuple[str, ...] = ()
    text: str = ""


class View:
    """Load steps of a result with units, theory and window of a picture of them.

    `left_out` steps are not chosen; pull_off: last step before separation, or None; window: (x0,
    x1, y0, y1), points: (i0, i1, j0, j1), None for all; remembers: loads follow from each other;
    lengths: the Scale of positions.
    """

    def __init__(
        self,
        result: Result,
        chosen: list[int],
        theory: Theory | None,
        name: str,
        window: Any,
        dpi: float | None,
        dimensionless: bool,
    ) -> None:
        self.result = result.some(chosen)
        self.pull_off = last_held(result.steps)
        self.dpi = dpi
        self.name = name
        self.left_out = len(result.steps) - len(chosen)
        self.window, self.points = window_of(result.surface, window)
        self.theory = theory
        scene = result.readable_scene
        self.hardness = scene.material.hardness if scene else None
        self.attracts = scene is not None and scene.material.adhesion is not None
        self.remembers = scene is not None and scene.remembers
        height = theory.height if theory else None
        self.units = Units(result.surface, result.steps, height, dimensionless)
        x0, x1, y0, y1 = self.window
        self.lengths = self.units.of("length", [x1 - x0, y1 - y0])

    def name_of(self, k: int) -> str:
        """Return the label of result.steps[k]: number, load, and a mark if not converged."""
        step = self.result.steps[k]
        name = f"step {self.result.indices[k]}"
        pressures = self.units.of("pressure", [step.get("p")])
        if self.units.rough and pressures.relative and good(step.get("p_star")):
            name += f": $p^* = {step['p_star']:.3g}$"
        elif good(step.get("p")):
            name += f": {pressures.value('p_0', step['p'])}"
        doubt = f"\nNOT CONVERGED ({step.get('status', 'unknown')})"
        return name + ("" if converged(step) else doubt)


def window_of(surface: Any, window: Any) -> tuple:
    """Return a window at edges of grid points, and its points (i0, i1, j0, j1); None for all."""
    sizes = np.array(surface.get("physical_sizes", (1.0, 1.0)))
    n = np.array(surface["n"])
    if window is None:
        return (0.0, sizes[0], 0.0, sizes[1]), None
    try:
        low, high = np.reshape([_length(edge) for edge in window], (2, 2)).T
        inside = np.all((0 <= low) & (low < high) & (high <= sizes * (1 + 1e-9)))
    except (TypeError, ValueError):
        inside = np.False_
    if not inside:
        text = " ".join(map(str, window)) if isinstance(window, list | tuple) else str(window)
        L_x, L_y = (f"{size:g} {surface.get('unit', '')}".rstrip() for size in sizes)
        raise SceneError(
            f"window: found {one_line(text)}, allowed: x0 x1 y0 y1 with 0 <= x0 < x1 <= {L_x} and"
            f' 0 <= y0 < y1 <= {L_y}, plain or as "2um"'
        )
    start = np.minimum((low / sizes * n + 1e-9).astype(int), n - 1)
    stop = np.clip(np.ceil(high / sizes * n - 1e-9).astype(int), start + 1, n)
    points = np.transpose([start, stop])
    return tuple((points * (sizes / n)[:, None]).ravel()), tuple(points.ravel().tolist())


def _length(edge: Any) -> float:
    """Return a length, a number or a text such as "5 um", as a number; units become m."""
    try:
        return float(edge)
    except ValueError:
        return float(parse(edge, "length"))
