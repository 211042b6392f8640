"""Reference solutions: elastic contact on a small grid by dense linear algebra, without any code of
the package.

K is built from matrices of the discrete Fourier transform, and the complementarity problem

    p = p0 + K u >= 0,   g = u + h >= 0,   p g = 0

is solved by principal pivoting: guess the contact, solve the linear system that it implies, move
the points that violate their sign. All of them move at once as long as their number falls;
otherwise only the last one does (Murty), which cannot cycle.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Oracle:
    """Fields (n_x, n_y) and numbers of the exact solution."""

    pressure: np.ndarray
    gap: np.ndarray
    displacement: np.ndarray
    a_r: float
    gap_mean: float
    energy: float


def stiffness(n, sizes=(1.0, 1.0), E_star=1.0, softness=None):
    """The matrix of K = (E*/2)|q|/softness(|q|) for fields flattened row by row.

    |q| is that of the minimal image; softness is 1 by default.
    """
    n_x, n_y = n
    kx = np.arange(n_x)
    ky = np.arange(n_y)
    fx = np.exp(-2j * np.pi * np.outer(kx, kx) / n_x)
    fy = np.exp(-2j * np.pi * np.outer(ky, ky) / n_y)
    qx = 2 * np.pi * np.minimum(kx, n_x - kx) / sizes[0]
    qy = 2 * np.pi * np.minimum(ky, n_y - ky) / sizes[1]
    q = np.sqrt(qx[:, None] ** 2 + qy[None, :] ** 2).ravel()
    if softness is not None:
        q[1:] /= [softness(x) for x in q[1:]]
    F = np.kron(fx, fy)
    K = (F.conj().T * (E_star / 2 * q)) @ F / (n_x * n_y)
    return np.ascontiguousarray((K.real + K.real.T) / 2)


def solve(heights, pressure, E_star=1.0, sizes=(1.0, 1.0), softness=None):
    """The Oracle of heights z (peaks up) under a mean pressure."""
    z = np.asarray(heights, dtype=float)
    K = stiffness(z.shape, sizes, E_star, softness)
    h = (z.max() - z).ravel()
    b = pressure - K @ h
    g, p = _complementary(K, b, np.argmin(h))
    u = g - h
    shape = z.shape
    return Oracle(
        p.reshape(shape),
        g.reshape(shape),
        u.reshape(shape),
        float(np.mean(p > 0)),
        float(g.mean()),
        float(0.5 * u @ (K @ u) / z.size),
    )


def _complementary(K, b, lowest):
    """(g, p) >= 0 with p = b + K g and p g = 0; lowest: the point closest to contact."""
    contact = b > 0
    contact[lowest] = True
    fewest = len(b) + 1
    patience = 10
    for _ in range(20000):
        free = ~contact
        g = np.zeros_like(b)
        p = np.zeros_like(b)
        if free.any():
            g[free] = np.linalg.solve(K[np.ix_(free, free)], -b[free])
        p[contact] = (b + K @ g)[contact]
        tiny = 1e-13 * max(np.abs(p).max(), np.abs(b).max())
        wrong = (contact & (p < -tiny)) | (free & (g < -tiny))
        count = int(wrong.sum())
        if count == 0:
            return np.maximum(g, 0), np.maximum(p, 0)
        if count < fewest:
            fewest = count
            patience = 10
        elif patience > 0:
            patience -= 1
        else:
            wrong[: np.flatnonzero(wrong)[-1]] = False
        contact ^= wrong
        if not contact.any():
            contact[lowest] = True
    raise AssertionError("the oracle found no solution")


def compliance(contact, sizes=(1.0, 1.0), E_star=1.0):
    """-d(mean gap)/dp with a fixed contact (boolean array): 1 + K v = 0 at all other points."""
    free = ~contact.ravel()
    K = stiffness(contact.shape, sizes, E_star)[np.ix_(free, free)]
    return float(np.linalg.solve(K, np.ones(len(K))).sum() / contact.size)


def solve_history(heights, loads, times, element=(0.0, 1.0), hardness=None, E_star=1.0):
    """Yield (Oracle, dents after it) of loads that follow each other by steps in time.

    element: (share r, time tau) of a Maxwell element, whose memory q of the displacement u relaxes.
    hardness: None without dents, by which the wall is lower in later steps; the gap of an Oracle is
    negative where it makes some.
    """
    z = np.asarray(heights, dtype=float)
    r, tau = element
    u = q = dents = np.zeros_like(z)
    for load, dt in zip(loads, np.diff(times, prepend=times[0])):
        e = np.exp(-dt / tau)
        f = (1 - e) * tau / dt if dt else 1.0
        k = 1 - r + r * f
        wall = z - dents + r * (e * q - f * u) / k
        if hardness is None:
            exact = solve(wall, load, E_star * k)
        else:
            exact = solve_yielding(wall, load, hardness, E_star * k)
        dents = dents + np.maximum(-exact.gap, 0)
        moved = np.maximum(exact.gap, 0) + z - z.max() - dents - u
        u, q = u + moved, e * q + f * moved
        yield exact, dents


def solve_yielding(heights, pressure, hardness, E_star=1.0, sizes=(1.0, 1.0), steps=200_000):
    """The Oracle where pressures are at most the hardness. Negative gaps are dents.

    u minimises

        1/2 <u, K u> + pressure <1, u> + hardness <1, max(-(u + h), 0)>

    by accelerated proximal gradients with adaptive restart (FISTA; O'Donoghue, Candes 2015), until
    a step changes less than rounding errors.
    """
    z = np.asarray(heights, dtype=float)
    q_x, q_y = (2 * np.pi * np.fft.fftfreq(n, size / n) for n, size in zip(z.shape, sizes))
    K = E_star / 2 * np.hypot(q_x[:, None], q_y[: z.shape[1] // 2 + 1])
    step = 1 / K.max()
    h = z.max() - z

    def pull(u):
        return np.fft.irfft2(K * np.fft.rfft2(u), z.shape)

    g = old = np.maximum(h - h.mean(), 0)
    inertia = 1.0
    for _ in range(steps):
        following = (1 + np.sqrt(1 + 4 * inertia**2)) / 2
        y = g + (inertia - 1) / following * (g - old)
        v = y - step * (pressure + pull(y - h))
        new = np.maximum(v, np.minimum(v + step * hardness, 0))
        change = new - g
        if np.sum((y - new) * change) > 0:
            following = 1.0
        old = g
        g = new
        inertia = following
        if np.abs(change).max() < 1e-15 * h.max():
            break
    p = pressure + pull(g - h)
    touching = (g <= 0) & (p > 0)
    energy = 0.5 * np.mean((g - h) * (p - pressure))
    gap = np.maximum(g, 0)
    return Oracle(
        np.clip(p, 0, hardness) * touching, g, g - h, np.mean(touching), gap.mean(), energy
    )
