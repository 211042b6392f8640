"""SurfaceTopography, imported without MPI."""

import sys
import warnings
from typing import Any


def surface_topography() -> Any:
    """Import SurfaceTopography with mpi4py hidden in sys.modules: else it would start MPI, without
    a launcher, and not every rank could read by itself.
    """
    if "NuMPI" not in sys.modules:
        mpi_modules = {
            name: sys.modules.pop(name)
            for name in list(sys.modules)
            if name.partition(".")[0] == "mpi4py"
        }
        sys.modules["mpi4py"] = None  # type: ignore[assignment]  # as if it were not installed
        try:
            with warnings.catch_warnings():  # it warns that it does not find mpi4py
                warnings.simplefilter("ignore", ImportWarning)
                import NuMPI  # noqa: F401
        finally:
            del sys.modules["mpi4py"]
            sys.modules.update(mpi_modules)
    import SurfaceTopography

    return SurfaceTopography
