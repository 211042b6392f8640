"""Which precision can hold the numbers of a contact.

A field is stored in single precision if its largest value stays finite and the rounding error of
its typical value is a normal number; units beyond double precision are refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import DTypeLike

from ..util.errors import SceneError

if TYPE_CHECKING:
    from . import Surface

# of what the program multiplies: units of pressure and height, their product, mean pressures
FACTORS = 1e-250, 1e250
LARGEST_P_STAR = 1e100


def fits(dtype: DTypeLike, smallest: float, largest: float) -> bool:
    """Whether a dtype holds all numbers between two magnitudes (> 0) as normal numbers."""
    info = np.finfo(dtype)
    return float(info.tiny) < smallest and largest < float(info.max)


def field_dtype(name: str, dtype: DTypeLike, p_mean: float, surface: Surface) -> np.dtype:
    """Return the dtype to store a field in the scene's units, double if `dtype` cannot hold it.
    Bounds: N p_mean for pressures (double if not above 0), N for heights of rms slope 1, N^2 for
    displacements.
    """
    of_pressure = name == "pressure"
    N = surface.grid.N
    typical = p_mean if of_pressure else surface.height_unit
    smallest = float(np.finfo(np.float32).eps) * typical
    held = fits(dtype, smallest, typical * N if of_pressure else typical * N**2)
    return np.dtype(dtype if held else np.float64)


def single_solves(p_star: float, N: int) -> bool:
    """Whether single precision holds the pressures at p_star > 0, and squares of larger ones."""
    return fits(np.float32, float(np.finfo(np.float32).eps) * p_star, (N * max(p_star, 1.0)) ** 2)


def require_range(E_star: float, surface: Surface, pressures: Sequence[float]) -> None:
    """Raise SceneError unless double precision holds the program's units and these pressures."""
    unit = E_star * surface.g_rms if surface.g_rms > 0 else 1.0
    for quantity, value in [
        ("E_star*g_rms", unit),
        ("g_rms*a (height per point)", surface.height_unit),
        ("E_star*g_rms^2*a (energy)", unit * surface.height_unit),
        *(("a mean pressure", p_mean) for p_mean in pressures),
    ]:
        smallest, largest = FACTORS
        if not smallest <= value <= largest:
            raise SceneError(
                f"surface, material, load: found {quantity} = {value:g}, allowed: {smallest:g} to"
                f" {largest:g}, in other units"
            )
    # of a single point that carries all what rounding errors of the heights make of the pressure
    rounding = float(np.finfo(np.float64).eps) * surface.h_rms / surface.height_unit
    smallest = rounding / surface.grid.N**0.5
    largest = LARGEST_P_STAR
    # full contact is not uniform there; coarse levels, which all points may add to, are in single
    # precision
    if surface.grid.padded:
        largest = float(np.finfo(np.float32).max) / surface.grid.N
    for p_mean in pressures:
        if surface.g_rms > 0 and not smallest <= p_mean / unit <= largest:
            raise SceneError(
                f"load: found p* = {p_mean / unit:g}, allowed: {smallest:.2g} to {largest:.2g}"
            )
