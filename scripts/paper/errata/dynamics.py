"""Green's function molecular dynamics on a small surface, with the signs as printed or as they
should be."""

import numpy as np

HURST = 0.8
N_SMALL, STEPS = 32, 400
DT, ETA = 0.25, 0.08  # time step and damping: stable and slightly underdamped
Q = np.hypot(*np.meshgrid(*2 * [np.fft.fftfreq(N_SMALL, 1 / N_SMALL)], indexing="ij"))


def small_surface() -> np.ndarray:
    """Make a small self-affine surface, h_rms = 1, mean 0, peaks up."""
    noise = np.fft.fft2(np.random.default_rng(1).standard_normal(Q.shape))
    keep = (Q >= 2) & (N_SMALL / 4 >= Q)
    z = np.fft.ifft2(np.where(keep, noise / np.maximum(Q, 1) ** (1 + HURST), 0)).real
    return z / z.std()


def gfmd(damping: int = -1, load: int = -1, lifted: bool = False, steps: int = STEPS) -> dict:
    """Run the paper's dynamics on a small surface, in units E* = 2, cell 2 pi, as its pseudocode
    but for the two signs.

    damping, load: -1 is right, +1 is printed. lifted: start at h_max instead of touching. Returns
    {"gap": mean gap/h_rms of every step, "speed": largest change of a displacement in every step,
    "a_r"}.
    """
    z = small_surface()
    h = z.max() - z
    q_max = Q.max()
    p = 0.1 * np.sqrt(np.sum(Q**2 * np.abs(np.fft.fft2(z) / z.size) ** 2)) * 2  # p* = 0.1
    now = np.full_like(h, h.max() if lifted else 0.0)
    old, gap, speed = now.copy(), [], []
    for _ in range(steps):
        u, before = np.fft.fft2(now), np.fft.fft2(old)
        force = -Q * u
        force[0, 0] += load * p * z.size
        force += damping * ETA * q_max * (u - before) / DT
        with np.errstate(over="ignore", invalid="ignore"):
            new = np.maximum(np.fft.ifft2(2 * u - before + force * DT**2 / q_max * 4).real, -h)
            speed.append(float(np.abs(new - now).max()))
        old, now = now, new
        gap.append(float(np.mean(now + h)))
        if not speed[-1] < 1e12:
            break
    return {"gap": gap, "speed": speed, "a_r": float(np.mean(now <= -h))}
