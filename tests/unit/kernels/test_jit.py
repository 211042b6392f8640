"""Points of a row that belong to the surface."""

import pytest

from hpc_gfmd.kernels.jit import kernel, points_inside


@kernel
def counted_inside(shape, inside):
    count = 0
    for i in range(shape[0]):
        for _ in range(points_inside(i, inside)):
            count += 1
    return count


@pytest.mark.parametrize("inside", [(4, 6), (2, 5), (0, 6), (3, 0)])
def test_points_inside(inside):
    assert counted_inside((4, 6), inside) == inside[0] * inside[1]


def test_python_calls_a_piece():
    """It has no entry for Python: a kernel is made of the same function."""
    assert points_inside(1, (2, 3)) == 3
    assert points_inside(2, (2, 3)) == 0
