"""The lowest modes of a field: from its spectrum to products of cos and sin along both axes, and
back (bodies/free.py).

Letters. Wave numbers count from 0: k_x < m_x, k_y < m_y.

=======  ===========================================================================================
parts    (4, m_x, m_y) of cos cos, cos sin, sin cos and sin sin, in the unit of the field
norm     (m_x, m_y), makes these products orthonormal over the cell
shift    (m_x,) or (m_y,) complex, e^(i k middle): moves the origin to the middle of the surface
=======  ===========================================================================================
"""

from .jit import kernel


@kernel
def split(waves, shift_x, shift_y, norm, parts):
    """Split the lowest modes of a spectrum, waves, into `parts`, products of cos and sin."""
    n_x = waves.shape[0]
    for k in range(norm.shape[0]):
        for j in range(norm.shape[1]):
            factor = shift_y[j] * norm[k, j] / 2
            positive = waves[k, j] * shift_x[k] * factor
            negative = waves[(n_x - k) % n_x, j] * shift_x[k].conjugate() * factor
            even = positive + negative
            odd = 1j * (positive - negative)
            parts[0, k, j] = even.real
            parts[1, k, j] = -even.imag
            parts[2, k, j] = odd.real
            parts[3, k, j] = -odd.imag


@kernel
def multiply(part, matrices, by_columns, x):
    """Multiply modes of one parity by symmetric matrices, one for each column (`by_columns`) or
    row, or for all modes, in place; return <part, matrices part> before.
    """
    stack = matrices.shape[0]
    m = matrices.shape[1]
    columns = part.shape[1]
    product = 0.0
    for b in range(stack):
        for i in range(m):
            x[i] = part[i, b] if by_columns else part[b + i // columns, i % columns]
        for i in range(m):
            value = x.dtype.type(0)
            for j in range(m):
                value += matrices[b, i, j] * x[j]
            product += x[i] * value
            if by_columns:
                part[i, b] = value
            else:
                part[b + i // columns, i % columns] = value
    return product


@kernel
def join(parts, shift_x, shift_y, norm, unit, positive, negative):
    """Undo `split` and multiply by `unit`: `positive` (m_x, m_y), k_x >= 0; `negative` (m_x - 1,
    m_y), -k_x < 0, largest first.
    """
    m_x = norm.shape[0]
    for k in range(m_x):
        for j in range(norm.shape[1]):
            factor = unit / norm[k, j] / shift_y[j]
            even = (parts[0, k, j] - 1j * parts[1, k, j]) * factor
            odd = (parts[2, k, j] - 1j * parts[3, k, j]) * factor
            positive[k, j] = (even - 1j * odd) / shift_x[k]
            if k > 0:
                negative[m_x - 1 - k, j] = (even + 1j * odd) * shift_x[k]
