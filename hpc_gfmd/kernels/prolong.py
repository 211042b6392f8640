"""Cubic interpolation of a displacement from the decimated grid."""

import numpy as np

from .jit import kernel


@kernel
def prolong_gap(u, h, g, start, first, step_x, halve_y):
    """g = max(P u + h, 0) on a slab of rows beginning at `start`; u: coarse rows beginning at `first`, two more on either side.

    Coarse point J lies on fine point 2 J; points in between get the cubic through the four nearest, (-1, 9, 9, -1)/16.
    """
    rows, n = h.shape
    m = u.shape[1]
    near = u.dtype.type(9.0 / 16.0)
    far = u.dtype.type(-1.0 / 16.0)
    zero = u.dtype.type(0)
    line = np.empty(m, u.dtype)
    for i in range(rows):
        x = start + i
        k = x // step_x - first
        if step_x == 2 and x % 2 == 1:
            for J in range(m):
                line[J] = near * (u[k, J] + u[k + 1, J]) + far * (u[k - 1, J] + u[k + 2, J])
        else:
            for J in range(m):
                line[J] = u[k, J]
        if halve_y:
            for J in range(m):
                g[i, 2 * J] = max(line[J] + h[i, 2 * J], zero)
            for J in range(n // 2):
                a = J - 1 if J > 0 else m - 1
                b = J + 1 if J + 1 < m else J + 1 - m
                c = J + 2 if J + 2 < m else J + 2 - m
                v = near * (line[J] + line[b]) + far * (line[a] + line[c])
                g[i, 2 * J + 1] = max(v + h[i, 2 * J + 1], zero)
        else:
            for j in range(n):
                g[i, j] = max(line[j] + h[i, j], zero)
