"""Random waves of a given spectrum. The number of a mode depends on (seed, its signed mode numbers)
alone."""

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
    """Return a number uniform on (-1, 1) from 64 random bits."""
    return (np.float64(x >> _S11) + 0.5) * (2.0 / 9007199254740992.0) - 1.0


@inline
def _segment(k, begins):
    """Return the number of the last segment that begins at k or below, 0 if there is none."""
    first = 0
    last = len(begins)
    while last - first > 1:
        middle = (first + last) // 2
        if begins[middle] <= k:
            first = middle
        else:
            last = middle
    return first


@inline
def _mode(k_x, k_y, law):
    """Return the amplitude (re, im) of the mode (k_x, k_y) of any signs; (0, 0) outside the band.

    It is the conjugate of that of (-k_x, -k_y). law: see `random_waves`.
    """
    seed, phases_only, aspect, stretch, band, begins, scales, factors, exponents = law
    low, high = band
    y = k_y / aspect
    k = np.sqrt(stretch[0] * (k_x * k_x) + stretch[1] * (k_x * y) + stretch[2] * (y * y))
    if k == 0.0 or k < low * (1 - 1e-12) or k > high * (1 + 1e-12):
        return 0.0, 0.0
    mirrored = k_y < 0 or (k_y == 0 and k_x < 0)
    if mirrored:
        k_x, k_y = -k_x, -k_y
    word = _mix(
        _mix(_mix(seed) ^ (np.uint64(np.int64(k_x)) * _D)) ^ (np.uint64(np.int64(k_y)) * _A)
    )
    segment = _segment(k, begins)
    amplitude = factors[segment] * (k / scales[segment]) ** (-exponents[segment])
    re = _uniform(word)
    im = _uniform(_mix(word))
    # On the coarsest grid this is a Nyquist mode, of which a grid sees only twice the real part.
    # With both parts equal the power seen there is that of the surface, so all grids agree on
    # heights and on h_rms, g_rms.
    is_nyquist = (k_x == 0 or k_y == 0) and k > high * (1 - 1e-12)
    if phases_only:
        phase = np.pi * re
        re = np.sqrt(2 / 3) * np.cos(phase)
        im = np.sqrt(2 / 3) * np.sin(phase)
        if is_nyquist:
            re = np.sqrt(1 / 3) * np.sign(re)
    if is_nyquist:
        im = re
    return re * amplitude, (-im if mirrored else im) * amplitude


@kernel
def random_waves(block, keep, factor, j0, columns, n_y, law):
    """Set block = keep block + factor times the random waves of a law.

    block (W, n_x): complete columns of the half spectrum; column w < columns is mode number k_y =
    j0 + w, the others have no modes. A mode number of exactly half the points is the sum of the two
    modes that the grid cannot distinguish.

    law: (seed, phases_only, aspect, stretch, band, begins, scales, factors, exponents). aspect =
    L_y/L_x. In units of 2 pi/L_x, with y = k_y/aspect, k^2 = stretch . (k_x^2, k_x y, y^2), which
    is |q|^2 of an isotropic surface. Modes have low <= k <= high, the band. In segment s, from
    begins[s] on, A = factors[s] (k/scales[s])^-exponents[s]. Both parts are random numbers between
    -A and A or, with phases_only, those of a random phase and the mean power of these, 2/3 A^2.
    """
    W, n_x = block.shape
    for w in range(W):
        k_y = j0 + w
        for i in range(n_x):
            k_x = i if 2 * i <= n_x else i - n_x
            re = 0.0
            im = 0.0
            if w < columns:
                for s in range(2 if 2 * k_x == n_x else 1):
                    x = k_x if s == 0 else -k_x
                    for t in range(2 if 2 * k_y == n_y else 1):
                        a, b = _mode(x, k_y if t == 0 else -k_y, law)
                        re += a
                        im += b
            block[w, i] = keep * block[w, i] + factor * complex(re, im)
