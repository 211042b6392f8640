"""SurfaceTopography, imported without MPI."""

import sys
from typing import Any


def surface_topography() -> Any:
    """Import SurfaceTopography. It would start MPI where no launcher did; here every rank reads for
    itself, so it gets none."""
    if "NuMPI" not in sys.modules:
        known = {
            name: sys.modules.pop(name)
            for name in list(sys.modules)
            if name.partition(".")[0] == "mpi4py"
        }
        sys.modules["mpi4py"] = None  # type: ignore[assignment]  # as if it were not installed
        try:
            import NuMPI  # noqa: F401
        finally:
            del sys.modules["mpi4py"]
            sys.modules.update(known)
    import SurfaceTopography

    return SurfaceTopography
