"""FFT pairs on a GPU in several layouts."""

import cupy as cp
import numpy as np
from cupy.cuda import cufft


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
                partials.append(kernels.multiply(block, q_y, self.q_x, weight, self.ones, scale))
                plan.fft(block, block, cufft.CUFFT_INVERSE)
                kernels.transpose(block, part)
            else:
                plan.fft(part, part, cufft.CUFFT_FORWARD)
                partials.append(kernels.multiply(part, self.q_x, q_y, self.ones, weight, scale))
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
