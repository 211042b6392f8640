"""What takes the images of a surface that ends out of a periodic cell."""

import numpy as np
import pytest

from hpc_gfmd.bodies import images as module
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
    """The Images of a surface, sizes of its cell and of the surface in it, in their unit."""
    shape = Free(free)._shape(grid_of(n, sizes, SerialComm(), free=free))
    return images(*shape[:-1]), *shape[:2]


def products(found: Images, parity, x, y, cell):
    """The modes of a parity at points (x, y) from the middle, (points, modes)."""
    values = []
    for z, modes, length, sign in zip((x, y), found.modes, cell, parity):
        k = np.arange(0 if sign > 0 else 1, modes + 1)
        function = np.cos if sign > 0 else np.sin
        values.append(
            function(2 * np.pi / length * np.outer(z, k))
            * np.where(k > 0, np.sqrt(2), 1)
            / np.sqrt(length)
        )
    return np.einsum("pi,pj->pij", *values)


def matrix(found: Images, parity):
    """T of a parity over pairs (k_x, k_y)."""
    T = found.T[parity]
    shape = tuple(k + (sign > 0) for k, sign in zip(found.modes, parity))
    index = found.stacked(np.arange(shape[0] * shape[1]).reshape(shape))
    out = np.zeros((shape[0] * shape[1],) * 2)
    for numbers, block in zip(index, T):
        out[np.ix_(numbers, numbers)] = block
    return out


@pytest.mark.parametrize("cell", [(1.0, 1.0), (1.3, 0.8)])
def test_kernel_makes_free_space_periodic(cell, monkeypatch):
    """1/(pi r) less it goes on periodically, has the mean 0, and does not know how the sum was
    split."""
    X, Y = cell
    x = np.linspace(0.05, X / 2, 7)
    y = np.linspace(0, Y / 2, 5)

    def rest(x, y):
        return 1 / (np.pi * np.hypot(x[:, None], y)) - kernel(x, y, X, Y)

    S = rest(x, y)
    assert rest(X - x, y) == pytest.approx(S, abs=1e-12)
    assert rest(x, Y - y) == pytest.approx(S, abs=1e-12)
    u, w = np.polynomial.legendre.leggauss(40)
    c = w @ kernel((u + 1) * X / 4, (u + 1) * Y / 4, X, Y) @ w / 4
    # mean of 1/(pi r)
    over_r = (X * np.arcsinh(Y / X) + Y * np.arcsinh(X / Y)) * 2 / (np.pi * X * Y)
    assert c == pytest.approx(over_r, rel=1e-10)
    monkeypatch.setattr(module, "WIDTH", 0.13)
    assert rest(x, y) == pytest.approx(S, abs=1e-12)


@pytest.mark.parametrize("q", [0.0, 0.3, 5.0])
def test_kernel_of_a_wave(q):
    """Free space less the sum over the waves along the axis, to which long cells converge."""
    x = np.array([0.0, 0.1, 0.6])
    X = 1.0

    def in_a_cell(length, waves):
        """The sums at 0.1 and 0.6, less that at 0.35."""
        k = 2 * np.pi / length * np.arange(1, waves)
        sums = [np.sum(4 / np.hypot(k, q) * np.cos(k * d)) / length for d in (0.1, 0.6, 0.35)]
        return np.subtract(sums[:2], sums[2])

    c = kernel_of_wave(np.append(x, 0.35), X, q)
    wanted = in_a_cell(40, 400_001) - in_a_cell(X, 200_000)
    assert c[1:3] - c[3] == pytest.approx(wanted, abs=2e-3)
    assert c[0] == pytest.approx(kernel_of_wave(np.array([1e-7]), X, q)[0], rel=1e-6)


@pytest.mark.parametrize(("n", "sizes", "free"), SURFACES)
def test_modes_are_the_kernel_on_the_surface(n, sizes, free):
    """Between all its points, corners too, but for a constant; by waves where one axis is
    periodic."""
    found, cell, inside = made(n, sizes, free)
    rng = np.random.default_rng(4)
    z = rng.uniform(-1, 1, (2, 2, 30))  # many near the edges, where it is worst
    here, there = 0.5 * np.sign(z) * (1 - z**2) * np.array(inside)[:, None]
    here[:, 0] = np.array(inside) / 2
    there[:, 0] = -np.array(inside) / 2
    found_c = np.zeros(30)
    for parity in found.T:
        one, other = (products(found, parity, *at, cell).reshape(30, -1) for at in (here, there))
        found_c += np.sum(one @ matrix(found, parity) * other, axis=1)
    if all(free):
        wanted = np.array([kernel(abs(x[:1]), abs(x[1:]), *cell)[0, 0] for x in (here - there).T])
    else:
        along = int(free[1])
        x, y = (here - there)[:: 1 if along == 0 else -1]
        X = cell[along]
        Y = cell[1 - along]
        last = found.modes[1 - along]
        wanted = (
            sum(
                (1 if k == 0 else 2)
                * kernel_of_wave(abs(x), X, 2 * np.pi * k / Y)
                * np.cos(2 * np.pi * k * y / Y)
                for k in range(last + 1)
            )
            / Y
        )
        assert (
            abs(kernel_of_wave(np.array([inside[along]]), X, 2 * np.pi * (last + 1) / Y))[0] < 1e-6
        )
    difference = found_c - wanted
    assert np.ptp(difference) < 5e-7
    if all(free):
        assert difference.mean() == pytest.approx(-found.constant, abs=1e-6)
