"""What images of a surface with free boundaries add to its displacement in a cell, and its inverse.

S of free space is S of the cell plus c(r), where -c is the sum over the images of the origin.
Between points of a surface that leaves part of the cell empty c is smooth: an operator T on the
lowest modes reproduces it to ten digits. Beyond the surface T is arbitrary: it is the least one in
the norm of S, so that S + T is positive and nearly S. T leaves the mean alone, up to a constant, as
load control does not know which point is at rest. Other modes have to represent the mean on the
surface; the more digits they give, the less S + T is like S: seven digits are a compromise.

Modes are products of cos (parity 1) and sin (-1) of both coordinates, from the middle of the
surface, orthonormal over the cell; T does not mix parities. Any unit of length, E* = 1.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..util.errors import SceneError

# modes along an axis, times the free part of the cell over its length; where the other axis is
# periodic
NEEDED = 20 / 3
ALONE = 11
NODES = 6.0  # points of the surface at which c is met, over the modes
LEAST = 1e-12  # product of two singular values, over the largest, that counts
SOFTEST = 0.65  # the least of S + T over S, about: of the modes that the constant is chosen by
# The largest, which says to which singular value over the largest, at least MEAN, other modes stand
# for the mean: with more digits a solve takes more iterations.
STIFFEST = 2.4
MEAN = 1e-8
# The constant of c between uniform lines, times pi/2, in any unit of length. It is free: with 1 to
# 1.6 S + T of few modes is most like S, far from there it is not positive.
UNIFORM = 1.5
# of the charge that is added and subtracted in the sum over images (Ewald), over the root of the
# cell's area
WIDTH = 0.08
PARITIES = [(a, b) for a in (1, -1) for b in (1, -1)]


@dataclass(frozen=True)
class Images:
    """The operator T on the lowest modes, added to S of a periodic cell to get S of free space.

    T[parities along x and y]: (stack, m, m), in the order of `stacked`; an axis of parity -1 lacks
    k = 0. `constant`: S of the mean over the area of the cell, nan if one axis is periodic. Shared:
    do not change the arrays.
    """

    T: dict[tuple[int, int], np.ndarray]
    free: tuple[bool, bool]
    modes: tuple[int, int]
    constant: float

    def stacked(self, a: np.ndarray) -> np.ndarray:
        """Arrange modes (m_x, m_y) as (stack, m): one row where both axes are free, else a row for
        each number along the periodic axis, since T couples only equal ones.
        """
        if all(self.free):
            return a.reshape(1, -1)
        return a.T if self.free[0] else a

    def inverse(self, S: np.ndarray) -> dict[tuple[int, int], np.ndarray]:
        """Return (S + T)^-1 - 1/S by parities, 0 for the mean; S: (m_x, m_y), k_x, k_y >= 0."""
        out = {}
        for (a, b), T in self.T.items():
            S_of_parity = S[int(a < 0) :, int(b < 0) :].copy()
            if a > 0 and b > 0:
                S_of_parity[0, 0] = 1.0
            diagonal = self.stacked(S_of_parity)[..., None]
            identity = np.eye(T.shape[1])
            K = np.linalg.inv(T + diagonal * identity) - identity / diagonal
            out[a, b] = (K + K.transpose(0, 2, 1)) / 2
        return out


@lru_cache(maxsize=16)
def images(
    cell: tuple[float, float],
    inside: tuple[float, float],
    free: tuple[bool, bool],
    modes: tuple[int, int],
) -> Images:
    """Return the operator T for one shape of the cell; `modes` are the highest mode numbers."""
    k_x, k_y = (np.arange(highest + 1) for highest in modes)
    q = 2 * np.pi * np.hypot(k_x[:, None] / cell[0], k_y / cell[1])
    T = {}
    axes = [_Nodes(*axis) for axis in zip(cell, inside, modes)]
    if all(free):
        X, Y = axes
        c = kernel(X.offsets, Y.offsets, *cell)
        T = {(a, b): _in_modes(c, (X, a), (Y, b))[None] for a, b in PARITIES}
        try:
            T[1, 1][0], constant = _without_mean(T[1, 1][0], q.ravel(), np.kron(X.even, Y.even))
        except np.linalg.LinAlgError:
            shape = max(cell) / min(cell)
            raise SceneError(
                f'surface.boundary: found "free" along both axes of a grid of {shape:.0f} : 1,'
                ' allowed: shorter grids, or "periodic" along the short axis'
            ) from None
        return Images(T, free, modes, constant / (cell[0] * cell[1]))
    along = int(free[1])  # the axis that ends
    X = axes[along]
    k, beside = (k_y, k_x) if along else (k_x, k_y)
    for a in (1, -1):
        waves = 2 * np.pi / cell[1 - along] * beside
        stack = [_in_modes(kernel_of_wave(X.offsets, cell[along], wave), (X, a)) for wave in waves]
        if a > 0:
            stack[0], _ = _without_mean(stack[0], 2 * np.pi / cell[along] * k, X.even)
        for b in (1, -1):
            T[(a, b) if along == 0 else (b, a)] = np.array(stack)[int(b < 0) :]
    return Images(T, free, modes, np.nan)


class _Nodes:
    """Points of one half of the surface along an axis, to fit functions of either parity.

    offsets: distances of all points from the first; fits: what `_fit` returns, by parity; even: the
    even modes at the points, rotated to as many rows as there are modes.
    """

    def __init__(self, cell: float, inside: float, modes: int):
        half = int(np.ceil(NODES * (modes + 1) / 2))
        step = inside / (2 * half - 1)
        self._i = np.arange(half)
        self.offsets = np.arange(2 * half) * step
        k = np.arange(modes + 1)
        phase = 2 * np.pi / cell * np.outer((self._i + 0.5) * step, k)
        even = np.cos(phase) * np.where(k > 0, np.sqrt(2), 1) / np.sqrt(cell)
        odd = np.sin(phase[:, 1:]) * np.sqrt(2 / cell)
        self.even: np.ndarray = np.linalg.qr(even)[1]
        self.fits = {1: self._fit(even, np.maximum(k, 1)), -1: self._fit(odd, k[1:])}

    @staticmethod
    def _fit(basis: np.ndarray, k: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return U, s, V (times the root of S again) of the SVD of a basis times the root of S."""
        root = k**-0.5  # of S, about
        U, s, V = np.linalg.svd(basis * root, full_matrices=False)
        return U, s, V.T * root[:, None]

    def pairs(self, parity: int) -> list[tuple[float, np.ndarray]]:
        """Return two terms, weight and indices to `offsets`, by which an even function of the
        distance acts on functions of a parity.
        """
        i = self._i[:, None]
        j = self._i
        return [(0.5, abs(i - j)), (0.5 * parity, i + j + 1)]


def _in_modes(D: np.ndarray, *axes: tuple[_Nodes, int]) -> np.ndarray:
    """Return the symmetric T for which basis T basis' is a kernel D of distances between points,
    given at the offsets of each axis. Modes below LEAST times the largest singular value are
    rounding errors.
    """
    fits = [nodes.fits[parity] for nodes, parity in axes]
    size = np.ones(())
    for (nodes, parity), (U, s, _) in zip(axes, fits):
        D = sum(share * D[i] for share, i in nodes.pairs(parity))
        D = np.tensordot(np.tensordot(D, U, (0, 0)), U, (0, 0))
        size = np.multiply.outer(size, np.outer(s, s))
    T = np.divide(D, size, out=np.zeros_like(D), where=size > LEAST * size.max())
    for *_, V in fits:
        T = np.tensordot(np.tensordot(T, V, (0, 1)), V, (0, 1))
    side = np.prod(T.shape[::2])
    T = T.transpose(*range(0, T.ndim, 2), *range(1, T.ndim, 2)).reshape(side, side)
    return (T + T.T) / 2


def _without_mean(T: np.ndarray, q: np.ndarray, basis: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the T that is the given one on the surface up to a constant, but 0 for the mean; the
    constant.

    basis: a column of values for each mode, the mean (q = 0) first. On the surface the mean is a
    combination m of the other modes. With t of the mean and A of the others in T, modes scaled to S
    = 1, T is A + m t' + t m' + x m m', where the constant makes x free. In the plane of m and t two
    eigenvalues relative to 1 + A differ from 1: x makes the smaller one SOFTEST; m has as many
    singular values as leave the larger below STIFFEST.
    """
    root = np.sqrt(2 / q[1:])  # of S
    U, s, V = np.linalg.svd(basis[:, 1:] * root, full_matrices=False)
    resolved = s > MEAN * s[0]
    V = V[resolved].T
    m = basis[:, 0] @ U[:, resolved] / s[resolved]
    A = V.T @ (T[1:, 1:] / np.outer(root, root)) @ V
    t = V.T @ (T[0, 1:] / root)
    u, v = np.linalg.solve(np.linalg.cholesky(np.eye(len(m)) + A), np.transpose([m, t])).T
    # of ever more singular values
    uu = np.cumsum(u * u)
    uv = np.cumsum(u * v)
    vv = np.cumsum(v * v)
    stiff = (1 - SOFTEST) * (STIFFEST - 1)
    count = max(int(np.searchsorted(uu * vv - uv**2, stiff)), 1)
    uu = uu[count - 1]
    uv = uv[count - 1]
    vv = vv[count - 1]
    V = V[:, :count]
    A = A[:count, :count]
    m = m[:count]
    t = t[:count]
    x = ((uu * vv - uv**2) / (1 - SOFTEST) - (1 - SOFTEST) - 2 * uv) / uu
    V = V * root[:, None]
    out = np.zeros_like(T)
    out[1:, 1:] = V @ (A + np.outer(m, t) + np.outer(t, m) + x * np.outer(m, m)) @ V.T
    return out, float(T[0, 0] - x)


def kernel(x: np.ndarray, y: np.ndarray, X: float, Y: float) -> np.ndarray:
    """Return c = S of free space minus S of the cell (which has no mean), both axes free, E* = 1.

    -c is the sum over all images of the origin but itself (Ewald); offsets 0 <= x < X, 0 <= y < Y.
    Shape (len(x), len(y)).
    """
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
    q_x, q_y = (
        2 * np.pi / length * np.arange(int(np.ceil(6.2 / sigma * length / (2 * np.pi))) + 1)
        for length in (X, Y)
    )
    q = np.hypot(q_x[:, None], q_y)
    with np.errstate(divide="ignore"):
        S = np.where(q > 0, 2 / q * erfc(q * sigma), 0.0)
    S[1:] *= 2
    S[:, 1:] *= 2
    return c - (
        np.cos(np.outer(x, q_x)) @ S @ np.cos(np.outer(q_y, y)) - 4 * sigma / np.sqrt(np.pi)
    ) / (X * Y)


def kernel_of_wave(x: np.ndarray, X: float, q: float) -> np.ndarray:
    """Return c at offsets x along the one free axis, between lines that carry the pressure of one
    wave q; for q = 0 up to a constant, which is UNIFORM. X: size of the cell.
    """
    from scipy.special import k0

    if q > 0:
        count = 1 + int(np.ceil(40 / (q * X)))
        return -2 / np.pi * sum(k0(q * abs(x - j * X)) for j in range(-count, count + 1) if j)
    return 2 / np.pi * (np.log(np.sinc(x / X)) + UNIFORM)
