"""Comparisons of the kernels and transforms with NumPy in double precision."""

import cupy as cp
import numpy as np

from .convolution import Convolution
from .state import STEP, State, random_field


def check_passes(rows, kernels, n=256):
    """Compare the kernels of an iteration with NumPy in double precision."""
    named = {"kernels": kernels.name, "n": n}
    state = State(n)
    with_halo(state.levels[0])
    z_1 = state.levels[0][0]
    g = state.g.get().astype(np.float64)
    p = state.p.get().astype(np.float64)
    last_step = np.where(state.d.get() == 0xFF80, 0.0, decoded(state.d, g))
    alpha, beta, coupling, compliance = (float(x) for x in STEP)
    Pz = interpolated(z_1.get()[1:-1].astype(np.float64))
    step = np.maximum(g - alpha * compliance * (p + coupling * Pz) - beta * last_step, 0) - g
    in_A = (g <= 0) & (p > 0)
    step[in_A] = 0
    d_rows = cp.full((n, n), np.nan, np.float32)
    sums = []
    for i0 in range(0, n, n // 2):
        i1 = i0 + n // 2
        part = kernels.step(state.g, state.p, state.d, d_rows[i0:i1], i0, i1, z_1, STEP)
        sums.append(float(part.sum()))
    made = d_rows.get().astype(np.float64)
    rows.check("search, step", made, step, 1 / 128, **named)
    rows.check("search, stored", decoded(state.d, g), made, 1e-6, **named)
    rows.check("search, rd", sum(sums), (np.where(in_A, 0, p) * made).sum(), 1e-5, **named)
    Kd_all = random_field((n, n), 0.2)
    Kd = Kd_all.get().astype(np.float64)
    s = 0.9
    state.levels[0][...] = np.nan
    sums = np.zeros(10)
    for i0 in range(0, n, n // 2):
        i1 = i0 + n // 2
        sums += kernels.update(state, Kd_all[i0:i1], np.float32(s), i0, i1).sum(axis=0).get()
    s = float(np.float32(s))
    g_new = state.g.get().astype(np.float64)
    p_new = state.p.get().astype(np.float64)
    rows.check("update, g", g_new, g + s * made, 1e-6, **named)
    rows.check("update, p", p_new, p + s * Kd, 1e-6, **named)
    t = ((g_new <= 0) & (p_new > 0)).astype(float)
    r = (1 - t) * p_new
    free = (1 - t) * Kd
    opening = (t > 0) & (p_new + s * Kd <= 0)
    closing = (g_new > 0) & (g_new + s * made <= 0)
    reference = [(r * r).sum(), (p_new**2).sum(), (r * made).sum(), (free * made).sum()]
    reference += [(r * free).sum(), t.sum(), g_new.sum(), opening.sum(), closing.sum(), 0]
    for k, name in enumerate(
        ["rr", "pp", "rd", "dKd", "rKd", "contact", "gap", "opening", "closing", "yielded"]
    ):
        rows.check(f"update, {name}", sums[k], reference[k], 1e-4, **named)
    fields = np.stack([full_weighting(field) for field in (r, t, free)])
    rows.check("update, level 1", periodic(state.levels[0]), fields, 1e-6, **named)


def check_levels(rows, kernels, n=256):
    """Compare restriction and smoothing of a level with NumPy in double precision."""
    named = {"kernels": kernels.name, "n": n}
    fine = random_field((3, n + 2, n))
    cp.absolute(fine[1], out=fine[1])
    coarse = cp.full((2, n // 2 + 2, n // 2), np.nan, np.float32)
    kernels.restrict_level(fine[:2], coarse, 0, n)
    r, t, x = fine.get()[:, 1:-1].astype(np.float64)
    reference = np.stack([full_weighting(r), full_weighting(t)])
    rows.check("restriction", periodic(coarse), reference, 1e-6, **named)
    z_1 = random_field((1, n // 2 + 2, n // 2))
    with_halo(z_1)
    weight = np.float32(0.4)
    damping = np.float32(1.6)
    sums = kernels.smooth(fine, z_1[0], fine[0], weight, damping, 0, n).sum(axis=0).get()
    z = r / (float(weight) + float(damping) * t) + interpolated(z_1[0].get()[1:-1])
    rows.check("smoothing, z", fine[0].get()[1:-1], z, 1e-6, **named)
    reference = [r * z, x * z, r * r, t * t, r * t, t, r]
    for k, product in enumerate(reference):
        scale = np.abs(product).sum()
        rows.check(f"smoothing, sum {k}", sums[k] / scale + 1, product.sum() / scale + 1, 1e-5)


def check_transforms(rows, kernels, n=256):
    """Compare the FFT pair, both ways, with NumPy in double precision on random rows."""
    for transposes in (True, False):
        for pitch in (n // 2 + 1, n // 2 + 32):
            spectrum = cp.full((n, pitch), np.nan, np.complex64)
            real = cp.empty((n // 4, n), np.float32)
            convolution = Convolution(n, spectrum, real, kernels, transposes, 8 * n * 40)
            x = random_field((n, n))
            u = x.get().astype(np.float64)
            for i0, i1 in convolution.pieces():
                real[...] = x[i0:i1]
                convolution.store(i0)
            energy = float(sum(part.sum() for part in convolution.columns()))
            made = np.empty((n, n))
            for i0, i1 in convolution.pieces():
                convolution.load(i0)
                made[i0:i1] = real.get()
            q = 2 * np.pi * np.fft.fftfreq(n)
            K = 0.5 * np.hypot(q[:, None], np.abs(q[: n // 2 + 1]))
            Ku = np.fft.irfft2(K * np.fft.rfft2(u), s=(n, n))
            named = {"kernels": kernels.name, "transposes": transposes, "pitch": pitch}
            rows.check("pair, K u", made, Ku, 1e-5, **named)
            rows.check("pair, energy", energy, (u * Ku).sum(), 1e-4, **named)


def full_weighting(fine):
    """Restrict a periodic field in NumPy."""
    along_x = fine[::2] + 0.5 * (fine[1::2] + np.roll(fine, 1, 0)[::2])
    return 0.25 * (along_x[:, ::2] + 0.5 * (along_x[:, 1::2] + np.roll(along_x, 1, 1)[:, ::2]))


def interpolated(coarse):
    """Interpolate a periodic field in NumPy."""
    m = coarse.shape[0]
    half = np.empty((2 * m, m))
    half[::2] = coarse
    half[1::2] = 0.5 * (coarse + np.roll(coarse, -1, 0))
    fine = np.empty((2 * m, 2 * m))
    fine[:, ::2] = half
    fine[:, 1::2] = 0.5 * (half + np.roll(half, -1, 1))
    return fine


def with_halo(level):
    """Set the halo rows of fields on the device to those of a periodic field."""
    level[:, 0] = level[:, -2]
    level[:, -1] = level[:, 1]


def periodic(level):
    """Return restricted fields in NumPy, with what belongs to the first row added to it."""
    fields = level.get().astype(np.float64)[:, 1:]
    fields[:, 0] += fields[:, -1]
    return fields[:, :-1]


def decoded(d, g):
    """Return what stored steps stand for, in NumPy."""
    d = d.get()
    number = (d.astype(np.uint32) << 16).view(np.float32)
    return np.where(d == 0xFF80, -g, number.astype(np.float64))
