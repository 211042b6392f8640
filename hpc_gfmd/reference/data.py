"""The data file of the reference curves, read and interpolated."""

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np

from ..errors import SceneError

FORMAT = "hpc-gfmd reference 2"
QUANTITIES = ("a_r", "gap_over_h_rms")
ROUNDING = 1e-9  # relative, by which a number may miss the end of its range


@dataclass(frozen=True)
class Reference:
    """Contact area and mean gap of self-affine surfaces in large cells and on fine grids.

    hurst (m,), eps_f (k,): those that were solved; p_star: {quantity: (loads,)}; value, sigma: {quantity: (m, k, loads)}, means and
    their relative standard uncertainties; provenance: what it was made of.
    """

    hurst: np.ndarray
    eps_f: np.ndarray
    p_star: dict[str, np.ndarray]
    value: dict[str, np.ndarray]
    sigma: dict[str, np.ndarray]
    provenance: dict

    def at(self, quantity, p_star, hurst, eps_f):
        """(value, standard uncertainty) of one of QUANTITIES at p_star (number or array), hurst and eps_f (numbers).

        Interpolated is the logarithm of the ratio to Persson's theory, which varies little: by splines along ln p_star and hurst and a
        parabola along ln eps_f. The uncertainty is that of the points in between which it lies. Raises SceneError outside their ranges.
        """
        from scipy.interpolate import make_interp_spline

        if quantity not in QUANTITIES:
            raise SceneError(f"quantity: found {quantity!r}, allowed: {', '.join(QUANTITIES)}")
        loads, wanted = self.p_star[quantity], np.asarray(p_star, dtype=np.float64)
        wanted = _within("p_star", wanted, loads)
        weights = np.outer(_weights(_within("hurst", hurst, self.hurst), self.hurst),
                           _weights(np.log(_within("eps_f", eps_f, self.eps_f)), np.log(self.eps_f)))
        ratio = [[np.log(value / _persson(quantity, loads, H, f)) for f, value in zip(self.eps_f, values, strict=True)]
                 for H, values in zip(self.hurst, self.value[quantity], strict=True)]
        ratio, sigma = np.einsum("hf,hfp->p", weights, ratio), np.einsum("hf,hfp->p", np.abs(weights), self.sigma[quantity])
        x = np.log(loads)
        value = np.exp(make_interp_spline(x, ratio, k=min(3, len(x) - 1))(np.log(wanted))) * _persson(quantity, wanted, hurst, eps_f)
        error = value * np.interp(np.log(wanted), x, sigma)
        return (value, error) if wanted.ndim else (float(value), float(error))


def _within(name, wanted, known):
    low, high = float(np.min(known)), float(np.max(known))
    wanted = np.asarray(wanted, dtype=np.float64)
    if not np.all((wanted >= low * (1 - ROUNDING)) & (wanted <= high * (1 + ROUNDING))):
        raise SceneError(f"{name}: found {wanted.tolist()}, allowed: from {low:g} to {high:g}")
    return np.clip(wanted, low, high)


def _weights(x, known):
    """How much of each known point the spline (at most of degree 3) through them has at x."""
    from scipy.interpolate import make_interp_spline

    order = np.argsort(known)
    found = np.empty(len(known))
    found[order] = make_interp_spline(known[order], np.eye(len(known)), k=min(3, len(known) - 1))(x) if len(known) > 1 else 1.0
    return found


def _persson(quantity, p_star, hurst, eps_f):
    from ..theory import persson

    return persson.contact_area(p_star) if quantity == "a_r" else persson.mean_gap(p_star, float(hurst), float(eps_f))


def load(path=None):
    """The Reference of a data file; None: the one shipped with the package. Raises SceneError if it is not one."""
    return _shipped() if path is None else _read(Path(path))


@cache
def _shipped():
    return _read(files(__package__).joinpath("data/contact.json"))


def _read(path):
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        if data["format"] != FORMAT:
            raise ValueError(f"format {data['format']!r}")
        axes = [_array(data[name]) for name in ("hurst", "eps_f")]
        tables = [{name: _array(data[name][kind]) for name in QUANTITIES} for kind in ("p_star", "value", "sigma")]
        for name in QUANTITIES:
            shape = (*(len(axis) for axis in axes), len(tables[0][name]))
            if not tables[1][name].shape == tables[2][name].shape == shape or not (tables[1][name] > 0).all():
                raise ValueError("arrays of different lengths, or values that are not positive")
        return Reference(*axes, *tables, data["provenance"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        allowed = "a JSON file written by hpc-gfmd study curves --reference"
        raise SceneError(f"reference: found {str(path)!r} ({error}), allowed: {allowed}") from None


def _array(numbers):
    array = np.array(numbers, dtype=np.float64)
    array.setflags(write=False)  # shared by all who load it
    return array
