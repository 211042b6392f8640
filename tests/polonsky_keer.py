"""Reference solutions on grids too large for dense matrices: constrained conjugate gradients on the
pressure (Polonsky, Keer, Wear 231 (1999) 206), without any code of the package.

In contact, p > 0, the gap e = S p + h - constant has to vanish, S = 2/(E* |q|). One iteration:

    t   conjugate direction of e, in contact
    p   max(p - tau t, 0), tau: exact line search
    p   also raised where surfaces penetrate out of contact; the direction restarts then
    p   scaled to the prescribed mean
"""

import numpy as np
from oracle import Oracle


def solve(heights, pressure, E_star=1.0, sizes=(1.0, 1.0), tolerance=1e-12, steps=20_000):
    """The Oracle of heights z (peaks up) under a mean pressure.

    tolerance: of gaps in contact and penetrations out of contact, over the height of the surface.
    """
    z = np.asarray(heights, dtype=float)
    q_x, q_y = (2 * np.pi * np.fft.fftfreq(n, size / n) for n, size in zip(z.shape, sizes))
    q = np.hypot(q_x[:, None], q_y[: z.shape[1] // 2 + 1])
    S = np.divide(2 / E_star, q, out=np.zeros_like(q), where=q > 0)
    h = z.max() - z

    def displacement(p):
        return np.fft.irfft2(S * np.fft.rfft2(p), z.shape)

    p = np.full(z.shape, float(pressure))
    t = np.zeros(z.shape)
    last_squares = 1.0
    conjugate = 0.0  # 1 if the last direction is kept
    for _ in range(steps):
        contact = p > 0
        e = displacement(p) + h
        e -= e[contact].mean()
        if max(np.abs(e[contact]).max(), -e.min()) < tolerance * h.max():
            break
        squares = np.sum(e[contact] ** 2)
        t = np.where(contact, e + conjugate * squares / last_squares * t, 0)
        last_squares = squares
        r = displacement(t)
        r -= r[contact].mean()
        tau = np.sum((e * t)[contact]) / np.sum((r * t)[contact])
        p = np.maximum(p - tau * t, 0)
        penetrates = (p == 0) & (e < 0)
        p[penetrates] -= tau * e[penetrates]
        conjugate = 0.0 if penetrates.any() else 1.0
        p *= pressure / p.mean()
    else:
        raise AssertionError("the oracle found no solution")
    gap = np.where(p > 0, 0, np.maximum(e, 0))
    u = gap - h
    energy = 0.5 * np.mean((u - u.mean()) * (p - p.mean()))
    return Oracle(p, gap, u, float(np.mean(p > 0)), float(gap.mean()), float(energy))
