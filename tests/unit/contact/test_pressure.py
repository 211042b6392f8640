"""Contact pressure and contact area of a solution against its fields."""

import numpy as np
import pytest
from contacts import random_heights

import hpc_gfmd


@pytest.mark.parametrize(
    "arguments",
    [
        {},
        {"boundary": "free"},
        {"hardness": 0.3},
        {"physical_sizes": (2.0, 3.0)},
        {"precision": "double"},
    ],
)
def test_numbers_follow_from_the_fields(arguments):
    z = 0.1 * random_heights((24, 32), seed=5)
    solution = hpc_gfmd.solve(z, 0.05, **arguments)
    touching = solution.pressure > 0
    assert solution.value("contact_pressure_max") == pytest.approx(solution.pressure.max())
    mean = solution.pressure[touching].mean()
    assert solution.value("contact_pressure_mean") == pytest.approx(mean, rel=2e-3)
    sizes = arguments.get("physical_sizes", (1.0, 1.0))
    assert solution.value("contact_area") == pytest.approx(touching.mean() * np.prod(sizes))


def test_hertz_pressures_of_a_ball():
    """The largest pressure is 3/2 of the mean F/(pi a^2), a^3 = 3 F R/(4 E*)."""
    n = 128
    x = (np.arange(n) + 0.5) / n - 0.5
    z = -(x[:, None] ** 2 + x**2) / 2  # R = 1
    force = 4 / 3 * 0.2**3
    solution = hpc_gfmd.solve(z, force=force, boundary="free")
    mean = force / (np.pi * 0.2**2)
    assert solution.value("contact_pressure_mean") == pytest.approx(mean, rel=0.02)
    assert solution.value("contact_pressure_max") == pytest.approx(1.5 * mean, rel=0.01)
