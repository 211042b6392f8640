"""The decorators of all kernels, and how they are compiled."""

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.registry import CPUDispatcher

from .cache import compiled_on_first_use

# NaN and infinity must stay visible, so no "nnan" and "ninf"; "reassoc" is what lets a sum use the
# vector unit.
FASTMATH = {"reassoc", "contract", "nsz", "arcp"}
# Passes of numba for what no kernel contains: functions within it, functions whose source is copied
# in, and expressions of whole arrays.
NEEDLESS = {"InlineClosureLikes", "InlineInlinables", "InlineOverloads", "NopythonRewrites"}


def kernel(function: Callable[..., Any], piece: bool = False) -> Any:
    """Make a function a kernel: compiled on first use, kept in the cache, run without the GIL.

    Parameters
    ----------
    function : function
        Of arrays and numbers. It must not make arrays: counting references, also of every row that
        a loop takes, would be slow. Nor may it contain functions.
    piece : bool
        Set for a piece of other kernels: it is copied into theirs. If it were called instead, code
        from the cache and code that has just been compiled would contain different copies of it,
        and results could differ in the last bits.

    Returns
    -------
    function
        Called as the one that was given. When Python calls a piece, a kernel is made of the same
        function.
    """
    compiled = compiled_on_first_use(
        function,
        variant="piece" if piece else "",
        nogil=True,
        error_model="numpy",
        fastmath=FASTMATH,
        _nrt=False,
        forceinline=piece,
        no_cpython_wrapper=piece,
        no_cfunc_wrapper=True,
        pipeline_class=KernelCompiler,
    )
    if piece:
        compiled.__class__ = Piece
    return compiled


kernel_of = cache(kernel)


class Piece(CPUDispatcher):
    """A piece of other kernels, which has no entry for Python."""

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel that is made of the same function: numba's own call would crash."""
        return kernel_of(self.py_func)(*arguments)


class KernelCompiler(CompilerBase):  # type: ignore[misc]
    """numba's compiler without what kernels do not need."""

    def define_pipelines(self) -> list:
        """Return the passes from Python's bytecode to machine code."""
        state = self.state
        if state.flags.forceinline:
            state.library = PieceLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
            state.library.enable_object_caching()
        pipeline = DefaultPassBuilder.define_nopython_pipeline(state)
        pipeline.passes = [each for each in pipeline.passes if each[0].__name__ not in NEEDLESS]
        pipeline.finalize()
        return [pipeline]


class PieceLibrary(JITCodeLibrary):  # type: ignore[misc]
    """What LLVM makes of a piece: it is optimised as a whole, and becomes machine code, only within
    the kernels that it is copied into.

    numba's own library would do both for every piece as well. Should a version of numba not call
    this method, it does so again, which only takes longer.
    """

    def _optimize_final_module(self) -> None:
        """Make no machine code of the functions that are always copied."""
        for function in self._final_module.functions:
            if not function.is_declaration and b"alwaysinline" in b" ".join(function.attributes):
                function.linkage = "available_externally"


inline = partial(kernel, piece=True)


@inline
def points_inside(i: int, inside: tuple[int, int]) -> np.uint64:
    """Return how many points of row i belong to the surface: the first ones of the row.

    The number is unsigned: a loop that begins at a number that might be negative, counted from the
    end, does not use vectors.

    Parameters
    ----------
    i : int
        Local row.
    inside : (int, int)
        Rows and points of this rank's part of the surface.

    Returns
    -------
    np.uint64
        0 in a row beyond the surface.
    """
    return np.uint64(inside[1] if i < inside[0] else 0)
