"""Steps stored in half the bits, in kernels and in NumPy."""

import numpy as np
import pytest

from hpc_gfmd.kernels.bfloat16 import Decoded, decode, encode, encoded
from hpc_gfmd.kernels.jit import kernel


@kernel
def stored_and_read(number):
    return encode(number), decode(encode(number))


@pytest.mark.parametrize(("dtype", "rough"), [(np.float32, 1 / 128), (np.float64, 1e-7)])
def test_encoding_of_steps(random, dtype, rough):
    """Kernels and NumPy agree; magnitudes never grow, and infinities are kept."""
    numbers = np.concatenate(
        [random.standard_normal(999) * 10.0 ** random.integers(-30, 30, 999), [0, -np.inf, np.inf]]
    ).astype(dtype)
    stored = encoded(numbers, dtype)
    read = Decoded(stored)[:]
    assert stored.itemsize == numbers.itemsize // 2
    in_kernel = np.transpose([stored_and_read(number) for number in numbers])
    assert np.array_equal(in_kernel, [stored, read])
    assert np.allclose(read, numbers, rtol=rough, atol=0)
    assert dtype == np.float64 or np.all(np.abs(read) <= np.abs(numbers))
    assert read[-2:].tolist() == [-np.inf, np.inf]
