"""Elastic contact of rough surfaces: Green's function molecular dynamics on slabs, from a laptop to a cluster.

`run("scene.toml")` solves a scene; `solve(heights, pressure)` solves a NumPy array on one process. Importing this package neither
starts MPI nor compiles anything.
"""

__version__ = "0.1.0"
__all__ = ["run", "solve"]


def run(scene, **how):
    """Solve a scene file (or scene.Scene) and write its result file; see simulation.run_scene."""
    from .simulation import run_scene

    return run_scene(scene, **how)


def solve(heights, pressure, E_star=1.0, physical_sizes=(1.0, 1.0), accuracy=None, **how):
    """Solve one contact of a NumPy array of heights on one process; see api.solve."""
    from .api import solve as solve_array

    return solve_array(heights, pressure, E_star, physical_sizes, accuracy, **how)
