"""Fields like those of a solve, on the device."""

import cupy as cp
import numpy as np

# alpha, beta, coupling, compliance of the search pass
STEP = (np.float32(0.7), np.float32(0.2), np.float32(1.0), np.float32(0.6))
COARSEST = 512  # levels with fewer points along an axis stay on the CPU


def random_field(shape, sigma=1.0):
    """Return normal numbers on the device in single precision, made a few rows at a time."""
    field = cp.empty(shape, np.float32)
    flat = field.reshape(-1)
    piece = 2**26
    block = cp.asarray(np.random.default_rng(1).normal(size=2**20).astype(np.float32) * sigma)
    block = cp.tile(block, 64)
    for i in range(0, flat.size, piece):
        part = flat[i : i + piece]
        part[...] = block[: part.size] * np.float32(1 + 1e-3 * (i // piece))
    return field


class State:
    """Fields of a solve of n x n points: gap, pressure, step, and levels 1, 2, ...

    About half of the points touch, and some of the others carry pressure.
    """

    def __init__(self, n):
        self.n = n
        self.g = random_field((n, n))
        self.p = cp.empty((n, n), np.float32)
        self.d = cp.empty((n, n), np.uint16)
        for i in range(0, n, max(n // 64, 1)):
            rows = slice(i, i + max(n // 64, 1))
            g = self.g[rows]
            self.p[rows] = cp.where(g <= 0, -g, np.float32(0.1) * cp.roll(g, 7, axis=1))
            cp.maximum(g, 0, out=g)
            step = np.float32(0.1) * cp.roll(self.p[rows], 3, axis=1)
            self.d[rows] = (step.view(np.uint32) >> 16).astype(np.uint16)
            self.d[rows][:, ::5] = 0xFF80
        self.levels = []
        m = n // 2
        while m >= min(COARSEST, n // 4):
            fields = 3 if not self.levels else 2
            level = random_field((fields, m + 2, m), 0.1)
            cp.absolute(level[1], out=level[1])
            self.levels.append(level)
            m //= 2
