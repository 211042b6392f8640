"""One-dimensional transforms of many rows or columns at once, as kernels call them: FFTW through
mpi4py-fft, or scipy.fft where that is missing.

A transform is (address of a C function, plan): the function takes the plan and the addresses of
input and output, of the shapes and the alignment that were planned. Nothing is normalised.
"""

import ctypes
import weakref
from collections.abc import Sequence
from typing import Any

import numpy as np

from .fftw import PREFIXES, load_fftw

Transform = tuple[int, int]
FORWARD = -1  # signs and flag of FFTW
BACKWARD = 1
MEASURE = 0
CALL = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3)


class Plans:
    """The four transforms of a slab: rows forward and back, columns forward and back.

    Rows go from real to complex numbers and back, columns stay complex, in place. Planning
    measures, which overwrites the arrays; they must live as long as the plans.

    Parameters
    ----------
    real : ndarray, shape (R, n_y)
    half : ndarray, shape (R, n_y//2 + 1)
    blocks : sequence of ndarray, shape (columns, n_x)
        Scratch arrays of the shapes to plan for.

    Attributes
    ----------
    rows_forward, rows_backward : Transform
        Of R rows.
    columns_forward, columns_backward : dict of Transform
        By the number of columns.
    """

    def __init__(self, real: np.ndarray, half: np.ndarray, blocks: Sequence[np.ndarray]):
        plan = self._fftw if load_fftw() else self._scipy
        self._transforms: list[Any] = []
        self.rows_forward = plan("_r2c", real, half)
        self.rows_backward = plan("_c2r", half, real)
        self.columns_forward = {len(block): plan("", block, block, FORWARD) for block in blocks}
        self.columns_backward = {len(block): plan("", block, block, BACKWARD) for block in blocks}

    def _fftw(self, kind: str, x: np.ndarray, out: np.ndarray, *sign: int) -> Transform:
        """Plan by measurement a transform of FFTW from x to out, both of which are overwritten.

        kind: "_r2c", "_c2r", or "" with a sign. It keeps Python's lock, because FFTW plans for one
        thread at a time. The plan is destroyed with this object.
        """
        libraries = load_fftw()
        assert libraries is not None
        real = x.real.dtype.name
        library = libraries[real]
        prefix = PREFIXES[real]
        make = library[f"{prefix}plan_many_dft{kind}"]
        destroy = library[f"{prefix}destroy_plan"]
        make.restype = ctypes.c_void_p
        ends = [(a.ctypes.data_as(ctypes.c_void_p), None, 1, a.shape[1]) for a in (x, out)]
        n = ctypes.byref(ctypes.c_int(max(x.shape[1], out.shape[1])))
        plan = make(1, n, len(x), *ends[0], *ends[1], *sign, MEASURE)
        weakref.finalize(self, destroy, ctypes.c_void_p(plan))
        return _address(library[f"{prefix}execute_dft{kind}"]), plan

    def _scipy(self, kind: str, x: np.ndarray, out: np.ndarray, *sign: int) -> Transform:
        """Make a transform of scipy that is called like one of FFTW, see `_fftw`."""
        from scipy import fft

        back = {"axis": 1, "norm": "forward"}
        transform = {
            "_r2c": lambda a: fft.rfft(a, axis=1),
            "_c2r": lambda a: fft.irfft(a, n=out.shape[1], **back),
            "": lambda a: fft.fft(a, axis=1) if sign == (FORWARD,) else fft.ifft(a, **back),
        }[kind]

        if not self._transforms:
            self._called = CALL(self._call)
        self._transforms.append((transform, x, out))
        return _address(self._called), len(self._transforms)

    def _call(self, plan: int, source: int, target: int) -> None:
        """Run transform number `plan` of scipy on the memory at two addresses."""
        transform, x, out = self._transforms[plan - 1]
        _at(target, out)[...] = transform(_at(source, x))


def _at(address: int, like: np.ndarray) -> np.ndarray:
    """View the memory at an address as an array of the type and shape of `like`."""
    memory: Any = (ctypes.c_char * like.nbytes).from_address(address)
    return np.ndarray(like.shape, like.dtype, memory)


def _address(function: Any) -> int:
    """Return the address of a C function."""
    address = ctypes.cast(function, ctypes.c_void_p).value
    assert address is not None
    return address
