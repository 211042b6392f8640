"""What the images of a surface that ends add to its displacement in a periodic cell, and how to take that out again.

S of free space and that of the cell differ by c(r), the sum over the images of the origin. Between points of a surface that leaves a
part of the cell free c is smooth: an operator T on the lowest modes of the cell gives it to seven digits. What T does beyond the
surface, where the pressure is 0, is arbitrary: it is the least one, in the norm of S, so that S + T is positive and nearly S. It leaves
the mean alone but for a constant: load control does not know which point is at rest.

Modes are products of cos (parity 1) and sin (-1) of both coordinates, from the middle of the surface, orthonormal over the cell; T does
not mix parities. Lengths are in any unit, E* = 1.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

NEEDED, ALONE = 20 / 3, 8  # modes along an axis, times the free part of the cell over its length; where the other axis is periodic
NODES = 3.0  # points of the surface at which c is met, over the modes
SOFTEST = 0.7  # S + T over S, about: of the mode that is free of charge by another choice of the constant
LEAST = 1e-7  # share of the largest singular value that counts
WIDTH = 0.08  # of the charge that is added and subtracted in the sum over images (Ewald), over the root of the cell's area
PARITIES = [(a, b) for a in (1, -1) for b in (1, -1)]


@dataclass(frozen=True)
class Images:
    """T by parities along x and y, (stack, m, m), of the modes in the order of `stacked`. S: of the half-space, of all modes k_x,
    k_y >= 0. constant: of the kernel, what T leaves to the mean: S of a uniform pressure on the whole cell, over its area."""

    T: dict[tuple[int, int], np.ndarray]
    S: np.ndarray
    free: tuple[bool, bool]
    modes: tuple[int, int]
    constant: float

    def stacked(self, a: np.ndarray) -> np.ndarray:
        """Numbers of modes (m_x, m_y) as T has them, (stack, m): a periodic axis does not couple."""
        if all(self.free):
            return a.reshape(1, -1)
        return a.T if self.free[0] else a

    def inverse(self, S: np.ndarray) -> dict[tuple[int, int], np.ndarray]:
        """(S + T)^-1 - 1/S, as T is stacked, 0 for the mean; S: of all modes k_x, k_y >= 0."""
        out = {}
        for (a, b), T in self.T.items():
            here = S[int(a < 0):, int(b < 0):].copy()
            if a > 0 and b > 0:
                here[0, 0] = 1.0
            here, diagonal = self.stacked(here), np.arange(T.shape[1])
            K = T.copy()
            K[:, diagonal, diagonal] += here
            K = np.linalg.inv(K)
            K[:, diagonal, diagonal] -= 1 / here
            out[a, b] = (K + K.transpose(0, 2, 1)) / 2
        return out


@lru_cache(maxsize=16)
def images(cell: tuple[float, float], inside: tuple[float, float], free: tuple[bool, bool], modes: tuple[int, int]) -> Images:
    """cell: sizes; inside: those of the surface in it; free: where it ends; modes: the highest along each axis."""
    k = {axis: {1: np.arange(modes[axis] + 1), -1: np.arange(1, modes[axis] + 1)} for axis in (0, 1)}
    q = 2 * np.pi * np.hypot(k[0][1][:, None] / cell[0], k[1][1] / cell[1])
    S = np.divide(2, q, out=np.zeros_like(q), where=q > 0)
    T, constant = {}, 0.0
    if all(free):
        x, y = (_Nodes(*pair) for pair in zip(cell, inside, modes))
        c = kernel(x.offsets, y.offsets, *cell)
        for a, b in PARITIES:
            D = sum(s * t * c[i][:, :, j] for s, i in x.pairs(a) for t, j in y.pairs(b))
            if a + b == 2:
                T[a, b], constant = _least(np.kron(x.basis[a], y.basis[b]), _square(D), q.ravel())
            else:
                T[a, b] = _separable(x.fit(a), y.fit(b), D)
        return Images({parity: found[None] for parity, found in T.items()}, S, free, modes, constant)
    along = int(free[1])  # the axis that ends
    x = _Nodes(cell[along], inside[along], modes[along])
    for a in (1, -1):
        stack = []
        for wave in k[1 - along][1]:
            c = kernel_of_wave(x.offsets, cell[along], 2 * np.pi * wave / cell[1 - along])
            D = sum(s * c[i] for s, i in x.pairs(a))
            stack.append(_least(x.basis[a], D, 2 * np.pi * np.hypot(k[along][a] / cell[along], wave / cell[1 - along]))[0])
        for b in (1, -1):
            T[(a, b) if along == 0 else (b, a)] = np.array(stack)[int(b < 0):]
    return Images(T, S, free, modes, np.nan)


class _Nodes:
    """Points of one half of the surface along an axis, for functions of either parity."""

    def __init__(self, cell: float, inside: float, modes: int):
        half = int(np.ceil(NODES * (modes + 1) / 2))
        self._i = np.arange(half)
        self.offsets = np.arange(2 * half) * (inside / (2 * half - 1))
        x, k = (self._i + 0.5) * (inside / (2 * half - 1)), np.arange(modes + 1)
        phase = 2 * np.pi / cell * np.outer(x, k)
        self.basis = {1: np.cos(phase) * np.where(k > 0, np.sqrt(2), 1) / np.sqrt(cell), -1: np.sin(phase[:, 1:]) * np.sqrt(2 / cell)}

    def fit(self, parity: int) -> tuple[np.ndarray, ...]:
        """U, s and V of the basis = U s V', V as S weights it."""
        basis = self.basis[parity]
        k = np.arange(basis.shape[1]) + (parity < 0)
        weights = np.maximum(k, 1.0) ** -0.5
        U, s, V = np.linalg.svd(basis * weights, full_matrices=False)
        return U, s, V.T * weights[:, None]

    def pairs(self, parity: int) -> list[tuple[float, np.ndarray]]:
        """The part of an even function of the distance that keeps a parity: weights, and which of the offsets they are of."""
        i, j = self._i[:, None], self._i
        return [(0.5, abs(i - j)), (0.5 * parity, i + j + 1)]


def _square(D: np.ndarray) -> np.ndarray:
    """A matrix over pairs (x, y) from D of (x, x', y, y')."""
    m, n = D.shape[0], D.shape[2]
    return D.transpose(0, 2, 1, 3).reshape(m * n, m * n)


def _separable(X: tuple[np.ndarray, ...], Y: tuple[np.ndarray, ...], D: np.ndarray) -> np.ndarray:
    """The same where no mode is the mean; X, Y: what `_Nodes.fit` gives, D of (x, x', y, y')."""
    (U, s, V), (W, t, Z) = X, Y
    size = np.outer(s, t)
    inverse = np.where(size > LEAST * size[0, 0], 1 / size, 0)
    G = np.einsum("ikjl,ia,kc,jb,ld->abcd", D, U, U, W, W, optimize=True) * np.multiply.outer(inverse, inverse)
    T = np.einsum("abcd,ka,lb,mc,nd->klmn", G, V, Z, V, Z, optimize=True).reshape(len(V) * len(Z), -1)
    return (T + T.T) / 2


def _least(basis: np.ndarray, D: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, float]:
    """T with basis T basis' = D, but for a constant, which is the second thing returned, the least one beside S = 2/q; none of the mean
    (q = 0)."""
    use = q > 0
    weights = q[use] ** -0.5
    U, s, V = np.linalg.svd(basis[:, use] * weights, full_matrices=False)
    U, s, V = (a[..., s > LEAST * s[0]] for a in (U, s, V.T))
    U, V = U / s, V.T
    G, constant = U.T @ D @ U, 0.0
    if not use.all():
        one = U.sum(axis=0)
        rigid = np.linalg.solve(np.eye(len(s)) + G, one)  # what a constant of 1/(one @ rigid) would make free of charge
        constant = float((1 - SOFTEST * (rigid @ rigid) / (one @ rigid)) / (one @ rigid))
        G = G - constant * np.outer(one, one)
    V = V * weights
    T = np.zeros((len(q), len(q)))
    T[np.ix_(use, use)] = V.T @ ((G + G.T) / 2) @ V
    return T, constant


def kernel(x: np.ndarray, y: np.ndarray, X: float, Y: float) -> np.ndarray:
    """c at the offsets x, y in a cell X, Y of which both axes are free: Ewald's sum, without the origin itself."""
    from scipy.special import erf, erfc

    sigma = WIDTH * np.sqrt(X * Y)
    r = np.hypot(x[:, None], y)
    with np.errstate(invalid="ignore"):
        c = np.where(r > 0, erf(r / 2 / sigma) / (np.pi * r), 1 / (np.pi**1.5 * sigma))
    last_i, last_j = (int(np.ceil(12 * sigma / length)) + 1 for length in (X, Y))
    for i in range(-last_i, last_i + 1):
        for j in range(-last_j, last_j + 1):
            if i or j:
                r = np.hypot(x[:, None] - i * X, y - j * Y)
                c -= erfc(r / 2 / sigma) / (np.pi * r)
    q_x, q_y = (2 * np.pi / length * np.arange(int(np.ceil(6.2 / sigma * length / (2 * np.pi))) + 1) for length in (X, Y))
    q = np.hypot(q_x[:, None], q_y)
    with np.errstate(divide="ignore"):
        S = np.where(q > 0, 2 / q * erfc(q * sigma), 0.0)
    S[1:] *= 2
    S[:, 1:] *= 2
    return c - (np.cos(np.outer(x, q_x)) @ S @ np.cos(np.outer(q_y, y)) - 4 * sigma / np.sqrt(np.pi)) / (X * Y)


def kernel_of_wave(x: np.ndarray, X: float, q: float) -> np.ndarray:
    """c of a wave q along the periodic axis at the offsets x along the other one, of length X."""
    from scipy.special import k0

    if q > 0:
        count = 1 + int(np.ceil(40 / (q * X)))
        return -2 / np.pi * sum(k0(q * abs(x - j * X)) for j in range(-count, count + 1) if j)
    with np.errstate(divide="ignore", invalid="ignore"):
        return 2 / np.pi * np.where(x > 0, np.log(2 * np.sin(np.pi * x / X) / x), np.log(2 * np.pi / X))
