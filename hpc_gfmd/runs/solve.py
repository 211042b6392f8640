"""Contacts in memory, for notebooks and scripts: as a run, without files."""

import warnings
from collections.abc import Sequence
from typing import Any, overload

import numpy as np

from ..output.summary import converged
from ..parallel.world import comm_of
from ..scene import Scene
from ..surface.doubtful_numbers import load_notes
from ..util.errors import NotConverged, SurfaceWarning, each_once
from .in_memory import Heights, is_scene, scene_and_surface, solve_loads
from .keywords import several_loads
from .prepared import PreparedSurface
from .pull_off import require_pull
from .solution import Solution
from .solutions import Interrupted, Solutions

Number = float | str  # plain, or with a unit: "20 MPa"
Loads = Number | Sequence[Number] | np.ndarray


@overload
def solve(
    heights: Heights,
    pressure: Number | None = None,
    E_star: Number | None = None,
    physical_sizes: Sequence[Number] | None = None,
    accuracy: float | None = None,
    *,
    p_star: Number | None = None,
    gap_mean: Number | None = None,
    gap_over_h_rms: Number | None = None,
    a_r: Number | None = None,
    force: Number | None = None,
    approach: Number | None = None,
    **more: Any,
) -> Solution: ...
@overload
def solve(
    heights: Heights,
    pressure: Loads | None = None,
    E_star: Number | None = None,
    physical_sizes: Sequence[Number] | None = None,
    accuracy: float | None = None,
    *,
    p_star: Loads | None = None,
    gap_mean: Loads | None = None,
    gap_over_h_rms: Loads | None = None,
    a_r: Loads | None = None,
    force: Loads | None = None,
    approach: Loads | None = None,
    **more: Any,
) -> Solutions: ...
def solve(
    heights: Heights,
    pressure: Loads | None = None,
    E_star: Number | None = None,
    physical_sizes: Sequence[Number] | None = None,
    accuracy: float | None = None,
    *,
    p_star: Loads | None = None,
    gap_mean: Loads | None = None,
    gap_over_h_rms: Loads | None = None,
    a_r: Loads | None = None,
    force: Loads | None = None,
    approach: Loads | None = None,
    hardness: Number | None = None,
    history: bool | None = None,
    relaxation: Sequence[Sequence[Number]] | None = None,
    time: Loads | None = None,
    nu: float | None = None,
    thickness: Number | None = None,
    base: str | None = None,
    boundary: str | Sequence[str] | None = None,
    radius: Number | Sequence[Number] | None = None,
    fields: Sequence[str] | None = None,
    observables: Sequence[str] | None = None,
    distributions: Sequence[str] | None = None,
    pull_off_error: float | None = None,
    threads: int | str | None = None,
    progress: bool = False,
    comm: Any = None,
    **more: Any,
) -> Solution | Solutions:
    """Press an elastic body against a rigid rough surface.

    The contact is frictionless and of small slopes, the body linear elastic unless it relaxes or
    has a hardness.

    Parameters
    ----------
    heights : array (n_x, n_y), PreparedSurface, Topography or scene
        Heights of the rigid surface, peaks up, in the unit of `physical_sizes` (m if these have
        units). What `read_surface`, `prepare_surface` and `make_surface` return, and a Topography
        of SurfaceTopography, have their own sizes, unit and boundary. Or a Scene, or the path of
        one, whose keys hold unless they are given here; no file is written.
    pressure, p_star, gap_mean, gap_over_h_rms, a_r, force, approach : number, text or list
        The load, exactly one of these: the mean pressure in the unit of `E_star`, p/(E* g_rms), or
        another quantity of a scene's [load]. A list is solved in its order; each load starts from
        the previous solution if that is near.
    E_star : number or text, default 1
        Effective modulus, such as "50 GPa"; or E1=, nu1= (E2=, nu2=).
    physical_sizes : (L_x, L_y), default (1, 1)
        Sizes of an array: plain, in the unit of the heights, or with a unit; then heights are in m.
        Needed if the modulus has a unit.
    accuracy : float, default 1e-3
        Relative accuracy of a_r, mean gap and pressure field (L2); or residual=.
    hardness : number or text
        The largest pressure, for an elastic - perfectly plastic contact. Default: none.
    history : bool, default False
        Whether the loads follow from each other: with a hardness dents stay, with adhesion each
        load is on the branch of its direction, from the state before.
    relaxation : list of (share, time)
        Shares of the modulus that relax, and their times: a viscoelastic body. `E_star` is that at
        time 0.
    time : list of number or text
        With `relaxation`: when each load is reached, linearly from the one before; a time given
        twice makes a jump. A single load is held.
    nu, thickness, base
        A layer of Poisson's ratio `nu`: "bonded" (default) or "frictionless" on a rigid base, or on
        an "elastic" one with base_E= and base_nu=. Without `thickness`: a half-space.
    boundary : "periodic", "mirror", "free" or one for each axis
        What an array is: a map that repeats, a piece of a larger surface (its fields are then those
        of the map and its mirror images), or a body that ends there. Default: periodic where
        opposite edges meet; otherwise it must be given.
    radius : number, text or (R_x, R_y)
        Radius of a ball (inf: a cylinder) under the heights of an array with a free boundary.
    fields : list of "pressure", "gap", "displacement", "plastic", "heights"
        Fields that are kept and that `save` writes; () keeps none. Default: those of the scene, or
        pressure, gap and heights.
    observables, distributions : lists of names
        Numbers and arrays to compute for each load beside the cheap ones; a Solution can compute
        others later.
    pull_off_error : float
        With adhesion, branch="retraction" and a list of pressures, p_star or forces: solve further
        loads until the one that is held and the one that separates the bodies, see
        `Solutions.pull_off_bracket`, differ by less than this, relative to the latter.
    threads : int, default "auto"
        Threads of this process, or of each rank. Results do not depend on their number.
    progress : bool
        Whether to draw a progress bar for each load and print its row of the table.
    comm : communicator of mpi4py
        For scripts under mpirun: every rank calls this with the same whole `heights` (a memory map
        will do) or scene, and gets the same numbers; fields are those of its rows, `solution.rows`.
        Default: this process alone, even under mpirun.
    **more
        Other keys of the scene's [material], [solver] and [output], such as name="gfmd",
        precision="double", max_iterations, nested, options; `hpc-gfmd help scene` lists them.

    Returns
    -------
    Solution or Solutions
        A Solution for one load, Solutions for a list and for the loads of a scene.

    Raises
    ------
    SceneError
        For invalid input, in one line; with `comm` on all ranks.
    Interrupted
        A KeyboardInterrupt: for Ctrl-C after the first load of a list; its `solutions` are the
        finished loads. Not with `comm`.

    Warns
    -----
    NotConverged
        If a solution is less accurate than required; its `status` tells why.
    SurfaceWarning
        Of what may be wrong with the heights or with units; it stands in `notes`, too.

    Examples
    --------
    >>> wall = hpc_gfmd.make_surface("self-affine", hurst=0.8, L_over_lam_l=2, lam_l_over_lam_s=32,
    ...     lam_s_over_a=2, seed=1)
    >>> for solution in hpc_gfmd.solve(wall, p_star=[0.01, 0.1]):
    ...     print(solution.a_r, solution.pressure.max())
    """
    arguments = {
        "pressure": pressure,
        "p_star": p_star,
        "gap_mean": gap_mean,
        "gap_over_h_rms": gap_over_h_rms,
        "a_r": a_r,
        "force": force,
        "approach": approach,
        "E_star": E_star,
        "physical_sizes": physical_sizes,
        "accuracy": accuracy,
        "hardness": hardness,
        "history": history,
        "relaxation": relaxation,
        "time": time,
        "nu": nu,
        "thickness": thickness,
        "base": base,
        "boundary": boundary,
        "radius": radius,
        "fields": fields,
        "observables": observables,
        "distributions": distributions,
        "threads": threads,
        **more,
    }
    comm = comm_of(comm)
    several = several_loads(arguments)
    if several is None:
        several = is_scene(heights)
    scene, surfaces = scene_and_surface(comm, heights, arguments)
    if pull_off_error is not None:
        require_pull(scene, pull_off_error, several)
    solutions, facts = solve_loads(
        comm, scene, surfaces, progress, keep_interrupted=several, pull_off_error=pull_off_error
    )
    told_before = heights.notes if isinstance(heights, PreparedSurface) else ()
    if comm.rank == 0:
        _warn(scene, facts, solutions.steps, told_before)
    if solutions.status == "interrupted":
        raise Interrupted(solutions) from None
    return solutions if several else solutions[0]


def _warn(
    scene: Scene, facts: dict[str, Any], steps: Sequence[dict], told_before: Sequence[str]
) -> None:
    """Warn of doubtful heights and units, unless told before, and of unconverged loads."""
    doubts = [SurfaceWarning(note) for note in facts.get("notes", ()) if note not in told_before]
    for step in steps:
        doubts += load_notes(step["p"], scene.material.E_star, facts["g_rms"])
    for doubt in each_once(doubts):
        warnings.warn(doubt, stacklevel=3)
    for index, step in enumerate(steps):
        if not converged(step):
            which = f"load {index + 1}: " if len(steps) > 1 else ""
            errors = ", ".join(
                f"{step[name]:.1e}" for name in ("a_r_error", "gap_error", "pressure_error")
            )
            warnings.warn(
                f"{which}not converged ({step['status']}): estimated errors of area, mean gap,"
                f" pressure: {errors}",
                NotConverged,
                stacklevel=3,  # where the caller of solve is
            )
