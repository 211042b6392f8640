"""The data file of the reference curves, read and interpolated."""

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import SceneError

FORMAT = "hpc-gfmd reference"
QUANTITIES = ("a_r", "a_r_edge", "gap_over_h_rms", "gap_over_g_rms_lam_s")


@dataclass(frozen=True)
class Curve:
    """One Hurst exponent and eps_f: means over some surfaces, against the load.

    Attributes
    ----------
    hurst, eps_t, eps_f, eps_c : float
        Hurst exponent; lam_l/L, lam_s/lam_l and a/lam_s of the runs.
    n : int
        Points of the runs along each axis.
    seeds : tuple of int
        The surfaces that the means are over.
    p_star : array, shape (loads,)
        p0/(E* g_rms), increasing.
    a_r, a_r_edge : array, shape (loads,)
        Relative contact area, as counted and edge-corrected.
    gap_over_h_rms, gap_over_g_rms_lam_s : array, shape (loads,)
        Mean gap in those units.
    sigma : dict
        {quantity: standard uncertainty of the mean, shape (loads,)}, from the scatter between realisations and the estimated errors of
        the solutions; that of eps_t and eps_c being finite is not in it.
    """

    hurst: float
    eps_t: float
    eps_f: float
    eps_c: float
    n: int
    seeds: tuple[int, ...]
    p_star: np.ndarray
    a_r: np.ndarray
    a_r_edge: np.ndarray
    gap_over_h_rms: np.ndarray
    gap_over_g_rms_lam_s: np.ndarray
    sigma: dict[str, np.ndarray]

    def at(self, p_star: ArrayLike, quantity: str) -> tuple[float | np.ndarray, float | np.ndarray]:
        """A quantity and its uncertainty at a load: monotone interpolation of its logarithm over that of p_star.

        Parameters
        ----------
        p_star : float or array
            p0/(E* g_rms), within the range of the curve.
        quantity : str
            One of QUANTITIES.

        Returns
        -------
        value, sigma : float or array
            In the shape of p_star.

        Raises
        ------
        SceneError
            Outside the range of p_star and for other quantities.
        """
        from scipy.interpolate import PchipInterpolator

        if quantity not in QUANTITIES:
            raise SceneError(f"quantity: found {quantity!r}, allowed: {', '.join(QUANTITIES)}")
        values = getattr(self, quantity)
        there = values > 0  # at full contact the gap has no logarithm
        x, y = np.log(self.p_star[there]), np.log(values[there])
        wanted = np.asarray(p_star, dtype=np.float64)
        low, high = self.p_star[there][[0, -1]]
        if not np.all((wanted >= low * (1 - 1e-9)) & (wanted <= high * (1 + 1e-9))):
            raise SceneError(f"p_star: found {wanted}, allowed: from {low:g} to {high:g}")
        at = np.clip(np.log(wanted), x[0], x[-1])
        relative = np.interp(at, x, self.sigma[quantity][there] / values[there])
        value = np.exp(PchipInterpolator(x, y)(at))
        return (value, value * relative) if value.ndim else (float(value), float(value * relative))


@dataclass(frozen=True)
class Reference:
    """A file of reference data.

    Attributes
    ----------
    curves : tuple of Curve
    provenance : dict
        Versions, accuracy, level, date and command of the runs behind them.
    """

    curves: tuple[Curve, ...]
    provenance: dict[str, Any]

    def curve(self, hurst: float, eps_f: float) -> Curve:
        """The curve of this Hurst exponent and eps_f. Raises SceneError for others than the tabulated ones."""
        for curve in self.curves:
            if np.isclose(curve.hurst, hurst, rtol=0, atol=1e-9) and np.isclose(curve.eps_f, eps_f, rtol=1e-6, atol=0):
                return curve
        at_hurst = sorted({f"1/{1 / c.eps_f:g}" for c in self.curves if np.isclose(c.hurst, hurst, rtol=0, atol=1e-9)})
        if at_hurst:
            raise SceneError(f"eps_f: found {eps_f:g}, allowed for hurst = {hurst:g}: {', '.join(at_hurst)}")
        raise SceneError(f"hurst: found {hurst:g}, allowed: {', '.join(sorted({f'{c.hurst:g}' for c in self.curves}))}")


def load(path: str | Path | None = None) -> Reference:
    """The Reference of the data file at path; None: the one shipped with the package. Raises SceneError if it is not one."""
    return _shipped() if path is None else _read(Path(path))


@cache
def _shipped() -> Reference:
    return _read(files(__package__).joinpath("data/contact.json"))


def _read(path: Traversable) -> Reference:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        if data["format"] != FORMAT:
            raise ValueError(f"format {data['format']!r}")
        return Reference(tuple(_curve(c) for c in data["curves"]), data["provenance"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        allowed = "a JSON file written by hpc-gfmd study --reference"
        raise SceneError(f"reference: found {str(path)!r} ({error}), allowed: {allowed}") from None


def _curve(data: dict[str, Any]) -> Curve:
    numbers = {name: np.array(data[name], dtype=np.float64) for name in ("p_star", *QUANTITIES)}
    sigma = {name: np.array(data["sigma"][name], dtype=np.float64) for name in QUANTITIES}
    for array in (*numbers.values(), *sigma.values()):
        if array.shape != numbers["p_star"].shape or not len(array):
            raise ValueError("arrays of different lengths")
        array.setflags(write=False)  # shared by all who load it
    return Curve(data["hurst"], data["eps_t"], data["eps_f"], data["eps_c"], data["n"], tuple(data["seeds"]), **numbers, sigma=sigma)
