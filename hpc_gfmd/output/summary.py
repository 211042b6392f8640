"""One-line descriptions of loads and surfaces; numbers with their significant digits."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import floor, inf, isfinite, isnan, log10, nan
from typing import Any, TypeGuard

import numpy as np

from ..scene import each
from ..theory.steepness import gap_by_pressure, pressure_by_area
from ..util.quantities import prefixed

DIGITS = 4  # of a number without an error estimate
MAX_DIGITS = 6
FINE = ("converged", "separated")  # statuses
HELD_GAPS = ("target_gap_mean", "target_gap_over_h_rms")
HELD_AREA = "target_a_r"
LENGTHS = (*HELD_GAPS, "target_approach")  # of held loads
AREA = "a_r_error", "a_r_discretisation"
AREA_NUMBERS = "a_r", "a_r_corrected", "a_r_discretisation", "a_r_error"
TOO_LARGE = ("a_r", "contact_area", "kappa")  # by what points at the edge of the contact add
TOO_SMALL = ("contact_pressure_mean",)  # the load over such an area
CORRECTION_ERROR = 0.35  # of the edge correction: refined walls had 0.65 to 1.3 times of it
# Error of a critical gap by the grid, over g_rms times the spacing. Measured on 604 channels of
# random and self-affine walls: half of the errors are below 0.03, 1 in 100 above 0.3.
AT_SADDLES = 0.3
GAP = "gap_error", "gap_discretisation"
GAPS = ("gap_mean", "gap_over_h_rms", "gap_over_g_rms_lam_s")
ERRORS = {  # relative errors of a number by the solver and by the grid
    "a_r": AREA,
    "contact_area": AREA,
    "kappa": AREA,
    "contact_pressure_mean": AREA,
    "contact_pressure_max": ("pressure_error", "pressure_max_discretisation"),
    **dict.fromkeys(GAPS, GAP),
    "p": ("p_error", ""),
}


def summary(step: dict, surface: dict) -> str:
    """Return the most important numbers of a load in a line, as "a_r = 6.7 +- 0.6 %, ..."."""
    parts = []
    if step.get("a_r") is not None:
        text = f"a_r = {estimate(100 * step['a_r'], 'a_r', step)} %"
        if (corrected := step.get("a_r_corrected")) is not None:
            text += f" (corrected {estimate(100 * corrected, 'a_r_corrected', step)} %)"
        parts.append(text)
    for name, key, unit in (("p", "p", "pressure_unit"), ("mean gap", "gap_mean", "unit")):
        if step.get(key) is not None:
            scale, unit = prefixed([step[key]], surface.get(unit, ""))
            value = estimate(step[key] / scale, key, step if _tells_error(key, step) else {})
            parts.append(f"{name} = {value} {unit}".strip())
    if isfinite(step.get("p_star", nan)):
        parts.append(f"p* = {step['p_star']:.{DIGITS}g}")
    parts.append(step["status"] if converged(step) else f"NOT CONVERGED ({step['status']})")
    return ", ".join(parts) + (f"; note: {step['note']}" if step.get("note") else "")


def _tells_error(name: str, step: dict) -> bool:
    """Whether a line without a legend may show an error: not that of a gap by the solver alone."""
    is_held = any(target in step for target in HELD_GAPS)
    return name != "gap_mean" or is_held or is_number(step.get("gap_discretisation"))


def surface_line(surface: dict) -> str:
    """Return one line on a surface by its attributes: points, sizes, roughness, ..."""
    unit = surface["unit"] if isinstance(surface.get("unit"), str) else ""

    def lengths(values: list[float], digits: int) -> str:
        """Return lengths as text with a common unit, such as "1 x 2 um"."""
        scale, name = prefixed(values, unit)
        return f"{' x '.join(f'{value / scale:.{digits}g}' for value in values)} {name}".strip()

    parts = []
    if points := _numbers(surface.get("n")):
        parts.append(" x ".join(f"{n:.0f}" for n in points) + " points")
    if sizes := _numbers(surface.get("physical_sizes")):
        parts.append(f"L = {lengths(sizes, 4)}")
    if height := _numbers([surface.get("h_rms")]):
        parts.append(f"h_rms = {lengths(height, DIGITS)}")
    for name in ("hurst", "g_rms", "eps_t", "eps_f", "eps_c"):
        if _numbers([surface.get(name)]):
            parts.append(f"{name} = {surface[name]:.{DIGITS}g}")
    if surface.get("prepared"):
        parts += map(str, each(surface["prepared"]))
    if isinstance(surface.get("seed"), int) and surface["seed"] >= 0:  # other surfaces have none
        parts.append(f"seed = {surface['seed']}")
    return ", ".join(parts)


def converged(step: dict) -> bool:
    """Whether a load step has reached the scene's accuracy; separated bodies count as converged."""
    return step.get("status") in FINE


def last_held(steps: Sequence[dict]) -> dict | None:
    """Return the last converged step before the bodies separate, at prescribed gaps or approaches
    that with the largest pull until then; None if none separates them.
    """
    for number, (before, after) in enumerate(pairwise(steps), 1):
        if after.get("status") == "separated" and before.get("status") == "converged":
            if not any(name in after for name in LENGTHS):
                return before
            held = [step for step in steps[:number] if step.get("status") == "converged"]
            return min(held, key=lambda step: step["p"])
    return None


def pull_off_bracket(steps: Sequence[dict]) -> tuple[float, float] | None:
    """Return mean pressures of `last_held` and the first load that separates; None if none does,
    and at prescribed gaps or approaches.
    """
    held = last_held(steps)
    if held is None or any(name in held for name in LENGTHS):
        return None
    apart = steps[steps.index(held) + 1]
    return float(held["p"]), float(apart["p"])


def pull_off_line(steps: Sequence[dict], surface: dict) -> str:
    """Return a line on the pull-off of a sweep, as pressure and as force; "" if there is none."""
    held = last_held(steps)
    if held is None:
        return ""
    pressures = pull_off_bracket(steps) or (float(held["p"]),)
    sizes = _numbers(surface.get("physical_sizes"))
    unit = surface.get("pressure_unit", "")
    texts = [_between(pressures, unit)]
    if len(sizes) == 2:
        forces = [pressure * sizes[0] * sizes[1] for pressure in pressures]
        texts.append(_between(forces, "N" if unit and surface.get("unit") else ""))
    means = "held and lost" if len(pressures) == 2 else "largest pull"
    return f"pull-off ({means}): pressure {', force '.join(texts)}"


def _between(values: Sequence[float], unit: str) -> str:
    """Return one or two numbers with their unit, as "-943 to -961 kPa"."""
    scale, name = prefixed(values, unit)
    return f"{' to '.join(f'{value / scale:.{DIGITS}g}' for value in values)} {name}".strip()


def with_error(value: float, relative: float | None, above: float | None = None) -> str:
    """Return a value with its error, as "0.0160 +- 0.0002" or, with another relative error `above`,
    "20.8 +0.1 -1.9"; the larger is rounded to one digit.
    """
    if not isfinite(value):
        return str(value)
    if not relative or not value:
        return f"{value:.{DIGITS}g}" + (" +- 0" if relative == 0 else "")
    largest = relative if above is None else max(relative, above)
    if not isfinite(largest):
        return f"{value:.{DIGITS}g} +- ?"
    error = abs(value * largest)
    place = floor(log10(abs(value)))  # of the leading digit
    scale = 0 if -4 <= place <= 5 else place
    smallest = place - MAX_DIGITS + 1
    last_digit = max(smallest, floor(log10(error)))
    decimals = max(0, scale - min(last_digit, place))
    shown = f"{value / 10.0**scale:.{decimals}f}"

    def rounded(error: float) -> str:
        text = f"{error / 10.0**scale:.{decimals}f}"
        return text if float(text) else "0"

    if above is not None:
        bars = f"+{rounded(abs(value) * above)} -{rounded(abs(value) * relative)}"
    elif error >= 10.0**last_digit:
        bars = f"+- {rounded(error)}"
    else:
        bars = f"+- {error / 10.0**scale:.0e}"
    return f"{shown} {bars}" if scale == 0 else f"({shown} {bars})e{scale:+03d}"


def estimate(value: float, name: str, step: dict) -> str:
    """Return a number of a step in the shown unit with its error on known sides: an area is too
    large by points at its edge, a load over it too small.
    """
    below, above = error_bars(name, step) or (None, None)
    return with_error(value, below, None if above == below else above)


def error_bars(name: str, step: dict) -> tuple[float, float] | None:
    """Return relative errors, too large by and too small by, of a number, or None; p/a_r may be too
    small by more than a_r is too large.
    """
    if name == "p" and HELD_AREA in step:
        return _bars_of_held_pressure(step)
    error = combined_error(name, step)
    if error is None:
        return None
    area_errors = _area_errors(step) if name in TOO_LARGE + TOO_SMALL else None
    area_above = error if area_errors is None else sum(area_errors[1:])
    bars = error, area_above
    if name in TOO_SMALL:
        bars = area_above / (1 + area_above), error / (1 - error) if error < 1 else inf
    return _bars_at_held_area(name, step, bars) if HELD_AREA in step else bars


def _bars_of_held_pressure(step: dict) -> tuple[float, float] | None:
    """Return the bars of the pressure at a prescribed area: those of the area, the other way round;
    inf at full contact.
    """
    of_area = error_bars("a_r", {key: value for key, value in step.items() if key != HELD_AREA})
    per_area = pressure_by_area(step.get("a_r") or 0.0)
    if of_area is None or not isfinite(per_area):
        return of_area and (inf, inf)
    return of_area[1] * per_area, of_area[0] * per_area


def _bars_at_held_area(name: str, step: dict, bars: tuple[float, float]) -> tuple[float, float]:
    """Return the bars of a number that changes with the pressure which the area needs."""
    below, above = _bars_of_held_pressure(step) or (0.0, 0.0)
    if name == "contact_pressure_mean":
        return max(bars[0], below), max(bars[1], above)
    if name in ("kappa", "kappa_corrected"):
        return max(bars[0], above), max(bars[1], below)
    if name in GAPS:
        of_heights = step.get("gap_over_h_rms")
        per_pressure = gap_by_pressure(of_heights) if is_positive(of_heights) else inf
        return bars[0] + _times(per_pressure, above), bars[1] + _times(per_pressure, below)
    return bars


def _times(steepness: float, error: float) -> float:
    """Return their product, 0 of an infinite steepness without an error."""
    return steepness * error if error else 0.0


def _area_errors(step: dict) -> tuple[float, float, float] | None:
    """Return relative errors of a_r: edge correction, random by the grid, solver's; or None."""
    area, corrected, of_grid, of_solver = map(
        float, _numbers([step.get(name) for name in AREA_NUMBERS]) or [nan] * len(AREA_NUMBERS)
    )
    if isnan(corrected) or not area:
        return None
    edge = 1 - corrected / area
    return edge, max(of_grid - edge, 0.0), of_solver


def combined_error(name: str, step: dict) -> float | None:
    """Return the relative error by solver and grid, or None. A prescribed gap has none by the grid,
    but its pressure; a_r_corrected what the correction leaves.
    """
    if name in ("a_r_corrected", "kappa_corrected"):
        area_errors = _area_errors(step)
        if area_errors is None or not step["a_r_corrected"] > 0:
            return None
        edge, *random_and_solver = area_errors
        relative_to_a_r = CORRECTION_ERROR * edge + sum(random_and_solver)
        return relative_to_a_r * step["a_r"] / step["a_r_corrected"]
    if name in GAPS and step.get("gap_mean") == 0 and step.get("a_r_discretisation"):
        return inf  # of points that touch, and may open between them
    of_solver, of_grid = ERRORS.get(name, ("", ""))
    if any(target in step for target in HELD_GAPS):
        of_grid = {"gap_error": "", "p_error": "gap_discretisation"}.get(of_solver, of_grid)
    parts = [part for part in (step.get(of_solver), step.get(of_grid)) if is_number(part)]
    return sum(parts) if parts else None


def critical_gap_error(
    critical_gap: Any, gap_mean: Any, of_mean_gap: Any, surface: Mapping[str, Any] | None
) -> Any:
    """Return the relative error of a critical gap, a number or an array; inf for 0. of_mean_gap:
    relative error of the mean gap, whose absolute one counts; surface: its attributes, by which the
    grid misses the narrowest place of the channel; None: without that.
    """
    of_grid = 0.0
    if surface is not None:
        spacings = [L / n for L, n in zip(surface["physical_sizes"], surface["n"]) if n > 1]
        of_grid = AT_SADDLES * surface["g_rms"] * max(spacings, default=0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return (np.multiply(of_mean_gap, gap_mean) + of_grid) / critical_gap


def is_number(value: object) -> TypeGuard[float]:
    """Whether a value of a file is an int or a float (a bool, nan and inf are, too)."""
    return isinstance(value, int | float)


def is_finite(value: object) -> TypeGuard[float]:
    """Whether a value of a file is a finite int or float."""
    return is_number(value) and isfinite(value)


def is_positive(value: object) -> TypeGuard[float]:
    """Whether a value of a file is a finite positive number."""
    return is_finite(value) and value > 0


def _numbers(value: object) -> list[float]:
    """Return a list of finite numbers of a file as it is, anything else as an empty list."""
    if isinstance(value, list | tuple) and all(map(is_finite, value)):
        return list(value)
    return []
