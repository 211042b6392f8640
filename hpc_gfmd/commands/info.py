"""`hpc-gfmd info`: what this installation can do."""

from argparse import ArgumentParser, Namespace

HELP = "versions, MPI, parallel HDF5, FFT, threads"
DESCRIPTION = (
    "Print what this installation can do: versions, MPI, parallel HDF5, FFT, cores, memory."
)


def add_arguments(parser: ArgumentParser) -> None:
    """Leave the parser as it is: the command has no arguments."""
    del parser  # the command takes no arguments


def main(args: Namespace) -> int:
    """Print one line per fact about this installation; returns 0."""
    del args  # it has none
    for name, value in facts().items():
        print(f"{name + ':':16}{value}")
    return 0


def facts() -> dict[str, str]:
    """Collect what speed or results may depend on: versions, libraries, cores, memory, cache."""
    import h5py

    from ..parallel.fftw import load_fftw
    from ..solvers import solver_names
    from ..util.caches import cache_folder
    from ..util.machine import available_gib, cores
    from ..util.versions import processor, versions

    lines = dict(versions())
    lines["FFT"] = load_fftw()[0]
    lines["MPI"] = _mpi_library()
    lines["HDF5"] = f"{h5py.version.hdf5_version}, {_io()}"
    lines["solvers"] = "auto (bpx), " + ", ".join(solver_names())
    lines["cores"] = f"{len(cores())}, {processor()}"
    lines["memory"] = f"{available_gib():.1f} GiB free"
    lines["cache"] = str(cache_folder() or "none: no home folder (HPC_GFMD_CACHE names one)")
    return lines


def _io() -> str:
    """Describe how several ranks write a file: "parallel: ..." or "serial: ..."."""
    import h5py

    return (
        "parallel: several ranks write by MPI-IO (mpio)"
        if h5py.get_config().mpi
        else "serial: rank 0 writes for all (serial)"
    )


def _mpi_library() -> str:
    """Return name and version of the MPI library, or "none" with the reason; MPI is not started."""
    from ..util.errors import one_line

    try:
        import mpi4py

        mpi4py.rc.initialize = False
        from mpi4py import MPI
    except (ImportError, RuntimeError) as error:  # RuntimeError: it finds no MPI library
        return f"none ({one_line(str(error))})"
    return one_line(MPI.Get_library_version().split(",")[0].split("\n")[0])
