"""Green's function molecular dynamics on a small surface, with the printed or the right signs."""

import numpy as np

HURST = 0.8
N_SMALL = 32  # points along an axis
STEPS = 400
DT = 0.25  # time step; with ETA the dynamics are stable and slightly underdamped
ETA = 0.08  # damping
Q = np.hypot(*np.meshgrid(*2 * [np.fft.fftfreq(N_SMALL, 1 / N_SMALL)], indexing="ij"))


def small_surface() -> np.ndarray:
    """Return a small self-affine surface with h_rms = 1 and mean 0, peaks up."""
    noise = np.fft.fft2(np.random.default_rng(1).standard_normal(Q.shape))
    has_waves = (Q >= 2) & (N_SMALL / 4 >= Q)
    z = np.fft.ifft2(np.where(has_waves, noise / np.maximum(Q, 1) ** (1 + HURST), 0)).real
    return z / z.std()


def gfmd(damping: int = -1, load: int = -1, lifted: bool = False, steps: int = STEPS) -> dict:
    """Run the paper's pseudocode on a small surface at p* = 0.1; units: E* = 2, cell of 2 pi.

    The signs of damping and load are right as -1 and printed as +1; `lifted` starts at h_max
    instead of touching. Return the mean gap/h_rms ("gap") and the largest change of a displacement
    ("speed") of every step, and a_r.
    """
    z = small_surface()
    h = z.max() - z
    q_max = Q.max()
    p = 0.1 * np.sqrt(np.sum(Q**2 * np.abs(np.fft.fft2(z) / z.size) ** 2)) * 2  # p* = 0.1
    u = np.full_like(h, h.max() if lifted else 0.0)
    u_old = u.copy()
    gap = []
    speed = []
    for _ in range(steps):
        U = np.fft.fft2(u)
        U_old = np.fft.fft2(u_old)
        force = -Q * U
        force[0, 0] += load * p * z.size
        force += damping * ETA * q_max * (U - U_old) / DT
        with np.errstate(over="ignore", invalid="ignore"):
            u_new = np.maximum(np.fft.ifft2(2 * U - U_old + force * DT**2 / q_max * 4).real, -h)
            speed.append(float(np.abs(u_new - u).max()))
        u_old = u
        u = u_new
        gap.append(float(np.mean(u + h)))
        if not speed[-1] < 1e12:
            break
    return {"gap": gap, "speed": speed, "a_r": float(np.mean(u <= -h))}
