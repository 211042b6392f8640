"""What pictures are scaled with, and what Persson's theory may be told about a result."""

import tomllib
from math import isfinite

from ..output.read import Result


def good(value) -> bool:
    """A finite positive number."""
    return isinstance(value, int | float) and isfinite(value) and value > 0


def pressure_unit(step: dict) -> tuple[float, str]:
    """(E* g_rms, its label); (1, "") where it is not known, as for a flat surface."""
    if good(step.get("p_star")) and good(step.get("p")):
        return step["p"] / step["p_star"], r"E^* \bar{g}"
    return 1.0, ""


def gap_unit(surface: dict) -> tuple[float, str]:
    """(h_rms, its label); (1, "") for a flat surface."""
    return (surface["h_rms"], r"\bar{h}") if good(surface.get("h_rms")) else (1.0, "")


def over(symbol: str, unit: str) -> str:
    """Axis label of a quantity in some unit: p/(E* g_rms)."""
    if not unit:
        return f"${symbol}$"
    return f"${symbol}/({unit})$" if " " in unit else f"${symbol}/{unit}$"


def self_affine(result: Result) -> tuple[float, float] | None:
    """(hurst, eps_f) of a self-affine surface without roll-off, whose gap the theory knows; else None."""
    try:
        surface = tomllib.loads(result.scene_toml).get("surface", {})
        hurst, eps_f = surface.get("hurst"), result.surface.get("eps_f")
    except (tomllib.TOMLDecodeError, AttributeError):
        return None
    if not isinstance(hurst, int | float) or not good(eps_f) or surface.get("lam_l_over_lam_r", 1) != 1:
        return None
    return float(hurst), float(eps_f)
