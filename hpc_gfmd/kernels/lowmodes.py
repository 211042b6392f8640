"""The lowest modes of a field: from its spectrum to products of cos and sin along both axes, and
back.

Parts (4, m_x, m_y) are of cos cos, cos sin, sin cos and sin sin, m_x and m_y counting from wave
number 0; norm makes these products orthonormal.
"""

from .jit import kernel


@kernel
def split(waves, shift_x, shift_y, norm, parts):
    """Make the parts of columns (n_x, m_y) that have been transformed, shifted along both axes to
    the middle of the surface."""
    n = waves.shape[0]
    for k in range(norm.shape[0]):
        for j in range(norm.shape[1]):
            here = shift_y[j] * norm[k, j] / 2
            up, down = (
                waves[k, j] * shift_x[k] * here,
                waves[(n - k) % n, j] * shift_x[k].conjugate() * here,
            )
            even, odd = up + down, 1j * (up - down)
            parts[0, k, j] = even.real
            parts[1, k, j] = -even.imag
            parts[2, k, j] = odd.real
            parts[3, k, j] = -odd.imag


@kernel
def multiply(part, matrices, by_columns, x):
    """Set part = matrices part, in place; returns <part, matrices part>. matrices (stack, m, m),
    symmetric: of all of it (stack = 1), of each column (by_columns) or of each row; x: scratch (>=
    m,)."""
    stack, m = matrices.shape[:2]
    total = 0.0
    columns = part.shape[1]
    for b in range(stack):
        for i in range(m):
            x[i] = part[i, b] if by_columns else part[b + i // columns, i % columns]
        for i in range(m):
            y = x.dtype.type(0)
            for j in range(m):
                y += matrices[b, i, j] * x[j]
            total += x[i] * y
            if by_columns:
                part[i, b] = y
            else:
                part[b + i // columns, i % columns] = y
    return total


@kernel
def join(parts, shift_x, shift_y, norm, unit, up, down):
    """Undo `split`, times unit: what stands at wave numbers k_x >= 0 and at -k_x < 0 from the last
    one on."""
    m_x = norm.shape[0]
    for k in range(m_x):
        for j in range(norm.shape[1]):
            back = unit / norm[k, j] / shift_y[j]
            even = (parts[0, k, j] - 1j * parts[1, k, j]) * back
            odd = (parts[2, k, j] - 1j * parts[3, k, j]) * back
            up[k, j] = (even - 1j * odd) / shift_x[k]
            if k > 0:
                down[m_x - 1 - k, j] = (even + 1j * odd) * shift_x[k]
