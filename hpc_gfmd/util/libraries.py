"""SurfaceTopography, imported without MPI."""

import sys
from typing import Any


def surface_topography() -> Any:
    """Import SurfaceTopography without MPI.

    With mpi4py it would start MPI in a process that no launcher started. Here every rank reads on
    its own.
    """
    if "NuMPI" not in sys.modules:
        mpi_modules = {
            name: sys.modules.pop(name)
            for name in list(sys.modules)
            if name.partition(".")[0] == "mpi4py"
        }
        sys.modules["mpi4py"] = None  # type: ignore[assignment]  # as if it were not installed
        try:
            import NuMPI  # noqa: F401
        finally:
            del sys.modules["mpi4py"]
            sys.modules.update(mpi_modules)
    import SurfaceTopography

    return SurfaceTopography
