"""Notes on loads, moduli and slopes that suggest a mistake in the units."""

DIFFERENT_UNITS = "are probably in different units"
NO_MODULUS = "no modulus is given: E_star = 1 is taken, and pressures are in units of E*"
SMALL_SLOPE = 1.0 + 1e-6  # 1 itself has rounding errors
REAL_SLOPES = (1e-5, 30.0)  # of measured surfaces
OVERLOAD = 10.0  # mean pressure over E*


def slope_notes(g_rms: float, measured: bool) -> list[str]:
    """Return notes on an rms slope that is too large, or too small for a measured surface.

    Parameters
    ----------
    g_rms : float
        Rms slope, without a unit.
    measured : bool
        Whether the surface was measured; a synthetic one may have any small slope.

    Returns
    -------
    list of str
        Empty, or one note.
    """
    low, high = REAL_SLOPES
    if g_rms > high or (measured and 0 < g_rms < low):
        return [f"g_rms = {g_rms:.2g}: heights and sizes {DIFFERENT_UNITS}"]
    steep = g_rms > SMALL_SLOPE
    return [f"g_rms = {g_rms:.3g}: the theory is that of small slopes"] if steep else []


def load_notes(p_mean: float, E_star: float, g_rms: float, unit: str) -> list[str]:
    """Return notes on a missing modulus and on a load that is far too large.

    Parameters
    ----------
    p_mean, E_star : float
        Mean pressure and contact modulus, in the same unit. E_star = 1 counts as missing if the
        heights have a unit.
    g_rms : float
        Slope of the surface.
    unit : str
        Unit of the heights, "" if they have none.

    Returns
    -------
    list of str
        Empty if nothing is wrong.
    """
    notes = [NO_MODULUS] if unit and E_star == 1 else []
    if p_mean > OVERLOAD * E_star * max(g_rms, 1.0):
        notes.append(f"p = {p_mean / E_star:.2g} E*: loads and moduli {DIFFERENT_UNITS}")
    return notes
