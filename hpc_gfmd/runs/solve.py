"""Contacts in memory, for notebooks and scripts: as a run, without files."""

import json
import sys
import time
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from ..contact.contact import Contact, heights_of
from ..driver.warmup import compile_once
from ..kernels.cache import on_first_compile
from ..output.fields import FIELDS, Slab
from ..output.read import Result
from ..output.summary import converged
from ..parallel.comm import Comm
from ..parallel.grid import Grid
from ..parallel.guard import collective_errors, raise_on_all
from ..parallel.world import comm_of, threads_of
from ..scene import Scene
from ..surface.arrays import checked_array, is_topography
from ..surface.build import Surface, surface_of
from ..surface.heights import checked
from ..surface.quality import DIFFERENT_UNITS, quality_of
from ..surface.topography import Topography
from ..util.errors import NotConverged, SceneError
from ..util.versions import versions
from .keywords import HOMES, scene_of_keywords, several_loads
from .loads import check, solved, step_attributes, surface_attributes, sweep_of, worst
from .prepared import PreparedSurface, prepare_surface
from .progress import Reporter
from .solution import Interrupted, Solution, Solutions
from .table import GrowingTable

# what was found of surfaces whose heights nobody can change, for as long as there are these
_surfaces: WeakKeyDictionary[PreparedSurface, dict[np.dtype, Surface]] = WeakKeyDictionary()
Number = float | str  # plain, or with a unit: "20 MPa"
Loads = Number | Sequence[Number] | np.ndarray


def solve(
    heights: np.ndarray | PreparedSurface,
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
    nu: float | None = None,
    thickness: Number | None = None,
    base: str | None = None,
    boundary: str | Sequence[str] | None = None,
    fields: Sequence[str] = ("pressure", "gap", "heights"),
    observables: Sequence[str] | None = None,
    distributions: Sequence[str] = (),
    threads: int | str = "auto",
    progress: bool = False,
    comm: Any = None,
    **more: Any,
) -> Solution | Solutions:
    """Press an elastic body against a rigid rough surface: linear elastic, small slopes,
    frictionless, no adhesion.

    Parameters
    ----------
    heights : array (n_x, n_y), PreparedSurface or Topography
        Heights of the rigid surface, peaks up, in the unit of `physical_sizes` (m where these have
        units); or what `read_surface`, `prepare_surface` and `make_surface` give, or a Topography
        of SurfaceTopography, which know their sizes, units and boundary.
    pressure, p_star, gap_mean, gap_over_h_rms, a_r, force, approach : number, text with a unit, or
    a list of them
        The load, one of them: the mean pressure in the unit of `E_star`, p_star = p/(E* g_rms), and
        what else a scene's [load] has. A list is a sweep, solved in the order given, each load from
        the solution before where that is near; all of it is returned.
    E_star : number or text, default 1
        Effective modulus, such as "50 GPa"; or E1=, nu1= (and E2=, nu2=) as in the scene's
        [material].
    physical_sizes : (L_x, L_y), default (1, 1)
        Of an array: plain, in the unit of the heights, or with a unit as in "10 um"; the heights
        are in m then.
    accuracy : float, default 1e-3
        Wanted relative accuracy of a_r, mean gap and pressure field (L2); or residual=.
    hardness : number or text
        The largest pressure, in the unit of `E_star`, or such as "6 GPa": elastic - perfectly
        plastic contact. Default: none.
    nu, thickness, base
        An elastic layer of Poisson's ratio `nu` on a rigid base, "bonded" (default) or
        "frictionless", or with base_E= and base_nu= on an "elastic" one; no `thickness`: a
        half-space.
    boundary : "periodic", "free" or one for each axis
        Of an array; default: periodic. A surface that was read or made knows its own.
    radius : number, text or (R_x, R_y)
        Of an array with a free boundary: a ball (inf: a cylinder) under its heights. A surface that
        was read or made knows its own.
    fields : list of "pressure", "gap", "displacement", "plastic", "heights"
        Fields that are kept and that `save` writes; () keeps none, for long sweeps of large maps.
    observables, distributions : lists of names
        As in the scene's [output]: computed with each load beside the cheap ones; others can be
        asked of a Solution later.
    threads : int, default "auto"
        Threads of this process: the cores that it may use, one for less than 1024 x 1024 points,
        where more do not pay; one of each rank with `comm`. No result depends on their number.
    progress : bool
        Whether to draw a progress bar for each load, and to print its row of the table after it.
    comm : communicator of mpi4py
        In scripts under mpirun: every rank calls this with the same whole `heights` (a memory map
        will do) and gets the same numbers; fields are those of its own rows, `solution.rows` =
        (start, stop). Default: this process alone, even under mpirun.
    **more
        Other keys of the scene's [material], [solver] and [output]: E1, nu1, residual, name="gfmd",
        precision="double", max_iterations, nested, options, ... `hpc-gfmd help scene` lists them.
        All are checked as those of a scene are.

    Returns
    -------
    Solution or Solutions
        A Solution for one load, a sequence of them for a list.

    Raises
    ------
    SceneError
        For input that makes no sense, in one line; with `comm` on all ranks.
    Interrupted
        A KeyboardInterrupt: for Ctrl-C after the first load of a list; its `solutions` are those
        that were finished. Not with `comm`.

    Warns
    -----
    NotConverged
        Where a solution is less accurate than asked; its `status` says why.

    Examples
    --------
    >>> wall = hpc_gfmd.make_surface("self-affine", hurst=0.8, L_over_lam_l=2, lam_l_over_lam_s=32,
    lam_s_over_a=2, seed=1)
    >>> for solution in hpc_gfmd.solve(wall, p_star=[0.01, 0.1]):
    ...     print(solution.a_r, solution.pressure.max())
    """
    arguments = locals()
    given = {key: arguments[key] for key in HOMES if key in arguments} | {"nu1": nu}
    started, begun = datetime.now(UTC).isoformat(timespec="seconds"), time.monotonic()
    comm = comm_of(comm)
    with collective_errors(comm, "reading the arguments"):
        if is_topography(heights):
            heights = prepare_surface(heights)
        known = heights if isinstance(heights, PreparedSurface) else None
        scene = scene_of_keywords(given, more, known)
        check(scene)
        z = _complete(heights if known is None else known.heights)
    if comm.size > 1:
        _require_the_same(comm, scene, z.shape)
    of_each_rank = threads_of(comm, scene.machine.threads, z.size)
    head: dict[str, Any] = {}

    def rows_of(start: int, stop: int) -> np.ndarray:
        return np.asarray(z[start:stop], dtype=np.float64)

    if known:
        topography = Topography(
            z.shape, known.sizes, rows_of, known.unit, done=known.prepared, notes=known.notes
        )
    else:
        sizes = tuple(map(float, scene.surface.physical_sizes or ()))
        topography = Topography(z.shape, sizes, rows_of)
        notes = _quality_notes(comm, topography) if boundary is None else ()
        topography = replace(topography.on_form(scene.surface.radii), notes=notes)
    kept: dict[np.dtype, Surface] | None = None
    if known and comm.size == 1 and not known.heights.flags.writeable:
        kept = _surfaces.setdefault(known, {})

    def make_surface(dtype: np.dtype) -> Surface:
        if kept and dtype in kept:
            grid = kept[dtype].grid
            own = Grid.kept(grid.n, grid.sizes, comm, of_each_rank, nominal=grid.nominal)
            made = replace(kept[dtype], grid=own)  # the grid that this thread keeps
        else:
            free = scene.surface.free
            made = surface_of(topography, comm, dtype, of_each_rank, free, known=False)
            if kept is not None:
                kept[dtype] = made
        head["heights"] = made.checksum
        head.setdefault("setup_seconds", time.monotonic() - begun)
        measured = hasattr(scene.surface, "path")
        return made if measured else replace(made, checksum=None)

    steps: list[dict] = []
    contacts: list[Contact | None] = []  # None where no field is kept
    last: dict[str, Any] = {}
    say = Reporter(comm, scene.solver, not progress, progress, sys.stderr)

    def solve_all() -> None:
        steps.clear()
        contacts.clear()
        sweep = sweep_of(scene, make_surface)
        loads = sweep.loads(scene.load)
        table = GrowingTable(
            surface_attributes(scene, sweep.surface), scene.output.observables or ()
        )
        for index, contact, seconds in solved(scene, sweep, loads, say):
            attributes = step_attributes(scene, index, contact, seconds)
            last["surface"], keeps = contact.surface, bool(scene.output.fields)
            if index + 1 < len(loads) and keeps:  # the next load overwrites these
                contact = replace(contact, g=contact.g.copy(), p=contact.p.copy())
            contacts.append(contact if keeps else None)
            steps.append(attributes)  # last: a load is done with it
            if progress:  # rows take longer than a small contact's iteration
                say.say(table.add({index: attributes}))

    stopped, several = False, several_loads(given)
    try:
        if comm.size > 1:
            compile_once(comm, scene, lambda contact: step_attributes(scene, 0, contact, 0.0))
            solve_all()
        else:
            with on_first_compile(say.say):
                solve_all()
    except KeyboardInterrupt:
        if comm.size > 1 or not (steps and several):  # other ranks may not have been interrupted
            raise
        stopped = True
    contacts, surface = contacts[: len(steps)], last["surface"]
    for contact in filter(None, contacts):
        for fft in contact.surface.grid.planned():
            contact.surface.grid.forget_fft(fft.dtype)
    head |= {
        "scene": scene.to_toml(),
        "identity": scene.identity(),
        "versions": json.dumps(versions()),
        "start_time": started,
    }
    if known is None or known.table is None:
        head["identity"] += f" of {head['heights']}"
    stored = [_fields(scene.output.fields, contact) if contact else {} for contact in contacts]
    attributes, indices = surface_attributes(scene, surface), list(range(len(steps)))
    result = Result(None, attributes, steps, indices, worst(steps), head, stored)
    if stopped:
        result = replace(
            result, status="interrupted", notes=(f"interrupted: {result.missing_loads}",)
        )
    found = Solutions(result, surface.rows, comm, contacts)
    _warn(comm, steps)
    if stopped:
        raise Interrupted(found) from None
    return found if several else found[0]


def _fields(names: Iterable[str], contact: Contact) -> dict[str, Slab]:
    """Return {name: Slab} of a contact, computed as they are read."""
    surface = contact.surface
    start, n = surface.rows[0], (surface.n[0], surface.n[1])
    return {
        name: Slab(contact.field(name) if name in FIELDS else heights_of(surface), start, n)
        for name in names
    }


def _quality_notes(comm: Comm, found: Topography) -> tuple[str, ...]:
    """Find notes on an array of which nobody said that it is periodic. Collective."""
    rows = found.rows
    found = replace(found, rows=lambda i, j: checked(rows(i, j), i, "surface"))
    return tuple(quality_of(found, comm).notes((True, True)))


def _warn(comm: Comm, steps: Sequence[dict]) -> None:
    notes = [note for step in steps for note in (step["note"] or "").split("; ")]
    for note in dict.fromkeys(notes) if comm.rank == 0 else ():
        if note.endswith(DIFFERENT_UNITS):
            warnings.warn(note, stacklevel=3)
    for index, step in enumerate(steps):
        if not converged(step) and comm.rank == 0:
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


def _require_the_same(comm: Comm, scene: Scene, shape: tuple[int, ...]) -> None:
    """Raise SceneError on all ranks where they were not called with the same arguments."""
    own = scene.to_toml(), shape
    error = SceneError(
        "hpc_gfmd.solve: found other arguments on some ranks, allowed: the same, with the whole map"
        " on each"
    )
    raise_on_all(comm, None if comm.bcast(own) == own else error)


def _complete(heights: Any) -> np.ndarray:
    """Return the array as it is. Raises SceneError for what is no complete height map."""
    heights = checked_array(heights)
    if np.ma.is_masked(heights):
        raise SceneError(
            f"heights: found {np.ma.count_masked(heights)} masked points, allowed: a complete map,"
            ' as of hpc_gfmd.prepare_surface(heights, fill="harmonic")'
        )
    return heights
