"""The decorators of all kernels, and how they are compiled."""

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numba
import numpy as np
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature

from ..util.errors import SceneError
from .cache import KernelFiles

# NaN and infinity must stay visible, so no "nnan" and "ninf"; "reassoc" is what lets a sum use the
# vector unit.
FASTMATH = {"reassoc", "contract", "nsz", "arcp"}


def kernel(function: Callable[..., Any], piece: bool = False) -> Any:
    """Make a function a kernel: compiled on first use, kept in a file, without the GIL; no arrays
    made. A `piece` is copied into others: called, it might differ in last bits between kept and new
    code. SceneError if NUMBA_DISABLE_JIT is set.
    """
    if numba.config.DISABLE_JIT:
        raise SceneError(
            "NUMBA_DISABLE_JIT: found in the environment, allowed: not set; the kernels call FFTW"
            " by its address, which only compiled code can"
        )
    options = {
        "nopython": True,
        "nogil": True,
        "error_model": "numpy",
        "fastmath": FASTMATH,
        "_nrt": False,  # no references are counted, as no arrays are made: 5 % of a small solve
        "forceinline": piece,
        "no_cpython_wrapper": piece,
        "no_cfunc_wrapper": True,
    }
    made_by = Piece if piece else Kernel
    return made_by(function, targetoptions=options)


kernel_of = cache(kernel)


class Kernel(CPUDispatcher):  # type: ignore[misc]
    """A kernel, whose compiled code is taken from a file of an earlier run if there is one."""

    def __init__(self, function: Callable[..., Any], *arguments: Any, **options: Any):
        super().__init__(function, *arguments, **options)
        self.files = KernelFiles.of(function, type(self).__name__)

    def compile(self, signature: Any) -> Any:
        """Return the entry of the code for some types of arguments, loaded or compiled."""
        types = tuple(normalize_signature(signature)[0])
        with global_compiler_lock:
            if self.files is not None and types not in self.overloads:
                code = self.files.load(types, self.targetctx)
                if code is None:
                    super().compile(signature)
                    self.files.save(types, self.overloads[types])
                else:
                    self.targetctx.insert_user_function(
                        code.entry_point, code.fndesc, [code.library]
                    )
                    self.add_overload(code)
            return super().compile(signature)


class Piece(Kernel):
    """A piece of kernels, which has no entry for Python."""

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel that is made of the same function: numba's own call would crash."""
        return kernel_of(self.py_func)(*arguments)


inline = partial(kernel, piece=True)


@inline
def points_inside(i: int, inside: tuple[int, int]) -> np.uint64:
    """Return how many points of row i are on the surface; unsigned, so that loops use vectors."""
    return np.uint64(inside[1] if i < inside[0] else 0)
