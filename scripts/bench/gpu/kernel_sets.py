"""The two sets of kernels that are compared: compiled by numba, and written in CUDA C++."""

from pathlib import Path

import cupy as cp
import numpy as np

from .numba_kernels import bpx, multilevel, spectral


class NumbaKernels:
    """Kernels compiled by numba; update and restriction are two passes."""

    name = "numba"
    fused = False

    def __init__(self):
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
    """Kernels in CUDA C++, with update and restriction in one pass; none for levels."""

    name = "cuda"
    fused = True

    def __init__(self):
        source = Path(__file__).with_name("kernels.cu").read_text()
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

    def multiply(self, block, q_0, q_1, weight_0, weight_1, scale):
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
