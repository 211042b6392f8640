"""Another second opinion, on grids that are too large for dense matrices: constrained conjugate
gradients on the pressure (Polonsky, Keer, Wear 231 (1999) 206).

Nothing of the package is used here.

In contact, p > 0, the gap e = S p + h - constant has to vanish, S = 2/(E* |q|). One iteration:

    t   conjugate direction from e, in contact
    p   max(p - tau t, 0), tau: exact line search
    p   also where the surfaces penetrate out of contact; the direction is then forgotten
    p   scaled to the mean that is asked for
"""

import numpy as np
from oracle import Oracle


def solve(heights, pressure, E_star=1.0, sizes=(1.0, 1.0), tolerance=1e-12, steps=20_000):
    """The contact of heights z (peaks up) under the mean pressure.

    tolerance: of the gap in contact and of what penetrates out of it, over the height of the
    surface.
    """
    z = np.asarray(heights, dtype=float)
    q_x, q_y = (2 * np.pi * np.fft.fftfreq(n, size / n) for n, size in zip(z.shape, sizes))
    q = np.hypot(q_x[:, None], q_y[: z.shape[1] // 2 + 1])
    S = np.divide(2 / E_star, q, out=np.zeros_like(q), where=q > 0)
    h = z.max() - z

    def give_way(p):
        return np.fft.irfft2(S * np.fft.rfft2(p), z.shape)

    p = np.full(z.shape, float(pressure))
    t = np.zeros(z.shape)
    squares_before = 1.0
    goes_on = 0.0  # 1 where the direction before counts
    for _ in range(steps):
        contact = p > 0
        e = give_way(p) + h
        e -= e[contact].mean()
        if max(np.abs(e[contact]).max(), -e.min()) < tolerance * h.max():
            break
        squares = np.sum(e[contact] ** 2)
        t = np.where(contact, e + goes_on * squares / squares_before * t, 0)
        squares_before = squares
        r = give_way(t)
        r -= r[contact].mean()
        tau = np.sum((e * t)[contact]) / np.sum((r * t)[contact])
        p = np.maximum(p - tau * t, 0)
        penetrates = (p == 0) & (e < 0)
        p[penetrates] -= tau * e[penetrates]
        goes_on = 0.0 if penetrates.any() else 1.0
        p *= pressure / p.mean()
    else:
        raise AssertionError("the oracle found no solution")
    gap = np.where(p > 0, 0, np.maximum(e, 0))
    u = gap - h
    energy = 0.5 * np.mean((u - u.mean()) * (p - p.mean()))
    return Oracle(p, gap, u, float(np.mean(p > 0)), float(gap.mean()), float(energy))
