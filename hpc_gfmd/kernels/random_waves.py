"""Random waves of a given spectrum; a mode depends on (seed, its signed mode numbers) alone."""

import numpy as np

from .jit import inline, kernel

_A = np.uint64(0x9E3779B97F4A7C15)
_B = np.uint64(0xBF58476D1CE4E5B9)
_C = np.uint64(0x94D049BB133111EB)
_D = np.uint64(0xD1342543DE82EF95)
_S30, _S27, _S31, _S11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)


@inline
def _mix(x):
    """Apply the finaliser of SplitMix64: a bijection of 64-bit words that scrambles all bits."""
    x = x + _A
    x = (x ^ (x >> _S30)) * _B
    x = (x ^ (x >> _S27)) * _C
    return x ^ (x >> _S31)


@inline
def _uniform(x):
    return (np.float64(x >> _S11) + 0.5) * (2.0 / 9007199254740992.0) - 1.0


@inline
def _segment(k, begins):
    """Return the number of the last segment that begins at k or below, 0 if there is none."""
    segment = 0
    stop = len(begins)
    while stop - segment > 1:
        middle = (segment + stop) // 2
        if begins[middle] <= k:
            segment = middle
        else:
            stop = middle
    return segment


@inline
def _of_laws(k_x, y, stretch, laws):
    """Return A of power laws at a mode, and whether it is that of the shortest wave."""
    low, high, begins, scales, factors, exponents = laws
    k = np.sqrt(stretch[0] * (k_x * k_x) + stretch[1] * (k_x * y) + stretch[2] * (y * y))
    if k == 0.0 or k < low * (1 - 1e-12) or k > high * (1 + 1e-12):
        return 0.0, False
    segment = _segment(k, begins)
    return factors[segment] * (k / scales[segment]) ** (-exponents[segment]), k > high * (1 - 1e-12)


@inline
def _of_table(k_x, y, table):
    """Return A of a table at a mode, and whether it is at an end of the table."""
    x_rows, y_rows, powers = table
    end_x = x_rows[-1]
    end_y = y_rows[-1]
    if k_x < x_rows[0] * (1 + 1e-12) or k_x > end_x * (1 + 1e-12) or y > end_y * (1 + 1e-12):
        return 0.0, False
    if y < y_rows[0] or (k_x == 0 and y == 0):
        return 0.0, False
    i = min(_segment(k_x, x_rows), len(x_rows) - 2)
    j = min(_segment(y, y_rows), len(y_rows) - 2)
    s = min(max((k_x - x_rows[i]) / (x_rows[i + 1] - x_rows[i]), 0.0), 1.0)
    t = min((y - y_rows[j]) / (y_rows[j + 1] - y_rows[j]), 1.0)
    begin = (1 - t) * powers[i, j] + t * powers[i, j + 1]
    end = (1 - t) * powers[i + 1, j] + t * powers[i + 1, j + 1]
    is_end = k_x > end_x * (1 - 1e-12) or y > end_y * (1 - 1e-12)
    return np.sqrt((1 - s) * begin + s * end), is_end


@inline
def _amplitude(k_x, k_y, law):
    """Return A of a mode, 0 outside the band, and whether it is that of the shortest wave."""
    _, _, aspect, stretch, laws, table = law
    if len(table[0]) > 0:
        return _of_table(k_x, k_y / aspect, table)
    return _of_laws(k_x, k_y / aspect, stretch, laws)


@inline
def _mode(k_x, k_y, amplitude, is_shortest, law):
    """Return the mode (k_x, k_y) of k_y > 0, or k_y = 0 <= k_x: one of each pair k, -k."""
    if amplitude == 0.0:
        return complex(0.0, 0.0)
    seed, phases_only, _, _, _, _ = law
    word = _mix(
        _mix(_mix(seed) ^ (np.uint64(np.int64(k_x)) * _D)) ^ (np.uint64(np.int64(k_y)) * _A)
    )
    re = _uniform(word)
    im = _uniform(_mix(word))
    # On the coarsest grid this is a Nyquist mode, of which a grid sees only twice the real part.
    # With both parts equal the power seen there is that of the surface, so all grids agree on
    # heights and on h_rms, g_rms.
    is_nyquist = (k_x == 0 or k_y == 0) and is_shortest
    if phases_only:
        phase = np.pi * re
        re = np.sqrt(2 / 3) * np.cos(phase)
        im = np.sqrt(2 / 3) * np.sin(phase)
        if is_nyquist:
            re = np.sqrt(1 / 3) * np.sign(re)
    if is_nyquist:
        im = re
    return complex(re * amplitude, im * amplitude)


@kernel
def random_waves(block, keep, factor, j0, columns, n_y, law):
    """Set block = keep block + factor times the random waves of a law.

    block (W, n_x): columns of the half spectrum, w < columns with k_y = j0 + w. A Nyquist mode is
    the sum of the two that the grid cannot distinguish. Modes of k_x and -k_x are made together,
    because mostly both have the same A, which takes half of the time.

    law: (seed, phases_only, aspect, stretch, laws, table). Parts of a mode are random between -A
    and A or, phases_only, of random phase and power 2/3 A^2. With aspect = L_y/L_x a mode is (k_x,
    y = k_y/ aspect) in 2 pi/L_x. laws: (low, high, begins, scales, factors, exponents): low <= k <=
    high, k^2 = stretch . (k_x^2, k_x y, y^2); in segment s A = factors[s]
    (k/scales[s])^-exponents[s]. table: (x_rows, y_rows, powers), if not empty, gives A^2 by linear
    interpolation, 0 beyond.
    """
    W, n_x = block.shape
    is_even = law[3][1] == 0.0 and len(law[5][0]) == 0  # A(-k_x, k_y) = A(k_x, k_y)
    for w in range(W):
        k_y = j0 + w
        for k_x in range(n_x // 2 + 1):
            right = left = complex(0.0, 0.0)
            if w < columns:
                amplitude, is_shortest = _amplitude(k_x, k_y, law)
                right = _mode(k_x, k_y, amplitude, is_shortest, law)
                if k_y == 0:
                    left = right.conjugate()
                else:
                    if not is_even:
                        amplitude, is_shortest = _amplitude(-k_x, k_y, law)
                    left = _mode(-k_x, k_y, amplitude, is_shortest, law)
                if 2 * k_y == n_y:
                    right, left = right + left.conjugate(), left + right.conjugate()
                if 2 * k_x == n_x:
                    right += left
            block[w, k_x] = keep * block[w, k_x] + factor * right
            if 0 < k_x and 2 * k_x < n_x:
                block[w, n_x - k_x] = keep * block[w, n_x - k_x] + factor * left
