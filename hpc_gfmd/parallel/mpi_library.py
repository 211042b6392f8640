"""Import mpi4py, or say in one line why it cannot be imported."""

from types import ModuleType
from typing import Any

from ..util.errors import GfmdError, how_to_install, one_line

REBUILD = "pip install --force-reinstall --no-deps --no-cache-dir --no-binary=mpi4py mpi4py"


def load_mpi() -> Any:
    """Import and return mpi4py.MPI, which starts MPI unless mpi4py.rc says otherwise.

    Returns
    -------
    module
        mpi4py.MPI.

    Raises
    ------
    GfmdError
        If mpi4py is missing, or does not find the MPI library that it was built for.
    """
    try:
        import mpi4py
    except ImportError as error:
        raise GfmdError(
            f"mpi4py cannot be imported ({one_line(str(error))}): {how_to_install('mpi4py')}"
        ) from None
    return _load(mpi4py)


def _load(package: ModuleType) -> Any:
    """Import and return the MPI module of mpi4py.

    Raises GfmdError, which tells how to rebuild mpi4py, if that finds no MPI library.
    """
    try:
        from mpi4py import MPI
    except (ImportError, RuntimeError) as error:  # RuntimeError: of its wheels
        reason = one_line(str(error).partition("\n")[0])
        raise GfmdError(
            f"mpi4py {package.__version__} is installed but does not load an MPI library"
            f" ({reason}); it has to be built for the one that is here: {REBUILD}"
        ) from None
    return MPI
