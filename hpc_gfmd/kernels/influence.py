"""Kernel of the matrix of S between points, from a table of distances (operators/influence.py)."""

from .jit import kernel


@kernel
def between(S, n, i, j, out):
    """Set out[k, m] to S between points k and m at (i, j) of a grid of n points along each axis;
    distances beyond the table go around the grid.
    """
    n_x, n_y = n
    for k in range(out.shape[0]):
        for m in range(k + 1):
            x = abs(i[k] - i[m])
            y = abs(j[k] - j[m])
            x = x if x < S.shape[0] else n_x - x
            y = y if y < S.shape[1] else n_y - y
            out[k, m] = S[x, y]
            out[m, k] = S[x, y]
