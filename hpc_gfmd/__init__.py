"""Elastic contact of rough surfaces: Green's function molecular dynamics on slabs, from a laptop to
a cluster.

    import hpc_gfmd
    surface = hpc_gfmd.read_surface("scan.x3p")             # or make_surface(...), or a NumPy array
    solution = hpc_gfmd.solve(surface, "20 MPa", "50 GPa")  # a list of loads gives Solutions
    solution.plot()
    solution.save("contact.h5")
    solutions = hpc_gfmd.load("contact.h5")                 # the same from a result file
    hpc_gfmd.run("scene.toml")                              # as the command line does

`reference` has contact areas and mean gaps of self-affine surfaces with their uncertainties.
Importing this package neither starts MPI nor compiles anything; its parts are imported when they
are first used.
"""

__version__ = "1.0.0"

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .output.interface_law import InterfaceLaw
    from .output.law_files import read_law, write_law
    from .parallel.guard import on_rank_0
    from .parallel.world import world
    from .plotting import plot
    from .runs.interface_law import interface_law
    from .runs.many import solve_many
    from .runs.prepared import PreparedSurface, make_surface, prepare_surface, read_surface
    from .runs.simulation import RunResult
    from .runs.simulation import run_scene as run
    from .runs.solution import Interrupted, Solution, Solutions, load
    from .runs.solve import solve
    from .theory import reference
    from .util.errors import GfmdError, NotConverged, SceneError

__all__ = [
    "GfmdError",
    "InterfaceLaw",
    "Interrupted",
    "NotConverged",
    "PreparedSurface",
    "RunResult",
    "SceneError",
    "Solution",
    "Solutions",
    "interface_law",
    "load",
    "make_surface",
    "on_rank_0",
    "plot",
    "prepare_surface",
    "read_law",
    "read_surface",
    "reference",
    "run",
    "solve",
    "solve_many",
    "world",
    "write_law",
]
_PLACES = {
    "GfmdError": "util.errors",
    "InterfaceLaw": "output.interface_law",
    "interface_law": "runs.interface_law",
    "read_law": "output.law_files",
    "write_law": "output.law_files",
    "Interrupted": "runs.solution",
    "NotConverged": "util.errors",
    "PreparedSurface": "runs.prepared",
    "RunResult": "runs.simulation",
    "SceneError": "util.errors",
    "Solution": "runs.solution",
    "Solutions": "runs.solution",
    "load": "runs.solution",
    "make_surface": "runs.prepared",
    "on_rank_0": "parallel.guard",
    "plot": "plotting",
    "prepare_surface": "runs.prepared",
    "read_surface": "runs.prepared",
    "run": "runs.simulation:run_scene",
    "solve": "runs.solve",
    "solve_many": "runs.many",
    "world": "parallel.world",
}


def __getattr__(name: str) -> object:
    """Import what is public when it is first asked for."""
    from importlib import import_module

    if name == "reference":
        return import_module(".theory.reference", __name__)
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, _, attribute = _PLACES[name].partition(":")
    found = globals()[name] = getattr(import_module(f".{module}", __name__), attribute or name)
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
