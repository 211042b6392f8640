"""What an attraction (laws/) adds at one point. `law`: a named tuple, in the precision of the
fields, whose class says what is compiled in; None leaves these calls out.
"""

from math import factorial

import numpy as np
from numba import types
from numba.extending import overload

from .jit import FASTMATH, inline

SQUARINGS = 6  # exp(-x) is exp(-x/64) squared six times
FARTHEST = 2.0**SQUARINGS  # exp(-64) = 2e-28 counts as nothing
TERMS = {types.float32: 8, types.float64: 14}  # of the polynomial of exp(-y), y from 0 to 1

_options = {
    "nogil": True,
    "error_model": "numpy",
    "fastmath": FASTMATH,
    "_nrt": False,
    "forceinline": True,
}


def decay(x):
    """Return exp(-x), x >= 0, by a polynomial on vectors; in kernels at least exp(-64) = 2e-28."""
    return np.exp(-np.asarray(x))


@overload(decay, jit_options=_options)
def _decay(x):
    real = np.float32 if x == types.float32 else np.float64
    middle, zero = real(0.5), real(0)
    terms = TERMS[types.float32 if x == types.float32 else types.float64]
    # the Taylor series of exp(-y) about the middle of its range, highest power first
    series = tuple(real(np.exp(-0.5) * (-1) ** k / factorial(k)) for k in reversed(range(terms)))
    step, farthest = real(1 / FARTHEST), real(FARTHEST)

    def implement(x):
        y = min(max(x, zero), farthest) * step - middle
        value = zero
        for c in series:
            value = value * y + c
        value *= value
        value *= value
        value *= value
        value *= value
        value *= value
        value *= value
        return value

    return implement


def energy_at(law, g):
    """Return the energy per area phi of the attraction at a gap >= 0. Only kernels can call it."""


def traction_at(law, g):
    """Return the attraction t = phi' at a gap >= 0. Only kernels can call it."""


def curvature_at(law, g):
    """Return the second derivative phi'' of the energy at a gap >= 0. Only kernels can call it."""


def _overloaded(stub, method):
    """Make numba compile a method of the law's class where a kernel calls `stub`."""

    def implementation(law, g):
        function = inline(getattr(law.instance_class, method))
        real = np.float32 if g == types.float32 else np.float64
        return lambda law, g: real(function(law, g))

    overload(stub, jit_options=_options)(implementation)


_overloaded(energy_at, "energy")
_overloaded(traction_at, "traction")
_overloaded(curvature_at, "curvature")
