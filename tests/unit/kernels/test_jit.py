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


def test_python_cannot_call_a_piece():
    """It has no entry for Python; numba's own call would end the process."""
    with pytest.raises(TypeError, match="points_inside is a piece of kernels"):
        points_inside(1, (2, 3))
    assert points_inside.py_func(1, (2, 3)) == 3
