"""Views of fields in flat memory."""

import numpy as np
import pytest

from hpc_gfmd.kernels.jit import kernel
from hpc_gfmd.kernels.views import view_fields


@kernel
def doubled_view(flat, begin, fields, rows, n):
    view = view_fields(flat, begin, fields, rows, n)
    total = 0.0
    for c in range(view.shape[0]):
        for i in range(view.shape[1]):
            for j in range(view.shape[2]):
                view[c, i, j] *= 2
                total += (c + 1) * view[c, i, j]
    return total


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_view_fields(random, dtype):
    """A view shares memory, in C order."""
    flat = random.random(40).astype(dtype)
    wanted = flat.copy()
    wanted[5:29] *= 2
    view = wanted[5:29].reshape(2, 3, 4)
    assert doubled_view(flat, 5, 2, 3, 4) == pytest.approx(
        view[0].sum(dtype=float) + 2 * view[1].sum(dtype=float), rel=1e-6
    )
    assert np.array_equal(flat, wanted)
