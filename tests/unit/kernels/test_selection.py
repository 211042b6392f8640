"""Kernels of the exact selection against NumPy."""

import numpy as np
import pytest

from hpc_gfmd.kernels.selection import DIGIT, count_digits, depths_below

N = (7, 9)
every_edge = pytest.mark.parametrize("inside", [N, (5, 8), (0, 0)])


def keys_of(field):
    """Integers that order as the floating-point numbers of a field do."""
    integer = np.dtype(f"u{field.itemsize}")
    sign = integer.type(1 << (8 * field.itemsize - 1))
    bits = field.view(integer)
    return np.where(bits & sign, ~bits, bits | sign).astype(integer)


@every_edge
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_count_digits(random, inside, dtype):
    """Digits are counted only below the given prefix and inside the surface."""
    field = random.standard_normal(N).astype(dtype)
    field[0, :3] = 0.0, -0.0, np.finfo(dtype).tiny
    keys = keys_of(field)
    assert (np.diff(field.ravel()[np.argsort(keys.ravel())]) >= 0).all()
    shift = 8 * field.itemsize - 2 * DIGIT  # the second digit from the top
    prefix = keys[1, 2] >> np.array(shift + DIGIT, keys.dtype)
    counts = np.zeros(1 << DIGIT)
    count_digits(
        field.view(keys.dtype),
        inside,
        np.uint64(1 << (8 * field.itemsize - 1)),
        np.uint64(shift),
        np.uint64(prefix),
        counts,
    )
    candidates = keys[: inside[0], : inside[1]].ravel().astype(np.uint64)
    candidates = candidates[candidates >> np.uint64(shift + DIGIT) == np.uint64(prefix)]
    digits = (candidates >> np.uint64(shift)) & np.uint64((1 << DIGIT) - 1)
    assert np.array_equal(counts, np.bincount(digits.astype(int), minlength=1 << DIGIT))
    assert inside == (0, 0) or counts.sum() > 0


@every_edge
@pytest.mark.parametrize("level", [-0.3, 0.0, 0.8])
def test_depths_below(random, inside, level):
    field = random.standard_normal(N)
    surface = field[: inside[0], : inside[1]]
    wanted = (np.maximum(-surface, 0).sum(), np.maximum(level - surface, 0).sum())
    assert depths_below(field, inside, level) == pytest.approx(wanted, rel=1e-13)
