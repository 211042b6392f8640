"""Kernels use the vector instructions of the processor."""

import re

import numpy as np

from hpc_gfmd.kernels.jit import kernel


def scaled(a, factor, out):
    """Set out = factor a."""
    for i in range(a.shape[0]):
        out[i] = factor * a[i]


def test_a_kernel_uses_vectors():
    compiled = kernel(scaled)
    compiled.files = None  # code from a file cannot be looked at
    compiled.compile("(f4[::1], f4, f4[::1])")
    (code,) = compiled.inspect_llvm().values()
    assert re.search(r"fmul [\w ]*<\d+ x float>", code)
    out = np.zeros(77, np.float32)
    compiled(np.arange(77, dtype=np.float32), np.float32(3), out)
    np.testing.assert_array_equal(out, 3 * np.arange(77))
