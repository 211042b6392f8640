"""FFTW as kernels call it: addresses, and plans for many rows or columns; nothing is normalised."""

import ctypes
import os
import sys
import weakref
from collections.abc import Sequence
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from ..util.errors import SceneError

Transform = tuple[int, int]  # a C function (plan, input, output), and the plan
VARIABLE = "HPC_GFMD_FFTW"  # "mkl", or files of another library with FFTW's interface
# where the libraries are, {} standing for the letter of a precision
PACKAGES = {"mpi4py_fft": "fftw/fftw{}_xfftn.*", "pyfftw": "libfftw3{}[-.]*"}
PREFIXES = {"float64": "fftw_", "float32": "fftwf_"}  # of the functions, by precision
FORWARD = -1  # signs and flag of FFTW
BACKWARD = 1
MEASURE = 0


@cache
def load_fftw() -> tuple[str, dict[str, ctypes.PyDLL]]:
    """Return the library's name and, by precision, what has its functions; packages are searched,
    not imported (mpi4py-fft would start MPI). SceneError without a library.
    """
    setting = os.environ.get(VARIABLE)
    if setting:
        files = _files_of_mkl() if setting == "mkl" else setting.split(os.pathsep)
        if libraries := _with_functions(files):
            return f"FFTW ({setting})", libraries
        raise SceneError(f"{VARIABLE}: {setting!r} has no FFTW in single and double precision")
    for package, pattern in PACKAGES.items():
        if libraries := _with_functions(_files_of(package, pattern)):
            return f"FFTW ({package.replace('_', '-')})", libraries
    raise SceneError("FFTW is missing: pip install pyfftw")


def _with_functions(files: Sequence[str]) -> dict[str, ctypes.PyDLL]:
    """Return the library of each precision among some files; none unless both are there."""
    libraries: dict[str, ctypes.PyDLL] = {}
    for file in files:
        try:
            library = ctypes.PyDLL(file)  # keeps Python's lock: FFTW plans on one thread at a time
        except OSError:
            continue
        for real, prefix in PREFIXES.items():
            if hasattr(library, f"{prefix}plan_many_dft"):
                libraries.setdefault(real, library)
    if len(libraries) < len(PREFIXES):
        return {}
    for real, library in libraries.items():
        # The first call starts the threads of FFTW, which forgets the wisdom read before it.
        if hasattr(library, f"{PREFIXES[real]}plan_with_nthreads"):
            library[f"{PREFIXES[real]}plan_with_nthreads"](1)
    return libraries


def _files_of(package: str, pattern: str) -> list[str]:
    """Return the libraries of a package: in its folder, or where wheels keep what they bring."""
    spec = find_spec(package)
    return [
        str(file)
        for folder in map(Path, (spec and spec.submodule_search_locations) or [])
        for place in (folder, folder / ".dylibs", folder.with_name(f"{package}.libs"))
        for precision in ("", "f")
        for file in place.glob(pattern.format(precision))
    ]


def _files_of_mkl() -> list[str]:
    """Return the names under which MKL may be found: of pip, conda, modules or the system."""
    folders = [Path(sys.prefix, "lib"), Path(os.environ.get("MKLROOT", sys.prefix), "lib")]
    files = [str(file) for folder in folders for file in folder.glob("libmkl_rt.*")]
    return [*files, "libmkl_rt.so", "libmkl_rt.so.2", "libmkl_rt.so.3"]


class Plans:
    """The four transforms of a slab, in place, of rows (R, n_y) and columns by their number
    (columns, n_x). Planning overwrites the arrays, which must outlive the plans.
    """

    def __init__(self, real: np.ndarray, half: np.ndarray, blocks: Sequence[np.ndarray]):
        self.rows_forward = self._plan("_r2c", real, half)
        self.rows_backward = self._plan("_c2r", half, real)
        self.columns_forward = {len(a): self._plan("", a, a, FORWARD) for a in blocks}
        self.columns_backward = {len(a): self._plan("", a, a, BACKWARD) for a in blocks}

    def _plan(self, kind: str, x: np.ndarray, out: np.ndarray, *sign: int) -> Transform:
        """Plan by measurement a transform of rows of x; kind: "_r2c", "_c2r", or "" with a sign."""
        real = x.real.dtype.name
        prefix = PREFIXES[real]
        library = load_fftw()[1][real]
        make = library[f"{prefix}plan_many_dft{kind}"]
        make.restype = ctypes.c_void_p
        ends = [(ctypes.c_void_p(a.ctypes.data), None, 1, a.shape[1]) for a in (x, out)]
        n = ctypes.byref(ctypes.c_int(max(x.shape[1], out.shape[1])))
        plan = make(1, n, len(x), *ends[0], *ends[1], *sign, MEASURE)
        weakref.finalize(self, library[f"{prefix}destroy_plan"], ctypes.c_void_p(plan))
        address = ctypes.cast(library[f"{prefix}execute_dft{kind}"], ctypes.c_void_p).value
        assert address is not None
        return address, plan
