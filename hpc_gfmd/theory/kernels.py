"""The functions of x = sqrt(2) p0/(E* g(q)) under the integrals of Persson's theory.

With a = erf(x), the contact area seen at the resolution q, the elastic energy of a mode is the
fraction W(a) = gamma a + (1 - gamma) a^3 of its energy in full contact.
"""

from functools import cache

import numpy as np
from numpy.polynomial import Chebyshev
from scipy.special import erf, exp1

X_ZERO = 28.0  # exp(-x^2) and E1(x^2) are 0 in double precision from here on
_X_ONE = 6.0  # beyond it erf(x) = 1 in double precision
_SECOND_TERM = {False: 6.0, True: 3.0}  # corrected, as printed


def energy_fraction(x: np.ndarray, gamma: float) -> np.ndarray:
    """Return W(erf x), the elastic energy of a mode over that in full contact (eq. gamma)."""
    a = erf(x)
    return a * (gamma + (1 - gamma) * a * a)


def gap_kernel(x: np.ndarray, gamma: float, printed: bool) -> np.ndarray:
    """Return F(x) = gamma E1(x^2) + c (1-gamma) int_1^inf erf(tx)^2 exp(-t^2 x^2) dt/t, x > 0, to
    1e-12.

    c is 6, or 3 if `printed`, as in the published equation, where E1(x^2) = 2 int_1^inf exp(-t^2
    x^2) dt/t was used in the first term only.
    """
    return gamma * exp1_of_square(x) + _SECOND_TERM[printed] * (1 - gamma) * erf2_integral(x)


def compliance_kernel(x: np.ndarray, gamma: float, printed: bool) -> np.ndarray:
    """Return -x dF/dx = exp(-x^2) (2 gamma + c (1-gamma) erf(x)^2), which gives -p d(gap)/dp."""
    x = np.minimum(x, X_ZERO)
    return np.exp(-x * x) * (2 * gamma + _SECOND_TERM[printed] * (1 - gamma) * erf(x) ** 2)


def exp1_of_square(x: np.ndarray) -> np.ndarray:
    """Compute E1(x^2) for x > 0, also if x^2 underflows; x > 28 is taken as 28."""
    x = np.minimum(x, X_ZERO)
    small = x < 1e-9
    return np.where(small, -np.euler_gamma - 2 * np.log(x), exp1(np.where(small, 1.0, x * x)))


def erf2_integral(x: np.ndarray) -> np.ndarray:
    """Compute I(x) = int_x^inf erf(v)^2 exp(-v^2) dv/v for x >= 0; x > 28 is taken as 28."""
    x = np.minimum(x, X_ZERO)
    low = np.exp(-x * x) * _scaled()(np.minimum(x, _X_ONE))
    return np.where(x < _X_ONE, low, exp1(np.maximum(x, _X_ONE) ** 2) / 2)


@cache
def _scaled() -> Chebyshev:
    """Return the interpolant of exp(x^2) erf2_integral(x) on [0, 6], by a smooth integral over E1:
    erf(v)^2 = 1 - (4/pi) int_0^1 exp(-v^2 (1+s^2)) ds/(1+s^2).
    """
    s, w = np.polynomial.legendre.leggauss(24)
    s2 = ((s + 1) / 2) ** 2
    w = w / 2

    def scaled(x: np.ndarray) -> np.ndarray:
        x2 = x * x
        inner = exp1(x2[:, None] * (2 + s2)) @ (w / (1 + s2))
        return np.exp(x2) * (exp1(x2) / 2 - 2 / np.pi * inner)

    return Chebyshev.interpolate(scaled, 80, [0, _X_ONE])
