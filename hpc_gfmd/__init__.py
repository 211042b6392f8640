"""Elastic contact of rough surfaces: Green's function molecular dynamics on slabs, from a laptop to a cluster.

`run("scene.toml")` solves a scene; `solve(heights, pressure)` solves a NumPy array on one process,
`solve(read_surface("scan.x3p"), "20 MPa", "50 GPa")` a measured surface. Importing this
package neither starts MPI nor compiles anything.
"""

__version__ = "1.0.0"
__all__ = ["read_surface", "run", "solve"]


def run(scene, **how):
    """Solve a scene file (or scene.Scene) and write its result file; see simulation.run_scene."""
    from .simulation import run_scene

    return run_scene(scene, **how)


def solve(heights, pressure, E_star=1.0, physical_sizes=(1.0, 1.0), accuracy=None, **how):
    """Solve one contact of a NumPy array of heights on one process; see api.solve."""
    from .api import solve as solve_array

    return solve_array(heights, pressure, E_star, physical_sizes, accuracy, **how)


def read_surface(path, **keys):
    """Read a height map of any format and prepare it, on one process.

    path: .npy, .npz, .txt, .csv, HDF5, NetCDF and what SurfaceTopography reads (.x3p, .gwy, .spm, ...); keys: those of the scene's
    [surface], such as physical_sizes=("10 um", "8 um"), unit="nm", detrend="tilt", fill="harmonic", crop=(x0, y0, x1, y1),
    mirror=True, window="hann", refine=2, downsample=2, flip=True, boundary="periodic", dataset="name". What the file says of sizes and
    units holds unless they are given here.
    Returns a surface.prepared.PreparedSurface, which `solve` takes: heights (n_x, n_y) and sizes in m where units are known, and
    `notes` on what may be wrong with them. Raises SceneError for what cannot be read, or has no sizes, no unit, no heights at some
    points, or edges that do not fit together.
    """
    from .surface.prepared import read_surface as read

    return read(path, **keys)
