"""Notes on numbers that suggest a mistake: wrong units, and stand-ins for missing heights."""

from collections.abc import Sequence

import numpy as np

from ..util.errors import SurfaceWarning

DIFFERENT_UNITS = "are probably in different units"
NO_MODULUS = "no modulus is given: E_star = 1 is taken, and pressures are in units of E*"
SMALL_SLOPE = 1.0 + 1e-6  # 1 itself has rounding errors
REAL_SLOPES = (1e-5, 30.0)  # of measured surfaces
OVERLOAD = 10.0  # mean pressure over E*
FAR_AWAY = 100.0  # of a single point from all others, over the range of these


def slope_notes(g_rms: float, measured: bool) -> list[SurfaceWarning]:
    """Return a note on an rms slope that is too large, or too small for a measured surface."""
    low, high = REAL_SLOPES
    if g_rms > high or (measured and 0 < g_rms < low):
        return [SurfaceWarning(f"g_rms = {g_rms:.2g}: heights and sizes {DIFFERENT_UNITS}")]
    if g_rms > SMALL_SLOPE:
        return [SurfaceWarning(f"g_rms = {g_rms:.3g}: the theory is that of small slopes")]
    return []


def stand_in_notes(z: np.ndarray, missing: Sequence[float] = ()) -> list[SurfaceWarning]:
    """Return a note on a whole number that several points of a map as it is read have in common,
    further from all others than these from each other, or a single one, far further: it may stand
    for missing points, unless it is known to.
    """
    lowest = np.fmin.reduce(z, axis=None)
    highest = np.fmax.reduce(z, axis=None)
    if not np.isfinite([lowest, highest]).all():
        return []
    for number in (lowest, highest):
        is_other = z != number
        low = float(np.fmin.reduce(z, axis=None, where=is_other, initial=highest))
        high = float(np.fmax.reduce(z, axis=None, where=is_other, initial=lowest))
        apart = max(low - float(lowest), float(highest) - high)
        count = np.count_nonzero(z == number)
        is_known = float(number) in missing or not float(number).is_integer()
        is_single = count == 1
        distance = FAR_AWAY if is_single else 1.0
        if not is_known and high > low and apart > distance * (high - low):
            text = f"{number:.15g}"
            if float(text) != number:
                text = repr(float(number))
            note = (
                f"{count} {'point is' if is_single else 'points are'} {text}, all others {low:g} to"
                f" {high:g}: does it stand for missing heights? It is pressed as a height;"
                f' missing = ["{text}"] and fill = "harmonic" replace it'
            )
            return [SurfaceWarning(note)]
    return []


def modulus_notes(E_star: float, unit: str) -> list[SurfaceWarning]:
    """Return a note if the heights have a unit and E_star = 1, which counts as missing."""
    return [SurfaceWarning(NO_MODULUS)] if unit and E_star == 1 else []


def load_notes(p_mean: float, E_star: float, g_rms: float) -> list[SurfaceWarning]:
    """Return a note on a mean pressure, in the unit of E_star, that is far too large."""
    if p_mean > OVERLOAD * E_star * max(g_rms, 1.0):
        return [SurfaceWarning(f"p = {p_mean / E_star:.2g} E*: loads and moduli {DIFFERENT_UNITS}")]
    return []
