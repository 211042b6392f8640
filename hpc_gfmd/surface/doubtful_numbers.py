"""Notes on loads, moduli and slopes that suggest a mistake in the units."""

from ..util.errors import SurfaceWarning

DIFFERENT_UNITS = "are probably in different units"
NO_MODULUS = "no modulus is given: E_star = 1 is taken, and pressures are in units of E*"
SMALL_SLOPE = 1.0 + 1e-6  # 1 itself has rounding errors
REAL_SLOPES = (1e-5, 30.0)  # of measured surfaces
OVERLOAD = 10.0  # mean pressure over E*


def slope_notes(g_rms: float, measured: bool) -> list[SurfaceWarning]:
    """Return a note on an rms slope that is too large, or too small for a measured surface."""
    low, high = REAL_SLOPES
    if g_rms > high or (measured and 0 < g_rms < low):
        return [SurfaceWarning(f"g_rms = {g_rms:.2g}: heights and sizes {DIFFERENT_UNITS}")]
    if g_rms > SMALL_SLOPE:
        return [SurfaceWarning(f"g_rms = {g_rms:.3g}: the theory is that of small slopes")]
    return []


def modulus_notes(E_star: float, unit: str) -> list[SurfaceWarning]:
    """Return a note if the heights have a unit and E_star = 1, which counts as missing."""
    return [SurfaceWarning(NO_MODULUS)] if unit and E_star == 1 else []


def load_notes(p_mean: float, E_star: float, g_rms: float) -> list[SurfaceWarning]:
    """Return a note on a mean pressure, in the unit of E_star, that is far too large."""
    if p_mean > OVERLOAD * E_star * max(g_rms, 1.0):
        return [SurfaceWarning(f"p = {p_mean / E_star:.2g} E*: loads and moduli {DIFFERENT_UNITS}")]
    return []
