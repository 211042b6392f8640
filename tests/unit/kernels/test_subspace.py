"""Products and combinations of search directions against NumPy."""

import numpy as np
import pytest

from hpc_gfmd.kernels.subspace import combine_directions, subspace_products

N = (7, 10)


@pytest.mark.parametrize("k", [1, 2, 3])
def test_subspace(random, k):
    V = random.standard_normal((3, *N))
    KV = random.standard_normal((3, *N))
    D = random.random(N)
    sums = np.zeros((2, 3, 3))
    subspace_products(V, KV, D, k, 0, N[0], sums)
    for a in range(k):
        for b in range(a + 1):
            assert sums[0, a, b] == pytest.approx(np.sum(V[a] * KV[b]))
            assert sums[1, a, b] == pytest.approx(np.sum(V[a] * D * V[b]))
    weights = random.standard_normal(3)
    weights[k:] = 0
    new_fields = [np.tensordot(weights[1:], field[1:], 1) for field in (V, KV)]
    best_fields = [
        new + weights[0] * field[0] for new, field in zip(new_fields, (V, KV), strict=True)
    ]
    combine_directions(V, KV, k, weights, 0, N[0])
    for field, new, best in zip((V, KV), new_fields, best_fields, strict=True):
        assert np.allclose(field[0], best)
        assert np.allclose(field[2], new)
