"""The leak rate of a seal from the narrowest place of its widest channel."""

import numpy as np
from numpy.typing import ArrayLike

from ..util.errors import SceneError
from .checks import within


def leak_rate(
    critical_gap: ArrayLike,
    viscosity: float,
    pressure_drop: float,
    width: float | None = None,
    length: float | None = None,
) -> np.ndarray:
    """Estimate the volume per time that leaks through a seal, Q = (w/l) g_c^3 dp/(12 eta).

    Parameters
    ----------
    critical_gap : float or array_like
        g_c, the gap at the narrowest place of the widest channel through the seal
        (`critical_gap_x`), in m; 0 if the seal is tight.
    viscosity : float
        eta of the fluid, in Pa s.
    pressure_drop : float
        dp of the fluid over the seal, in Pa.
    width, length : float, optional
        Extent of the seal across and along the flow, both or neither; only their ratio matters.
        Default: a square seal.

    Returns
    -------
    float or ndarray
        In m^3/s; 0 where critical_gap is 0.

    Raises
    ------
    SceneError
        If a number is out of range, or only one of width and length is given.

    Notes
    -----
    Theory of the critical junction (Persson, Yang, J. Phys.: Condens. Matter 20 (2008) 315011):
    nearly all of the pressure drops at the narrowest place of the widest channel, which is taken as
    square. It is right to an order of magnitude, and best close to the load at which the seal is
    tight; at light loads, where many channels are open side by side, it is too small, and effective
    medium theories or Reynolds' equation on the gap (`examples/leak.py`) are better.
    """
    gap = within("critical_gap", critical_gap, 0, np.inf)
    eta = within("viscosity (Pa s)", viscosity, 0, np.inf, open_low=True)
    drop = within("pressure_drop", pressure_drop, 0, np.inf)
    squares = 1.0  # side by side
    if width is not None and length is not None:
        across = within("width", width, 0, np.inf, open_low=True)
        along = within("length", length, 0, np.inf, open_low=True)
        squares = across / along
    elif width is not None or length is not None:
        found = "a length" if width is None else "a width"
        raise SceneError(f"width, length: found {found} alone, allowed: both, or neither")
    return squares * gap**3 * drop / (12 * eta)
