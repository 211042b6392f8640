"""Yielding points: the proximal map against a brute-force minimum of a point's energy."""

import numpy as np
import pytest

from hpc_gfmd.kernels.jit import kernel
from hpc_gfmd.kernels.yielding import at_contact, landing, limit, yields

H = 0.7
LENGTH = 0.4


@kernel
def called(g, p, v, length, hardness):
    yielded = yields(g, p, hardness, 0.0, 1.0)
    return limit(hardness, 0.0), yielded, landing(v, yielded, length, hardness, 0.0)


@kernel
def is_at_contact(w, g, d, hardness):
    return at_contact(w, g, d, hardness, 0.0)


def test_no_point_yields_without_a_hardness():
    assert called(0.0, 5.0, -2.0, LENGTH, None) == (0.0, 0.0, 0.0)
    assert called(0.0, 5.0, 2.0, LENGTH, None) == (0.0, 0.0, 2.0)


@pytest.mark.parametrize(
    ("g", "p", "yielded"),
    [(0.0, 0.5, 0), (0.0, 0.7, 1), (0.0, 0.9, 1), (-0.1, 0.2, 1), (0.2, 0.9, 0), (0.0, -1.0, 0)],
)
def test_which_points_yield(g, p, yielded):
    assert called(g, p, 0.0, LENGTH, H)[:2] == (H, yielded)


@pytest.mark.parametrize("p", [0.3, 1.2])
@pytest.mark.parametrize("r", [-3.0, -0.5, -0.2, 0.0, 0.1, 0.25, 0.5, 2.0])
def test_landing_is_a_proximal_map(p, r):
    """w minimises (w - g + length p)^2/(2 length) + H max(-w, 0) for g = 0.

    v is the end of the step with r, the pressure less H where the point yields.
    """
    _, yielded, _ = called(0.0, p, 0.0, LENGTH, H)
    v = -LENGTH * r
    _, _, w = called(0.0, p, v, LENGTH, H)
    pressure = r + yielded * H  # total pressure of a step with this r
    candidates = np.linspace(-3, 3, 600001)
    energy = (candidates + LENGTH * pressure) ** 2 / (2 * LENGTH) + H * np.maximum(-candidates, 0)
    assert w == pytest.approx(candidates[energy.argmin()], abs=2e-5)


@pytest.mark.parametrize(
    ("w", "g", "d", "hardness", "closed"),
    [
        (0.0, 0.5, -0.4, None, True),
        (0.1, 0.5, -0.4, None, False),
        (0.1, 0.5, -0.5, None, True),  # by rounding of the step
        (0.0, 0.5, -0.4, H, True),
        (-0.2, 0.5, -0.7, H, False),
        (-0.1, -0.5, 0.5, H, True),
        (-0.1, -0.5, 0.4, H, False),
    ],
)
def test_at_contact(w, g, d, hardness, closed):
    assert bool(is_at_contact(w, g, d, hardness)) is closed
