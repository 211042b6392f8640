"""Odd contact problems to break solvers with, made from a seed."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Odd:
    """One contact problem for hpc_gfmd.solve; str() tells enough to make it again."""

    kind: str
    heights: np.ndarray
    pressure: float
    E_star: float
    sizes: tuple[float, float]
    settings: dict
    p_star: float
    scale: float

    def __str__(self):
        return (
            f"{self.kind} {self.heights.shape} p*={self.p_star:.3g} E*={self.E_star:.2g} heights x"
            f" {self.scale:.1g} sizes={self.sizes} {self.settings}"
        )

    def falsehood(self, solution):
        """What a converged solution says that is not true of its fields, or None."""
        if solution.status not in ("converged", "stagnated", "max_iterations", "nonfinite"):
            return f"unknown status {solution.status}"
        if solution.status != "converged":
            return None
        p, g = solution.pressure.astype(np.float64), solution.gap.astype(np.float64)
        if not (np.isfinite(p).all() and np.isfinite(g).all()):
            return "fields are not finite"
        if g.min() < 0:
            return "penetration"
        eps = max(self.settings.get("accuracy", 0.0), self.settings.get("residual", 0.0), 1e-5)
        if (
            abs(p.mean() - self.pressure)
            > eps * np.sqrt(np.mean((p / self.pressure) ** 2)) * self.pressure
        ):
            return f"load {p.mean() / self.pressure}"
        wrong = np.where((g > 0) | (p < 0), p, 0.0)
        if np.linalg.norm(wrong) > 1.01 * eps * np.linalg.norm(p):
            return f"pressure out of contact {np.linalg.norm(wrong) / np.linalg.norm(p):.2g}"
        touching = np.count_nonzero((g <= 0) & (p > 0))
        if touching != round(solution.a_r * p.size):
            return f"area {solution.a_r}, fields {touching / p.size}"
        return None


def _spectrum(rng, x, y, hurst):
    k = np.hypot(np.fft.fftfreq(len(x))[:, None], np.fft.fftfreq(len(y)))
    k[0, 0] = np.inf
    return np.fft.ifft2(np.fft.fft2(rng.standard_normal(k.shape)) * k ** (-1 - hurst)).real


SHAPES = {
    "rough": lambda rng, x, y: _spectrum(rng, x, y, rng.uniform(-0.5, 1)),
    "white noise": lambda rng, x, y: rng.standard_normal((len(x), len(y))),
    "sphere": lambda rng, x, y: -(x[:, None] ** 2 + y**2),
    "cone": lambda rng, x, y: -np.hypot(x[:, None], y),
    "flat punch": lambda rng, x, y: 1.0 * (np.hypot(x[:, None], y) < 0.25),
    "cylinder": lambda rng, x, y: -(x[:, None] ** 2) + 0 * y,
    "wave": lambda rng, x, y: (
        np.cos(2 * np.pi * x)[:, None] * np.cos(2 * np.pi * rng.integers(3) * y)
    ),
    "checkerboard": lambda rng, x, y: 1.0 * ((np.arange(len(x))[:, None] + np.arange(len(y))) % 2),
    "flat plane": lambda rng, x, y: np.zeros((len(x), len(y))),
    "staircase": lambda rng, x, y: np.round(
        3 * _spectrum(rng, x, y, 0.8) / (_spectrum(rng, x, y, 0.8).std() + 1e-9)
    ),
    "one asperity": lambda rng, x, y: (
        1.0 * ((np.arange(len(x))[:, None] == 0) & (np.arange(len(y)) == 0))
    ),
    "one pit": lambda rng, x, y: (
        -100.0 * ((np.arange(len(x))[:, None] == 0) & (np.arange(len(y)) == 0))
    ),
}
SIZES = ((2, 2), (1, 64), (97, 1), (2, 31), (3, 3), (31, 31), (101, 64))


def odd_problems(count, seed, n=(16, 256)):
    """`count` problems of all kinds in turn, with odd sizes, units, loads, targets and
    precisions."""
    rng = np.random.default_rng(seed)
    return [_odd_problem(rng, list(SHAPES)[i % len(SHAPES)], n) for i in range(count)]


def _odd_problem(rng, kind, n):
    if rng.random() < 0.15:
        n_x, n_y = SIZES[rng.integers(len(SIZES))]
    else:
        n_x = int(np.exp(rng.uniform(*np.log(n))))
        n_y = n_x if rng.random() < 0.7 else int(np.exp(rng.uniform(*np.log(n))))
    sizes = (1.0, n_y / n_x * (1.0 if rng.random() < 0.8 else rng.uniform(0.7, 1.4)))
    x, y = (np.arange(m) / m - 0.5 for m in (n_x, n_y))
    z = np.asarray(SHAPES[kind](rng, x, y), dtype=np.float64)
    scale = 10.0 ** rng.choice([-12, -3, 0, 0, 0, 3, 12])
    E_star = 10.0 ** rng.choice([-6, 0, 0, 3, 12])
    z *= scale
    slopes = [
        np.diff(np.concatenate([z, z.take([0], axis)], axis), axis=axis) * m / size
        for axis, (m, size) in enumerate(zip((n_x, n_y), sizes, strict=True))
    ]
    slope = np.sqrt(np.mean(np.square(slopes[0])) + np.mean(np.square(slopes[1])))
    p_star = float(10.0 ** rng.uniform(-6, 2))
    if rng.random() < 0.15:
        z += 1e6 * z.std() * rng.choice([-1, 1])
    precision = str(rng.choice(["auto", "single", "double"]))
    if rng.random() < 0.8:
        settings = {
            "accuracy": float(
                rng.choice(
                    [1e-2, 1e-3, 1e-4] if precision == "single" else [1e-2, 1e-3, 1e-4, 1e-6]
                )
            )
        }
    else:
        settings = {"residual": 1e-6 if precision != "single" else 1e-2}
    return Odd(
        kind,
        z,
        p_star * E_star * (slope or 1.0),
        E_star,
        sizes,
        settings | {"precision": precision},
        p_star,
        scale,
    )
