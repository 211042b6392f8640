"""The rms slope g(q) of all roughness up to q, and integrals over it: all of a spectrum that
Persson's theory needs. Spectra are chains of power laws, in which g(q) and its inverse are
elementary.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import exprel

from ..util.errors import SceneError
from .checks import within

# panel width in ln g: the sharpest features of the integrands have a width of about 0.05
_STEP = 0.25
# the integrand falls at least like g towards small g: exp(-42) is below double precision
_TAIL = 42.0
_FINEST = 14  # halvings of the last panel, for large pressures where only g -> g_rms contributes
_SAMPLES = 1000  # of a spectrum that is a function
Function = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class SlopeProfile:
    """g(q)/g_rms of a spectrum of power laws between q_0 < ... < q_m: y and g2 (m+1) are
    ln(q_i/q_0) and (g(q_i)/g_rms)^2; in piece i d(g2)/dy = exp(beta_i (y-y_i))/inverse_rate_i.
    """

    y: np.ndarray
    g2: np.ndarray
    beta: np.ndarray
    inverse_rate: np.ndarray
    q_min: float
    g_rms: float
    h_rms: float

    @classmethod
    def self_affine(cls, hurst: float, eps_f: float) -> Self:
        """Return the profile of C ~ q^(-2-2H), q_l <= q <= q_l/eps_f, in units q_l = g_rms = 1."""
        hurst = float(within("hurst", hurst, 0, 1))
        decades = -np.log(float(within("eps_f", eps_f, 1e-100, 1)))  # ln(q_s/q_l)
        # h_rms^2 = int exp(-2H y) dy, g_rms^2 = int exp((2-2H) y) dy, finite for H = 0, H = 1,
        # eps_f = 1 too
        g2 = exprel((2 - 2 * hurst) * decades)
        return cls(
            y=np.array([0, decades]),
            g2=np.array([0.0, 1.0]),
            beta=np.array([2 - 2 * hurst]),
            inverse_rate=np.array([decades * g2]),
            q_min=1.0,
            g_rms=1.0,
            h_rms=float(np.sqrt(exprel(-2 * hurst * decades) / g2)),
        )

    @classmethod
    def from_spectrum(cls, q: ArrayLike, C: Any, area: float = 1.0) -> Self:
        """Return the profile of C at increasing q, by power laws; a function is sampled at 1000
        more q (error 1000^-4). h_rms^2 = area/(2 pi)^2 int C d^2q.
        """
        q = within("q", q, 0, np.inf, open_low=True)
        if q.ndim != 1 or q.size < 2 or np.any(np.diff(q) <= 0):
            raise SceneError(
                "q: found no strictly increasing list, allowed: at least two increasing wave"
                " vectors"
            )
        function: Function | None = C if callable(C) else None
        if function:
            q = np.unique(np.concatenate([q, np.geomspace(q[0], q[-1], _SAMPLES + 1)[1:-1]]))
            C = function(q)
        C = within("C", C, 0, np.inf, open_low=True)
        if C.shape != q.shape:
            raise SceneError(f"C: found shape {C.shape}, allowed: the shape of q, {q.shape}")
        area = float(within("area", area, 0, np.inf, open_low=True))

        y = np.log(q / q[0])
        width = np.diff(y)
        steepness = np.diff(np.log(C)) / width  # C ~ q^steepness in a piece

        def moment(power: int) -> np.ndarray:
            """Return area/(2 pi) int q^power C dy of every piece, shape (m-1,)."""
            if function:
                integrals = _piece_integral(function, power, q, width)
            else:
                integrals = C[:-1] * q[:-1] ** power * width * exprel((steepness + power) * width)
            return integrals * area / (2 * np.pi)

        beta = steepness + 4
        slopes = moment(4)
        g2 = np.concatenate([[0], np.cumsum(slopes)])
        rate = slopes / (width * exprel(beta * width))
        return cls(
            y,
            g2 / g2[-1],
            beta,
            g2[-1] / rate,
            q_min=float(q[0]),
            g_rms=float(np.sqrt(g2[-1])),
            h_rms=float(np.sqrt(moment(2).sum())),
        )

    def integrate(self, p_star: ArrayLike, kernel: Function, power: int) -> np.ndarray:
        """Integrate (g/g_rms)^power (q_0/q) kernel(x) d ln g, x = sqrt(2) p_star g_rms/g, for each
        load. The kernel vanishes beyond x = 28 if power = 1, is bounded if power = 2.
        """
        loads = np.clip(np.asarray(p_star, dtype=float), 1e-300, 1e200)
        log_g, y, weight = self._nodes
        weight = weight * np.exp(power * log_g - y)
        x = np.sqrt(2) * np.exp(-log_g)
        integrals = [kernel(load * x) @ weight for load in loads.ravel()]  # one by one: memory
        return np.array(integrals).reshape(loads.shape)

    def _log_g_at(self, y: float) -> float:
        """Return ln(g(q)/g_rms) at y = ln(q/q_0) > 0; 0 for a profile of a single wave vector."""
        i = min(int(np.searchsorted(self.y, y, side="right")), self.beta.size) - 1
        d = y - self.y[i]
        grown = d * exprel(self.beta[i] * d) / self.inverse_rate[i] if d > 0 else 1.0
        return 0.5 * np.log(self.g2[i] + grown)

    @cached_property
    def _nodes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Gauss-Legendre points over ln g: ln(g/g_rms), ln(q/q_0), weights, down to where functions
        that fall like g are below double precision. Do not change.
        """
        low = self._log_g_at(min(1.0, self.y[-1])) - _TAIL
        with np.errstate(divide="ignore"):
            corners = 0.5 * np.log(self.g2)
        inside = corners[(corners > low) & (corners < 0)]
        panels = np.arange(-_STEP, low, -_STEP)
        fine = -_STEP * 0.5 ** np.arange(_FINEST)
        edges = np.unique(np.concatenate([panels, fine, [low, 0], inside]))
        s, w = np.polynomial.legendre.leggauss(16)
        middle, half = ((edges[1:] + sign * edges[:-1])[:, None] / 2 for sign in (1, -1))
        i = np.clip(np.searchsorted(corners, middle, side="right") - 1, 0, self.beta.size - 1)
        log_g = middle + half * s
        z = np.maximum((np.exp(2 * log_g) - self.g2[i]) * self.inverse_rate[i], 0)
        flat = np.abs(self.beta[i]) < 1e-300
        beta = np.where(flat, 1.0, self.beta[i])
        d = np.where(flat, z, np.log1p(np.maximum(beta * z, -1 + 1e-16)) / beta)
        return log_g.ravel(), (self.y[i] + d).ravel(), (half * w).ravel()


def _piece_integral(C: Function, power: int, q: np.ndarray, width: np.ndarray) -> np.ndarray:
    """Return int q^power C d(ln q) over every piece from q[i] to q[i+1], of `width` in ln q."""
    s, w = np.polynomial.legendre.leggauss(4)
    inside = q[:-1, None] * np.exp(width[:, None] * (s + 1) / 2)
    return (inside**power * C(inside) @ w) * width / 2
