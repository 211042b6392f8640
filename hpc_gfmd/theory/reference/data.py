"""The data file of the reference curves, read and interpolated."""

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline

from ...util.errors import SceneError
from .. import persson
from ..checks import within

FORMAT = "hpc-gfmd reference 2"
SHIPPED = Path(__file__).parent / "data/contact.json"
QUANTITIES = ("a_r", "gap_over_h_rms")
ROUNDING = 1e-9  # relative, by which a number may miss the end of its range


@dataclass(frozen=True)
class Reference:
    """Contact area and mean gap of self-affine surfaces in large cells and on fine grids.

    Attributes
    ----------
    hurst : array, shape (m,)
        Hurst exponents that were solved, increasing.
    eps_f : array, shape (k,)
        lam_s/lam_l that were solved, increasing.
    p_star : dict
        {quantity: p0/(E* g_rms), shape (loads,), increasing}.
    value, sigma : dict
        {quantity: shape (m, k, loads)}: means and their relative standard uncertainties.
    provenance : dict
        Command, versions, accuracy, number of runs and date.
    """

    hurst: np.ndarray
    eps_f: np.ndarray
    p_star: dict[str, np.ndarray]
    value: dict[str, np.ndarray]
    sigma: dict[str, np.ndarray]
    provenance: dict[str, Any]

    @cached_property
    def ratios(self) -> dict[str, np.ndarray]:
        """ln(value/Persson's theory) by quantity, shape (m, k, loads); computed once."""
        logarithms = {}
        for name, loads in self.p_star.items():
            theory = [[_persson(name, loads, H, f) for f in self.eps_f] for H in self.hurst]
            logarithms[name] = np.log(self.value[name] / np.array(theory))
        return logarithms

    def at(
        self, quantity: str, p_star: ArrayLike, hurst: float, eps_f: float
    ) -> tuple[float | np.ndarray, float | np.ndarray]:
        """Interpolate a quantity and its uncertainty between the tabulated points.

        The logarithm of the ratio to Persson's theory, which varies little, is interpolated by
        splines along ln p_star, hurst and ln eps_f (at most cubic, a parabola through three
        points). The uncertainty is the weighted sum of those of the points, as if all were wrong in
        the same direction.

        Parameters
        ----------
        quantity : str
            "a_r" or "gap_over_h_rms".
        p_star : float or array
            p0/(E* g_rms).
        hurst, eps_f : float
            Hurst exponent and lam_s/lam_l.

        Returns
        -------
        value, sigma : float or array
            The quantity and its absolute standard uncertainty, in the shape of p_star.

        Raises
        ------
        SceneError
            If a number is outside of the range of the data, or the quantity is unknown.
        """
        if quantity not in QUANTITIES:
            raise SceneError(f"quantity: found {quantity!r}, allowed: {', '.join(QUANTITIES)}")
        loads = self.p_star[quantity]
        wanted = _within("p_star", p_star, loads)
        weights = np.outer(
            _weights(float(_within("hurst", hurst, self.hurst)), self.hurst),
            _weights(float(np.log(_within("eps_f", eps_f, self.eps_f))), np.log(self.eps_f)),
        )
        x = np.log(loads)
        at = np.log(wanted)
        ratio = np.einsum("hf,hfp->p", weights, self.ratios[quantity])
        spline = make_interp_spline(x, ratio, k=min(3, len(x) - 1))
        value = np.exp(spline(at)) * _persson(quantity, wanted, hurst, eps_f)
        sigma = value * np.interp(
            at, x, np.einsum("hf,hfp->p", np.abs(weights), self.sigma[quantity])
        )
        return (value, sigma) if wanted.ndim else (float(value), float(sigma))


def _within(name: str, wanted: ArrayLike, nodes: np.ndarray) -> np.ndarray:
    """Return numbers clipped to the nodes' range; SceneError beyond rounding (relative 1e-9)."""
    low = float(nodes.min())
    high = float(nodes.max())
    return np.clip(within(name, wanted, low * (1 - ROUNDING), high * (1 + ROUNDING)), low, high)


def _weights(x: float, nodes: np.ndarray) -> np.ndarray:
    """Return the weights of the values at the nodes in their (at most cubic) spline at x."""
    if len(nodes) == 1:
        return np.ones(1)
    return np.asarray(make_interp_spline(nodes, np.eye(len(nodes)), k=min(3, len(nodes) - 1))(x))


def _persson(quantity: str, p_star: np.ndarray, hurst: float, eps_f: float) -> np.ndarray:
    """Compute Persson's contact area ("a_r") or mean gap over h_rms (any other quantity)."""
    return (
        persson.contact_area(p_star)
        if quantity == "a_r"
        else persson.mean_gap(p_star, float(hurst), float(eps_f))
    )


def load(path: str | Path | None = None) -> Reference:
    """Read reference curves of contact area and mean gap of self-affine surfaces.

    Parameters
    ----------
    path : path, optional
        A JSON file; default: the one shipped with the package.

    Returns
    -------
    Reference

    Raises
    ------
    SceneError
        If the file cannot be read or is not of this format.
    """
    path = Path(SHIPPED if path is None else path)
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        if data["format"] != FORMAT:
            raise ValueError(f"format {data['format']!r}")
        hurst = np.array(data["hurst"], float)
        eps_f = np.array(data["eps_f"], float)
        p_star, value, sigma = (
            {name: np.array(data[kind][name], float) for name in QUANTITIES}
            for kind in ("p_star", "value", "sigma")
        )
        for name in QUANTITIES:
            shape = len(hurst), len(eps_f), len(p_star[name])
            if not value[name].shape == sigma[name].shape == shape or not (value[name] > 0).all():
                raise ValueError("arrays of different lengths, or values that are not positive")
            if not (sigma[name] >= 0).all():
                raise ValueError("uncertainties that are not numbers from 0")
        for name, nodes in {"hurst": hurst, "eps_f": eps_f, **p_star}.items():
            is_rising = (np.diff(nodes) > 0).all()
            if not (is_rising and len(nodes) and nodes[0] >= 0 and np.isfinite(nodes[-1])):
                raise ValueError(f"numbers of {name} that do not rise")
        return Reference(hurst, eps_f, p_star, value, sigma, data["provenance"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        allowed = "a JSON file written by python scripts/paper curves --reference"
        raise SceneError(f"reference: found {str(path)!r} ({error}), allowed: {allowed}") from None
