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
