"""The sides of points that certificates and solvers tell apart, in NumPy."""

import numpy as np


def sides(g, p, hardness):
    """Sort points by gap and pressure.

    Parameters
    ----------
    g, p : array
        Gap, negative in dents, and pressure.
    hardness : float or None

    Returns
    -------
    closed : array of bool
        Points in elastic contact.
    yields : array of bool
        Points that yield.
    r : array
        Pressure, less the hardness where a point yields.
    """
    if hardness is None:
        yields = np.zeros(g.shape, bool)
        r = p.copy()
    else:
        yields = (g < 0) | ((g <= 0) & (p >= hardness))
        r = p - yields * hardness
    closed = (g <= 0) & (p > 0) & ~yields
    return closed, yields, r
