"""Sums and combinations of a few fields: the subspace of a locally optimal conjugate gradient.

Letters, of fields: local slabs (n_loc, n_y), in the units of operators/problem.py.

=====  =============================================================================================
V      (3, n_loc, n_y), directions of the gap: the best one so far, the preconditioned residual, and
       the last change of the best one
KV     K times each of them
D      diagonal of a second operator, as a stiffness
k      number of directions that there are
=====  =============================================================================================
"""

import numpy as np

from .jit import kernel


@kernel
def subspace_products(V, KV, D, k, i0, i1, sums):
    """Set sums[0, a, b], sums[1, a, b], b <= a < k, to <V_a, K V_b>, <V_a, D V_b> over rows."""
    for a in range(k):
        for b in range(a + 1):
            stiff = 0.0
            soft = 0.0
            for i in range(i0, i1):
                for j in range(V.shape[2]):
                    stiff += V[a, i, j] * np.float64(KV[b, i, j])
                    soft += V[a, i, j] * np.float64(D[i, j]) * V[b, i, j]
            sums[0, a, b] = stiff
            sums[1, a, b] = soft


@kernel
def combine_directions(V, KV, k, weights, i0, i1):
    """Set V[0] to the sum of weights V, V[2] to that without its first term; KV likewise."""
    for field in (V, KV):
        for i in range(i0, i1):
            for j in range(field.shape[2]):
                new = weights[1] * field[1, i, j] if k > 1 else weights[0] * 0
                new += weights[2] * field[2, i, j] if k > 2 else weights[0] * 0
                field[0, i, j] = weights[0] * field[0, i, j] + new
                field[2, i, j] = new
