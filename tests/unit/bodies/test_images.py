"""The correction that removes periodic images from displacements of surfaces with free edges."""

import numpy as np
import pytest
from refusal import refused

from hpc_gfmd.bodies.free import Free
from hpc_gfmd.bodies.images import Images, images, kernel, kernel_of_wave
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.surface import grid_of

SURFACES = [
    ((128, 128), (1.0, 1.0), (True, True)),
    ((512, 512), (1.0, 1.0), (True, True)),
    ((128, 64), (2.0, 1.0), (True, True)),
    ((40, 60), (1.0, 1.5), (True, True)),
    ((512, 32), (1.0, 0.0625), (True, True)),
    ((32, 32), (1.0, 10.0), (True, True)),
    ((8, 48), (20.0, 3.0), (True, True)),
    ((40, 24), (1.0, 28.0), (True, False)),
    ((512, 8), (64.0, 1.0), (True, True)),
    ((512, 8), (64.0, 1.0), (False, True)),
    ((96, 64), (1.0, 1.0), (True, False)),
    ((30, 128), (0.3, 1.0), (False, True)),
]


def made(n, sizes, free):
    """(Images, sizes of the cell, sizes of the surface in it) in the unit of lengths."""
    shape = Free(free)._shape(grid_of(n, sizes, SerialComm(), free=free))
    return images(*shape[:-1]), *shape[:2]


def mode_values(image_modes: Images, parity, x, y, cell):
    """Values of the modes of a parity at points (x, y) from the middle, (points, modes)."""
    values = []
    for z, modes, length, sign in zip((x, y), image_modes.modes, cell, parity):
        k = np.arange(0 if sign > 0 else 1, modes + 1)
        function = np.cos if sign > 0 else np.sin
        values.append(
            function(2 * np.pi / length * np.outer(z, k))
            * np.where(k > 0, np.sqrt(2), 1)
            / np.sqrt(length)
        )
    return np.einsum("pi,pj->pij", *values)


def matrix(image_modes: Images, parity):
    """The matrix T of a parity over pairs (k_x, k_y)."""
    T = image_modes.T[parity]
    shape = tuple(k + (sign > 0) for k, sign in zip(image_modes.modes, parity))
    index = image_modes.stacked(np.arange(shape[0] * shape[1]).reshape(shape))
    out = np.zeros((shape[0] * shape[1],) * 2)
    for numbers, block in zip(index, T):
        out[np.ix_(numbers, numbers)] = block
    return out


@pytest.mark.parametrize("q", [0.0, 0.3, 5.0])
def test_kernel_of_a_wave(q):
    """The kernel is the limit of long cells less the sum over waves in the cell."""
    x = np.array([0.0, 0.1, 0.6])
    X = 1.0

    def in_a_cell(length, waves):
        """The sums at 0.1 and 0.6, less that at 0.35."""
        k = 2 * np.pi / length * np.arange(1, waves)
        sums = [np.sum(4 / np.hypot(k, q) * np.cos(k * d)) / length for d in (0.1, 0.6, 0.35)]
        return np.subtract(sums[:2], sums[2])

    kernel_values = kernel_of_wave(np.append(x, 0.35), X, q)
    wanted = in_a_cell(40, 400_001) - in_a_cell(X, 200_000)
    assert kernel_values[1:3] - kernel_values[3] == pytest.approx(wanted, abs=2e-3)
    assert kernel_values[0] == pytest.approx(kernel_of_wave(np.array([1e-7]), X, q)[0], rel=1e-6)


@pytest.mark.parametrize(("n", "sizes", "free"), SURFACES)
def test_modes_are_the_kernel_on_the_surface(n, sizes, free):
    """Between points of the surface, corners included, up to a constant; where one axis is
    periodic, the kernel is summed over waves."""
    image_modes, cell, inside = made(n, sizes, free)
    rng = np.random.default_rng(4)
    z = rng.uniform(-1, 1, (2, 2, 30))  # many near the edges, where the error is largest
    edge = np.array(inside)[:, None] / 2
    point, other_point = edge * np.sign(z) * (1 - z**2)
    point[:, 0] = np.array(inside) / 2
    other_point[:, 0] = -np.array(inside) / 2
    sums = np.zeros(30)
    for parity in image_modes.T:
        at_first = mode_values(image_modes, parity, *point, cell).reshape(30, -1)
        at_second = mode_values(image_modes, parity, *other_point, cell).reshape(30, -1)
        sums += np.sum(at_first @ matrix(image_modes, parity) * at_second, axis=1)
    distance = point - other_point
    if all(free):
        wanted = np.array([kernel(abs(x[:1]), abs(x[1:]), *cell)[0, 0] for x in distance.T])
    else:
        free_axis = int(free[1])
        x = distance[free_axis]
        y = distance[1 - free_axis]
        X = cell[free_axis]
        Y = cell[1 - free_axis]
        highest = image_modes.modes[1 - free_axis]
        wanted = np.zeros(30)
        for k in range(highest + 1):
            q = 2 * np.pi * k / Y
            wanted += (1 if k == 0 else 2) / Y * kernel_of_wave(abs(x), X, q) * np.cos(q * y)
        q = 2 * np.pi * (highest + 1) / Y
        assert abs(kernel_of_wave(np.array([inside[free_axis]]), X, q))[0] < 1e-6
    difference = sums - wanted
    assert np.ptp(difference) < 5e-7
    if all(free):
        assert difference.mean() == pytest.approx(-image_modes.constant, abs=1e-6)


def test_grids_that_are_too_long_are_refused():
    """A profile of points as wide as all of it, with free edges on all sides."""
    with refused('found "free" along both axes of a grid of 38 : 1, allowed: shorter grids'):
        images((0.161374, 6.196773), (0.0134479, 0.258199), (True, True), (8, 35))
