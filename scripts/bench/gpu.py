"""The passes of an iteration on a GPU: milliseconds, bytes, and share of the speed of a copy.

    python scripts/bench/gpu.py --n 4096 16384 32768 65536 --out gpu.jsonl

It needs CuPy and numba-cuda, and of this package only gpu_kernels/ beside it. Every kernel is first
compared with NumPy in double precision on random data; the transforms are compared with a
plane wave at every size. A row of a kernel that is wrong says so, and the exit status is 1.
"""

import argparse
import json
import statistics
import sys
import time
import traceback
from functools import partial
from pathlib import Path

import numpy as np

if not hasattr(np, "row_stack"):  # which some versions of numba-cuda still look for
    np.row_stack = np.vstack  # noqa: NPY201
sys.path[0] = str(Path(__file__).resolve().parents[1])

import cupy as cp  # noqa: E402
from cupy.cuda import cufft  # noqa: E402

FLOOR = 59  # bytes per point of an iteration if all passes were fused as on the CPU
MIB = 2**20
STEP = (np.float32(0.7), np.float32(0.2), np.float32(1.0), np.float32(0.6))
COARSEST = 512  # levels with fewer points along an axis stay on the CPU


class Rows:
    """Writes rows of numbers to a file and to the terminal as they come.

    Attributes
    ----------
    copy_speed : float
        Bytes per second, read and written, of a copy on the device.
    is_wrong : bool
        Whether a comparison has failed.
    """

    def __init__(self, out, seconds):
        self.file = open(out, "w") if out else None  # noqa: SIM115
        self.start = time.monotonic()
        self.seconds = seconds
        self.copy_speed = float("nan")
        self.is_wrong = False

    def left(self):
        """Return the seconds that are left."""
        return self.seconds - (time.monotonic() - self.start)

    def add(self, item, **numbers):
        """Write one row."""
        numbers["at"] = round(time.monotonic() - self.start, 1)
        text = json.dumps({"item": item, **numbers})
        if self.file:
            self.file.write(text + "\n")
            self.file.flush()
        print(text, flush=True)

    def add_time(self, item, n, milliseconds, traffic, **numbers):
        """Write the time of a pass; traffic: bytes that it must move."""
        speed = traffic / milliseconds * 1e3
        numbers["ms"] = round(milliseconds, 4)
        numbers["bytes_per_point"] = round(traffic / n**2, 2)
        numbers["GB_per_s"] = round(speed / 1e9, 1)
        numbers["share_of_copy"] = round(speed / self.copy_speed, 3)
        self.add(item, n=n, **numbers)

    def add_error(self, item, **numbers):
        """Write the exception that is being handled."""
        traceback.print_exc()
        sys.stderr.flush()
        self.is_wrong = True
        error = traceback.format_exc().strip().splitlines()[-1][:300]
        self.add(item, error=error, **numbers)

    def check(self, item, value, reference, tolerance, **numbers):
        """Write a row if a value differs from its reference; return whether it is right."""
        value = np.asarray(value, np.float64)
        reference = np.asarray(reference, np.float64)
        error = float(np.linalg.norm(value - reference) / max(np.linalg.norm(reference), 1e-300))
        is_right = bool(error <= tolerance)
        self.is_wrong |= not is_right
        self.add(f"check {item}", error=error, right=is_right, **numbers)
        return is_right


def timed(work, seconds=0.25, max_repeats=15):
    """Return the median of the milliseconds that a function takes on the device."""
    start = cp.cuda.Event()
    end = cp.cuda.Event()

    def once():
        start.record()
        work()
        end.record()
        end.synchronize()
        return cp.cuda.get_elapsed_time(start, end)

    once()
    milliseconds = once()
    count = int(min(max(seconds * 1e3 / max(milliseconds, 1e-3), 3), max_repeats))
    return statistics.median(once() for _ in range(count))


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


class NumbaKernels:
    """The kernels of the package, compiled by numba."""

    name = "numba"
    fused = False

    def __init__(self):
        from bench.gpu_kernels import bpx, multilevel, spectral

        self.step = bpx.step_on_rows
        self.change = bpx.change_on_rows
        self.restrict_state = bpx.restrict_on_rows
        self.restrict_level = multilevel.restrict_on_rows
        self.smooth = multilevel.smooth_on_rows
        self.multiply = spectral.multiply
        self.transpose = spectral.transpose

    def update(self, state, Kd, s, i0, i1):
        """Update and restrict the state on some rows; return the sums of the blocks."""
        partial = self.change(state.g, state.p, state.d[i0:i1], Kd, s, i0, i1)
        self.restrict_state(state.g, state.p, Kd, i0, i1, i0 > 0, state.levels[0])
        return partial


class RawKernels:
    """The same in CUDA C++, with update and restriction in one pass."""

    name = "cuda"
    fused = True

    def __init__(self):
        source = Path(__file__).with_name("gpu_source.cu").read_text()
        module = cp.RawModule(code=source)
        names = ("step_rows", "update_rows", "add_columns", "add_rows", "multiply_block")
        self.kernels = {name: module.get_function(name) for name in (*names, "transpose_tiles")}
        self.memory = {}

    def _scratch(self, name, shape, dtype):
        if name not in self.memory or self.memory[name].shape != shape:
            self.memory[name] = cp.empty(shape, dtype)
        return self.memory[name]

    def step(self, g, p, d, d_rows, i0, i1, z_1, step):
        """Make the step on some rows; return the sums of the blocks."""
        m = z_1.shape[1]
        grid = (-(-m // 128), -(-(i1 - i0) // 32))
        partial = cp.empty((grid[0] * grid[1], 1))
        rows = (np.int64(i0), np.int64(i1))
        arguments = (g, p, d, d_rows, *rows, z_1, np.int64(m), *step, partial)
        self.kernels["step_rows"](grid, (128,), arguments)
        return partial

    def update(self, state, Kd, s, i0, i1):
        """Update and restrict the state on some rows; return the sums of the blocks."""
        m = state.n // 2
        grid = (-(-m // 128), -(-(i1 - i0) // 32))
        partial = cp.empty((grid[0] * grid[1], 10))
        edges = self._scratch("edges", (grid[0], grid[1] * 17, 3), np.float32)
        below = self._scratch("below", (grid[1], 3, m), np.float32)
        before = self._scratch("before", (3, m), np.float32)
        if i0 == 0:
            before[...] = 0
        rows = (np.int64(i0), np.int64(i1))
        coarse = state.levels[0]
        step = np.float32(s)
        self.kernels["update_rows"](
            grid,
            (128,),
            (
                *(state.g, state.p, state.d[i0:i1], Kd, step, *rows),
                *(coarse, np.int64(m), edges, below, partial),
            ),
        )
        self.kernels["add_columns"](
            (-(-grid[0] // 128), grid[1]), (128,), (*rows, coarse, np.int64(m), edges, below)
        )
        self.kernels["add_rows"](grid, (128,), (*rows, coarse, np.int64(m), below, before))
        before[...] = below[-1]
        if i1 == state.n:
            coarse[:, m + 1] = before
        return partial

    def multiply(self, block, q_0, q_1, weight_0, weight_1, scale, inverse):
        """Multiply a part of a spectrum by scale K; return the energies of the blocks."""
        rows, columns = block.shape
        grid = (-(-columns // 128), -(-rows // 32))
        partial = cp.empty((grid[0] * grid[1], 1))
        factor = np.float32(scale * 0.5)
        shape = (np.int64(block.strides[0] // 8), np.int64(rows), np.int64(columns))
        arguments = (block, *shape, q_0, q_1, weight_0, weight_1, factor, partial)
        self.kernels["multiply_block"](grid, (128,), arguments)
        return partial

    def transpose(self, source, target):
        """Transpose a part of a spectrum."""
        rows, columns = source.shape
        pitches = (np.int64(source.strides[0] // 8), np.int64(target.strides[0] // 8))
        self.kernels["transpose_tiles"](
            (-(-columns // 32), -(-rows // 32)),
            (32, 8),
            (source, pitches[0], target, pitches[1], np.int64(rows), np.int64(columns)),
        )


class Convolution:
    """K d by FFT: rows in pieces, then blocks of columns, multiplied by K = |q|/2.

    Parameters
    ----------
    n : int
        Points along each axis.
    spectrum : array (n, pitch) complex64
        Memory; pitch >= n/2 + 1.
    real : array (R, n) float32
        Scratch of a piece of rows.
    kernels : object
        Its multiply and transpose.
    transposes : bool
        Whether a block of columns is transposed to scratch, to be transformed there.
    block_bytes : int
        Largest size of a block of columns.
    """

    def __init__(self, n, spectrum, real, kernels, transposes, block_bytes):
        self.n = n
        self.spectrum = spectrum
        self.real = real
        self.kernels = kernels
        self.transposes = transposes
        n_c = n // 2 + 1
        pitch = spectrum.shape[1]
        R = real.shape[0]
        self.forward = row_plan(n, pitch, R, cufft.CUFFT_R2C)
        self.backward = row_plan(n, pitch, R, cufft.CUFFT_C2R)
        count = -(-n_c * n * 8 // block_bytes)
        W = -(-n_c // count)
        W = -(-W // 32) * 32 if W > 32 else W
        self.blocks = [(j, min(j + W, n_c)) for j in range(0, n_c, W)]
        stride, dist = (1, n) if transposes else (pitch, 1)
        self.plans = {
            w: cufft.PlanNd(
                (n,), (n,), stride, dist, (n,), stride, dist, cufft.CUFFT_C2C, w, "C", 0, None
            )
            for w in {j1 - j0 for j0, j1 in self.blocks}
        }
        self.scratch = cp.empty((W if transposes else 0, n), np.complex64)
        q = 2 * np.pi * np.fft.fftfreq(n)
        weight = np.full(n_c, 2.0)
        weight[0] = weight[-1] = 1
        self.q_x = cp.asarray(q.astype(np.float32))
        self.q_y = cp.asarray(np.abs(q[:n_c]).astype(np.float32))
        self.weight = cp.asarray(weight.astype(np.float32))
        self.ones = cp.ones(n, np.float32)

    def pieces(self):
        """Return the first row of each piece, and the one after it."""
        R = self.real.shape[0]
        return [(i, i + R) for i in range(0, self.n, R)]

    def on_pieces(self, transform):
        """Call transform(first row) for each piece."""
        for i0, _ in self.pieces():
            transform(i0)

    def store(self, i0):
        """Transform the rows in `real` to the spectrum, from row i0 on."""
        self.forward.fft(self.real, self.spectrum[i0:], cufft.CUFFT_FORWARD)

    def load(self, i0):
        """Transform spectra from row i0 on back to `real`."""
        self.backward.fft(self.spectrum[i0:], self.real, cufft.CUFFT_INVERSE)

    def columns(self):
        """Multiply the columns by K; return the sums of all blocks of all launches."""
        kernels = self.kernels
        scale = 1.0 / self.n**2
        partials = []
        for j0, j1 in self.blocks:
            part = self.spectrum[:, j0:j1]
            plan = self.plans[j1 - j0]
            q_y = self.q_y[j0:j1]
            weight = self.weight[j0:j1]
            if self.transposes:
                block = self.scratch[: j1 - j0]
                kernels.transpose(part, block)
                plan.fft(block, block, cufft.CUFFT_FORWARD)
                partials.append(
                    kernels.multiply(block, q_y, self.q_x, weight, self.ones, scale, False)
                )
                plan.fft(block, block, cufft.CUFFT_INVERSE)
                kernels.transpose(block, part)
            else:
                plan.fft(part, part, cufft.CUFFT_FORWARD)
                partials.append(
                    kernels.multiply(part, self.q_x, q_y, self.ones, weight, scale, False)
                )
                plan.fft(part, part, cufft.CUFFT_INVERSE)
        return partials

    def pair(self):
        """Transform all rows, the columns, and the rows back."""
        for i0, _ in self.pieces():
            self.store(i0)
        self.columns()
        for i0, _ in self.pieces():
            self.load(i0)

    def error_of_wave(self):
        """Return the error of K times a plane wave, relative to its largest value."""
        n = self.n
        k_x = n // 3
        k_y = n // 7
        phase_x = 2 * np.pi / n * (np.arange(n) * k_x % n)
        phase_y = 2 * np.pi / n * (np.arange(n) * k_y % n)
        cos_x, sin_x = (
            cp.asarray(f(phase_x).astype(np.float32))[:, None] for f in (np.cos, np.sin)
        )
        cos_y, sin_y = (cp.asarray(f(phase_y).astype(np.float32)) for f in (np.cos, np.sin))

        def wave(i0, i1):
            return cos_x[i0:i1] * cos_y - sin_x[i0:i1] * sin_y

        self.spectrum[...] = np.nan
        for i0, i1 in self.pieces():
            self.real[...] = wave(i0, i1)
            self.store(i0)
        energy = float(sum(partial.sum() for partial in self.columns()))
        K = np.pi / n * np.hypot(k_x, k_y)
        error = 0.0
        for i0, i1 in self.pieces():
            self.load(i0)
            difference = self.real - np.float32(K) * wave(i0, i1)
            error = max(error, float(cp.abs(difference).max()) / K)
        error = float(max(error, abs(energy / (0.5 * K * n**2) - 1)))
        return error if np.isfinite(error) else float("inf")


def row_plan(n, pitch, rows, kind):
    """Return a plan of transforms of rows to spectra (R2C) or back (C2R)."""
    real = ((n,), 1, n)
    half = ((pitch,), 1, pitch)
    source, target = (real, half) if kind == cufft.CUFFT_R2C else (half, real)
    return cufft.PlanNd((n,), *source, *target, kind, rows, "C", -1, n)


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


def measure_copies(rows):
    """Measure copies on the device, and between it and the host."""
    count = 2**30
    source = random_field((count,))
    target = cp.empty_like(source)
    size = source.nbytes

    def copy():
        cp.cuda.runtime.memcpyAsync(target.data.ptr, source.data.ptr, size, 3, 0)

    milliseconds = timed(copy)
    rows.copy_speed = 2 * size / milliseconds * 1e3
    rows.add("copy on the device", ms=milliseconds, GB_per_s=round(rows.copy_speed / 1e9, 1))
    milliseconds = timed(lambda: cp.multiply(source, np.float32(2), out=target))
    rows.add(
        "scale on the device", ms=milliseconds, GB_per_s=round(2 * size / milliseconds / 1e6, 1)
    )
    size = 2**28
    pinned = np.frombuffer(cp.cuda.alloc_pinned_memory(size), np.uint8, size)
    pageable = np.ones(size, np.uint8)
    pinned[...] = 1
    for name, host in (("pinned", pinned), ("pageable", pageable)):
        pointer = host.ctypes.data
        for direction, ends in (
            ("to the device", (target.data.ptr, pointer, size, 1)),
            ("to the host", (pointer, target.data.ptr, size, 2)),
        ):
            milliseconds = timed(lambda ends=ends: cp.cuda.runtime.memcpy(*ends), 0.1, 5)
            speed = round(size / milliseconds / 1e6, 2)
            rows.add(f"copy {direction}, {name}", ms=milliseconds, GB_per_s=speed)


def measure_launch(rows, kernels):
    """Measure how long Python takes to launch a small kernel, in microseconds."""
    block = cp.ones((64, 64), np.complex64)
    ones = cp.ones(64, np.float32)
    for count in (20, 200):
        cp.cuda.Device().synchronize()
        begin = time.perf_counter()
        for _ in range(count):
            kernels.multiply(block, ones, ones, ones, ones, 1.0, False)
        queued = time.perf_counter() - begin
        cp.cuda.Device().synchronize()
        ended = time.perf_counter() - begin
    rows.add(
        "launch",
        kernels=kernels.name,
        us_to_queue=round(queued / count * 1e6, 1),
        us=round(ended / count * 1e6, 1),
    )


def measure_pairs(rows, n, spectrum, real, sets, strided):
    """Measure FFT pairs of one size; return the fastest Convolution that is right, and its ms."""
    best = None
    n_c = n // 2 + 1
    if strided:
        variants = [(sets[0], False, 256 * MIB), (sets[0], False, 2**40)]
    else:
        compared = sets if n < 2**16 else sets[:1]
        variants = [(kernels, True, size * MIB) for kernels in compared for size in (16, 32, 256)]
    for kernels, transposes, block_bytes in variants:
        if rows.left() < 25:
            rows.add("skipped", n=n, reason="no time left")
            break
        for pitch in (n_c, -(-n_c // 32) * 32) if strided or block_bytes == 32 * MIB else (n_c,):
            flat = spectrum.reshape(-1)[: n * pitch]
            named = {"transposes": transposes, "block_MiB": block_bytes // MIB}
            named |= {"pitch": pitch, "kernels": kernels.name}
            try:
                convolution = Convolution(
                    n, flat.reshape(n, pitch), real, kernels, transposes, block_bytes
                )
                named["columns"] = convolution.blocks[0][1]
                error = convolution.error_of_wave()
                right = bool(error < 1e-4)
                rows.is_wrong |= not right
                forward = timed(partial(convolution.on_pieces, convolution.store))
                columns = timed(convolution.columns)
                backward = timed(partial(convolution.on_pieces, convolution.load))
                total = forward + columns + backward
                traffic = (56 if transposes else 40) * n * n
                rows.add_time(
                    "pair",
                    n,
                    total,
                    traffic,
                    forward_ms=round(forward, 3),
                    columns_ms=round(columns, 3),
                    backward_ms=round(backward, 3),
                    right=right,
                    error=error,
                    **named,
                )
                if right and (best is None or total < best[1]):
                    best = (convolution, total)
                del convolution
            except Exception:
                rows.add_error("pair", n=n, **named)
            cp.get_default_memory_pool().free_all_blocks()
    return best


def measure_passes(rows, n, state, real, kernels):
    """Measure the row passes, restriction and smoothing one by one; return the sum in ms."""
    points = n * n
    R = real.shape[0]
    pieces = [(i, i + R) for i in range(0, n, R)]
    z_1 = state.levels[0][0]
    named = {"kernels": kernels.name}

    def search():
        for i0, i1 in pieces:
            kernels.step(state.g, state.p, state.d, real, i0, i1, z_1, STEP)

    def update():
        for i0, i1 in pieces:
            kernels.update(state, real, np.float32(1e-3), i0, i1)

    total = milliseconds = timed(search)
    rows.add_time("search", n, milliseconds, 17 * points, **named)
    milliseconds = timed(update)
    total += milliseconds
    bytes_of_update = 25 if kernels.fused else 37
    rows.add_time("update and restriction", n, milliseconds, bytes_of_update * points, **named)
    if not kernels.fused:

        def change():
            for i0, i1 in pieces:
                kernels.change(state.g, state.p, state.d[i0:i1], real, np.float32(1e-3), i0, i1)

        rows.add_time("update alone", n, timed(change), 22 * points, **named)
    return total


def measure_levels(rows, n, state, kernels):
    """Measure restriction and smoothing of level 1, and the same of all levels; return its ms."""
    points = n * n
    levels = state.levels
    fine = levels[0]
    coarse = levels[1]
    weight = np.float32(0.4)
    damping = np.float32(1.6)

    def restrict(k):
        kernels.restrict_level(levels[k][:2], levels[k + 1], 0, levels[k].shape[2])

    def smooth(k):
        level = levels[k]
        kernels.smooth(level, levels[k + 1][0], level[0], weight, damping, 0, level.shape[2])

    def sweep():
        for k in range(len(levels) - 1):
            restrict(k)
        for k in reversed(range(len(levels) - 1)):
            smooth(k)

    named = {"kernels": kernels.name}
    traffic = 2 * fine[0].nbytes + 2 * coarse[0].nbytes
    rows.add_time("restriction of level 1", n, timed(lambda: restrict(0)), traffic, **named)
    traffic = 4 * fine[0].nbytes + coarse[0].nbytes
    rows.add_time("smoothing of level 1", n, timed(lambda: smooth(0)), traffic, **named)
    milliseconds = timed(sweep)
    rows.add_time("levels", n, milliseconds, 9 * points, levels=len(levels) - 1, **named)
    return milliseconds, sweep


def measure_size(rows, n, sets, piece_bytes):
    """Measure everything at one size."""
    free, _ = cp.cuda.runtime.memGetInfo()
    pitch = -(-(n // 2 + 1) // 32) * 32
    needed = int((8 * n * pitch + 10 * n * n + 4.1 * n * n) + 3 * piece_bytes + 1.5e9)
    if needed > free:
        rows.add("skipped", n=n, reason="memory", needed_GB=needed / 1e9, free_GB=free / 1e9)
        return
    R = min(n, max(piece_bytes // (4 * n), 1))
    spectrum = cp.empty((n, pitch), np.complex64)
    real = random_field((R, n), 0.01)
    strided_fits = n * pitch < 2**31
    best = measure_pairs(rows, n, spectrum, real, sets, False)
    if strided_fits:
        also = measure_pairs(rows, n, spectrum, real, sets, True)
        found = [variant for variant in (best, also) if variant]
        best = min(found, key=lambda variant: variant[1], default=None)
    state = State(n)
    real[...] = random_field((R, n), 0.01)
    passes = {}
    for kernels in sets:
        try:
            passes[kernels.name] = measure_passes(rows, n, state, real, kernels)
        except Exception:
            rows.add_error("passes", n=n, kernels=kernels.name)
    levels = float("nan")
    sweep = None
    try:
        with_levels = [kernels for kernels in sets if hasattr(kernels, "smooth")]
        levels, sweep = measure_levels(rows, n, state, with_levels[0])
    except Exception:
        rows.add_error("levels", n=n)
    if best:
        convolution, pair = best
        for kernels in sets:
            if kernels.name not in passes:
                continue
            parts = pair + passes[kernels.name] + levels
            measure_iteration(rows, n, state, convolution, kernels, sweep, parts)
    if not strided_fits:
        measure_pairs(rows, n, spectrum, real, sets, True)


def measure_iteration(rows, n, state, convolution, kernels, sweep, parts):
    """Measure a whole iteration; parts: the sum of its parts in ms."""

    def iteration():
        z_1 = state.levels[0][0]
        sums = []
        for i0, i1 in convolution.pieces():
            part = kernels.step(state.g, state.p, state.d, convolution.real, i0, i1, z_1, STEP)
            sums.append(part.sum())
            convolution.store(i0)
        sums += [part.sum() for part in convolution.columns()]
        for i0, i1 in convolution.pieces():
            convolution.load(i0)
            part = kernels.update(state, convolution.real, np.float32(1e-6), i0, i1)
            sums.append(part.sum())
        if sweep:
            sweep()

    try:
        milliseconds = timed(iteration)
        free, total = cp.cuda.runtime.memGetInfo()
        rows.add_time(
            "iteration",
            n,
            milliseconds,
            FLOOR * n * n,
            kernels=kernels.name,
            sum_of_parts_ms=round(parts, 3),
            floor_ms=round(FLOOR * n * n / rows.copy_speed * 1e3, 3),
            transposes=convolution.transposes,
            columns=convolution.blocks[0][1],
            with_levels=sweep is not None,
            GiB_in_use=round((total - free) / 2**30, 2),
        )
    except Exception:
        rows.add_error("iteration", n=n, kernels=kernels.name)


def checked_sets(rows):
    """Return the sets of kernels that can be compiled, compared with NumPy."""
    sets = []
    for make in (RawKernels, NumbaKernels):
        try:
            begin = time.monotonic()
            kernels = make()
            check_passes(rows, kernels)
            check_transforms(rows, kernels)
            if hasattr(kernels, "smooth"):
                check_levels(rows, kernels)
            sets.append(kernels)
            rows.add("compiled", kernels=kernels.name, seconds=time.monotonic() - begin)
            measure_launch(rows, kernels)
        except Exception:
            rows.add_error("kernels", kernels=make.__name__)
    return sets


def main():
    """Measure what the command line asks for; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--n", type=int, nargs="+", default=[4096, 16384, 32768, 65536])
    parser.add_argument("--out", help="file of rows, one JSON object a line")
    parser.add_argument("--seconds", type=float, default=150.0, help="in which all must end")
    parser.add_argument("--piece", type=int, default=256, help="MiB of a piece of rows")
    arguments = parser.parse_args()
    rows = Rows(arguments.out, arguments.seconds)
    device = cp.cuda.runtime.getDeviceProperties(0)
    free, total = cp.cuda.runtime.memGetInfo()
    versions = {"python": sys.version.split()[0], "numpy": np.__version__, "cupy": cp.__version__}
    for name in ("numba", "numba_cuda"):
        try:
            versions[name] = __import__(name).__version__
        except Exception as error:
            versions[name] = str(error)
    rows.add(
        "device",
        name=device["name"].decode(),
        multiprocessors=device["multiProcessorCount"],
        L2_MiB=device["l2CacheSize"] / MIB,
        free_GiB=round(free / 2**30, 1),
        total_GiB=round(total / 2**30, 1),
        runtime=cp.cuda.runtime.runtimeGetVersion(),
        **versions,
    )
    try:
        measure_copies(rows)
    except Exception:
        rows.add_error("copies")
    cp.get_default_memory_pool().free_all_blocks()
    sets = checked_sets(rows)
    for n in arguments.n if sets else []:
        if rows.left() < 20:
            rows.add("skipped", n=n, reason="no time left")
            continue
        try:
            measure_size(rows, n, sets, arguments.piece * MIB)
        except Exception:
            rows.add_error("size", n=n)
        cp.get_default_memory_pool().free_all_blocks()
    rows.add("end", right=not rows.is_wrong)
    return int(rows.is_wrong)


if __name__ == "__main__":
    sys.exit(main())
