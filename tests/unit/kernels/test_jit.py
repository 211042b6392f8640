"""Kernels: how they are compiled, and points of a row that belong to the surface."""

import operator
import re

import numba
import numpy as np
import pytest
from numba import types

from hpc_gfmd.kernels.jit import FASTMATH, KernelCompiler, OperatorTypes, kernel, points_inside


@kernel
def counted_inside(shape, inside):
    count = 0
    for i in range(shape[0]):
        for _ in range(points_inside(i, inside)):
            count += 1
    return count


@pytest.mark.parametrize("inside", [(4, 6), (2, 5), (0, 6), (3, 0)])
def test_points_inside(inside):
    assert counted_inside((4, 6), inside) == inside[0] * inside[1]


def test_python_calls_a_piece():
    """It has no entry for Python: a kernel is made of the same function."""
    assert points_inside(1, (2, 3)) == 3
    assert points_inside(2, (2, 3)) == 0


def scaled(a, factor, out):
    """Set out = factor a."""
    for i in range(a.shape[0]):
        out[i] = factor * a[i]


def test_a_kernel_uses_vectors():
    compiled = numba.njit(
        "(f4[::1], f4, f4[::1])", fastmath=FASTMATH, pipeline_class=KernelCompiler, _nrt=False
    )(scaled)
    (code,) = compiled.inspect_llvm().values()
    assert re.search(r"fmul [\w ]*<\d+ x float>", code)
    out = np.zeros(77, np.float32)
    compiled(np.arange(77, dtype=np.float32), np.float32(3), out)
    np.testing.assert_array_equal(out, 3 * np.arange(77))


class CountedTypes:
    """A typing context that counts what it is asked for."""

    def __init__(self, context):
        self.context = context
        self.asked = 0

    def resolve_function_type(self, function, arguments, keywords):
        """Ask numba's own context."""
        self.asked += 1
        return self.context.resolve_function_type(function, arguments, keywords)


NUMBERS = [types.int64, types.uint64, types.float32, types.float64, types.complex128]


@pytest.mark.parametrize("operation", [operator.add, operator.truediv, operator.lt, operator.iadd])
def test_types_that_operators_return(operation, monkeypatch):
    """What is remembered is what numba itself finds; also that some operands are refused."""
    monkeypatch.setattr(OperatorTypes, "signatures", {})
    numbas = points_inside.targetdescr.typing_context
    numbas.refresh()
    counted = CountedTypes(numbas)
    remembering = OperatorTypes(counted)
    pairs = [(a, b) for a in NUMBERS for b in NUMBERS]
    expected = {}
    for pair in pairs:
        try:
            expected[pair] = numbas.resolve_function_type(operation, pair, {})
        except numba.TypingError:
            with pytest.raises(numba.TypingError):
                remembering.resolve_function_type(operation, pair, {})
    for _ in range(2):
        remembered = {
            pair: remembering.resolve_function_type(operation, pair, {}) for pair in expected
        }
        assert remembered == expected
    assert counted.asked == len(pairs)
