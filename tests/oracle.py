"""A second opinion: elastic contact on a small grid by dense linear algebra. Nothing of the package
is used here.

K is built from matrices of the discrete Fourier transform, and the complementarity problem

    p = p0 + K u >= 0,   g = u + h >= 0,   p g = 0

is solved by principal pivoting: guess the contact, solve the linear system that it implies, move
the points that violate their sign. All of them at once as long as their number falls, otherwise
(Murty) the last one alone, which cannot cycle.
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
    """The matrix of K = (E*/2)|q|, |q| of the minimal image, for fields flattened row by row; over
    softness(|q|) if given."""
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
    """The contact of heights z (peaks up) under the mean pressure; returns an Oracle."""
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


def _complementary(K, b, first):
    """g, p >= 0 with p = b + K g and p g = 0."""
    contact = b > 0
    contact[first] = True
    fewest, patience = len(b) + 1, 10
    for _ in range(20000):
        free = ~contact
        g, p = np.zeros_like(b), np.zeros_like(b)
        if free.any():
            g[free] = np.linalg.solve(K[np.ix_(free, free)], -b[free])
        p[contact] = (b + K @ g)[contact]
        tiny = 1e-13 * max(np.abs(p).max(), np.abs(b).max())
        wrong = (contact & (p < -tiny)) | (free & (g < -tiny))
        count = int(wrong.sum())
        if count == 0:
            return np.maximum(g, 0), np.maximum(p, 0)
        if count < fewest:
            fewest, patience = count, 10
        elif patience > 0:
            patience -= 1
        else:
            wrong[: np.flatnonzero(wrong)[-1]] = False
        contact ^= wrong
        if not contact.any():
            contact[first] = True
    raise AssertionError("the oracle found no solution")


def compliance(contact, sizes=(1.0, 1.0), E_star=1.0):
    """-d(mean gap)/dp while the points of a boolean array stay in contact and the others, where 1 +
    K v = 0, out of it."""
    free = ~contact.ravel()
    K = stiffness(contact.shape, sizes, E_star)[np.ix_(free, free)]
    return float(np.linalg.solve(K, np.ones(len(K))).sum() / contact.size)
