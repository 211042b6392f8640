"""`hpc-gfmd info`: what this installation can do."""

from argparse import Namespace


def main(args: Namespace) -> int:
    """Print one line per fact."""
    for name, value in facts().items():
        print(f"{name + ':':16}{value}")
    return 0


def facts() -> dict[str, str]:
    """Collect {name: text} of everything that speed or results may depend on."""
    import h5py

    from ..parallel.fftw import fft_library
    from ..solvers import solver_names
    from ..util.caches import cache_folder
    from ..util.machine import available_gib, cores
    from ..util.versions import processor, versions

    found = dict(versions())
    found["FFT"] = fft_library()
    found["MPI"] = _mpi_library()
    found["HDF5"] = f"{h5py.version.hdf5_version}, {_io()}"
    found["solvers"] = "auto (bpx), " + ", ".join(solver_names())
    found["cores"] = f"{len(cores())}, {processor()}"
    found["memory"] = f"{available_gib():.1f} GiB free"
    found["cache"] = str(cache_folder() or "none: no home folder (HPC_GFMD_CACHE names one)")
    return found


def _io() -> str:
    """Say how several ranks write a file, as the attribute `io` of results does."""
    import h5py

    return (
        "parallel: several ranks write by MPI-IO (mpio)"
        if h5py.get_config().mpi
        else "serial: rank 0 writes for all (serial)"
    )


def _mpi_library() -> str:
    try:
        import mpi4py

        mpi4py.rc.initialize = False
        from mpi4py import MPI
    except ImportError as error:
        return f"none ({error})"
    return MPI.Get_library_version().split(",")[0].split("\n")[0]
