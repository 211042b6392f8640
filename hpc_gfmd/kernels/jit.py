"""The decorators of all kernels, and how they are compiled."""

from collections.abc import Callable
from functools import cache, partial
from types import BuiltinFunctionType
from typing import Any, ClassVar

import numba
import numpy as np
from llvmlite import binding
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature

from ..util.errors import SceneError
from .cache import KernelFiles

# NaN and infinity must stay visible, so no "nnan" and "ninf"; "reassoc" is what lets a sum use the
# vector unit.
FASTMATH = {"reassoc", "contract", "nsz", "arcp"}
# Passes of numba for what no kernel contains: functions within it, functions whose source is copied
# in, and expressions of whole arrays.
NEEDLESS = {"InlineClosureLikes", "InlineInlinables", "InlineOverloads", "NopythonRewrites"}


def kernel(function: Callable[..., Any], piece: bool = False) -> Any:
    """Make a function a kernel: compiled on first use, kept in a file, without the GIL; no arrays
    made, no functions within. A `piece` is copied into others: called, it might differ in last bits
    between kept and new code. SceneError if NUMBA_DISABLE_JIT is set.
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
        "_nrt": False,
        "forceinline": piece,
        "no_cpython_wrapper": piece,
        "no_cfunc_wrapper": True,
    }
    made_by = Piece if piece else Kernel
    return made_by(function, targetoptions=options, pipeline_class=KernelCompiler)


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


class KernelCompiler(CompilerBase):  # type: ignore[misc]
    """numba's compiler without what kernels do not need."""

    def define_pipelines(self) -> list:
        """Return the passes from Python's bytecode to machine code."""
        state = self.state
        state.typingctx = OperatorTypes(state.typingctx)
        library = PieceLibrary if state.flags.forceinline else KernelLibrary
        state.library = library(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        pipeline = DefaultPassBuilder.define_nopython_pipeline(state)
        pipeline.passes = [each for each in pipeline.passes if each[0].__name__ not in NEEDLESS]
        pipeline.finalize()
        return [pipeline]


class OperatorTypes:
    """numba's typing context with a memory of operators' types, which saves 7 % of compile time."""

    signatures: ClassVar[dict] = {}  # of operations: by operator and types of its operands

    def __init__(self, context: Any):
        self.context = context

    def __getattr__(self, name: str) -> Any:
        """Return what numba's own context has under a name."""
        return getattr(self.context, name)

    def resolve_function_type(self, function: Any, arguments: tuple, keywords: dict) -> Any:
        """Return the signature with which a function takes arguments of given types, or None."""
        operator = getattr(function, "typing_key", function)
        if keywords or not isinstance(operator, BuiltinFunctionType):
            return self.context.resolve_function_type(function, arguments, keywords)
        operation = (operator, arguments)
        if operation not in self.signatures:
            self.signatures[operation] = self.context.resolve_function_type(function, arguments, {})
        return self.signatures[operation]


class KernelLibrary(JITCodeLibrary):  # type: ignore[misc]
    """What LLVM makes of a kernel: vectors, but no unrolled loops, which are slow to compile."""

    def _optimize_functions(self, module: Any) -> None:
        """Tidy up each function by itself, before pieces are copied into it."""
        module.data_layout = str(self.codegen.target_data)
        passes = _llvm_passes(*self.codegen.magic_tuple(), speed_level=1)
        tidy = passes.getFunctionPassManager()
        for function in module.functions:
            if not function.is_declaration:
                tidy.run(function, passes)

    def _optimize_final_module(self) -> None:
        """Optimise a kernel together with its pieces."""
        passes = _llvm_passes(*self.codegen.magic_tuple(), speed_level=3)
        passes.getModulePassManager().run(next(self.get_defined_functions()).module, passes)


class PieceLibrary(KernelLibrary):
    """What LLVM makes of a piece: machine code only within the kernels that it is copied into."""

    def _optimize_final_module(self) -> None:
        """Make no machine code of the functions that are always copied."""
        for function in self.get_defined_functions():
            if b"alwaysinline" in b" ".join(function.attributes):
                function.linkage = "available_externally"


def _llvm_passes(triple: str, processor: str, features: str, speed_level: int) -> Any:
    """Return LLVM's passes of a level of optimisation, 0 to 3, for a processor."""
    options = binding.create_pipeline_tuning_options(speed_level)
    options.loop_vectorization = True
    options.loop_unrolling = False
    return binding.create_pass_builder(_target(triple, processor, features), options)


@cache
def _target(triple: str, processor: str, features: str) -> Any:
    """Return LLVM's knowledge of a processor, by which it chooses the width of vectors."""
    target = binding.Target.from_triple(triple)
    return target.create_target_machine(cpu=processor, features=features, opt=3)


inline = partial(kernel, piece=True)


@inline
def points_inside(i: int, inside: tuple[int, int]) -> np.uint64:
    """Return how many points of row i are on the surface; unsigned, so that loops use vectors."""
    return np.uint64(inside[1] if i < inside[0] else 0)
