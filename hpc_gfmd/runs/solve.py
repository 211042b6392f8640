"""Contacts in memory, for notebooks and scripts: the same composition as a run, without files."""

import hashlib
import json
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from functools import partial
from os import PathLike
from typing import Any

import numpy as np

from ..contact.contact import Contact, heights_of
from ..driver.warmup import compile_once
from ..kernels.cache import announced, sound
from ..output.fields import FIELDS, Slab
from ..output.read import Result
from ..parallel.comm import Comm
from ..parallel.guard import guarded
from ..parallel.world import comm_of, threads_of
from ..scene import Scene
from ..surface.build import Surface, surface_from_rows
from ..surface.heights import Checksum, checked
from ..surface.quality import DIFFERENT_UNITS, MapQuality
from ..surface.topography import Rows, Topography
from ..util.errors import NotConverged, SceneError, one_line
from ..util.versions import versions
from .composition import check, load_shown, step_attributes, surface_attributes, sweep_of, worst
from .keywords import loads_of, scene_of_keywords
from .prepared import PreparedSurface
from .progress import Reporter
from .solution import Solution
from .solutions import Interrupted, Solutions, solutions_of

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
    nu: float | None = None,
    thickness: Number | None = None,
    base: str | None = None,
    boundary: str | Sequence[str] | None = None,
    fields: Sequence[str] = ("pressure", "gap", "heights"),
    observables: Sequence[str] | None = None,
    distributions: Sequence[str] = (),
    threads: int | str = 1,
    progress: bool = False,
    comm: Any = None,
    **more: Any,
) -> Solution | Solutions:
    """Press an elastic body against a rigid rough wall: linear elastic, small slopes, frictionless,
    no adhesion.

    Parameters
    ----------
    heights : array (n_x, n_y) or PreparedSurface
        Heights of the wall, peaks up, in the unit of `physical_sizes` (m where these have units);
        or what `read_surface` and `make_surface` give, which know their sizes, units and boundary.
    pressure, p_star, gap_mean, gap_over_h_rms, a_r, force, approach : number, text with a unit, or
    a list of them
        The load, one of them: the mean pressure in the unit of `E_star`, p_star = p/(E* g_rms), and
        what else a scene's [load] has. A list is a sweep, solved in the order given, each load from
        the solution before where that is near; all of it is returned.
    E_star : number or text, default 1
        Effective modulus, such as "50 GPa"; or E1=, nu1= (and E2=, nu2=) as in the scene's
        [material].
    physical_sizes : (L_x, L_y), default (1, 1)
        Of an array: plain, in the unit of the heights, or texts such as "10 um", the heights being
        in m then.
    accuracy : float, default 1e-3
        Wanted relative accuracy of a_r, mean gap and pressure field (L2); or residual=.
    nu, thickness, base
        An elastic layer of Poisson's ratio `nu` on a rigid base, "bonded" (default) or
        "frictionless"; no `thickness`: a half-space.
    boundary : "periodic", "free" or one for each axis
        Of an array; default: periodic. A surface that was read or made knows its own.
    fields : list of "pressure", "gap", "displacement", "heights"
        Fields that are kept and that `save` writes; () keeps none, for long sweeps of large maps.
    observables, distributions : lists of names
        As in the scene's [output]: computed with each load beside the cheap ones; others can be
        asked of a Solution later.
    threads : int or "auto"
        Threads of this process.
    progress : bool
        Whether to draw a progress bar for each load.
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
    started, begun, comm = (
        datetime.now(UTC).isoformat(timespec="seconds"),
        time.monotonic(),
        comm_of(comm),
    )
    loads = {
        "pressure": pressure,
        "p_star": p_star,
        "gap_mean": gap_mean,
        "gap_over_h_rms": gap_over_h_rms,
        "a_r": a_r,
        "force": force,
        "approach": approach,
    }
    given = {
        "E_star": E_star,
        "physical_sizes": physical_sizes,
        "accuracy": accuracy,
        "nu1": nu,
        "thickness": thickness,
        "base": base,
        "boundary": boundary,
        "fields": fields,
        "observables": observables,
        "distributions": distributions,
        "threads": threads,
    }
    with guarded(comm, "reading the arguments"):
        known = heights if isinstance(heights, PreparedSurface) else None
        scene = scene_of_keywords(loads | given, more, known)
        check(scene)
        z = _checked(heights if known is None else known.heights)
    _require_the_same(comm, scene, z.shape)
    of_each_rank = threads_of(comm, scene.machine.threads)
    head: dict[str, Any] = {}
    sizes = known.sizes if known else tuple(map(float, scene.surface.physical_sizes or ()))

    def rows_of(start: int, stop: int) -> np.ndarray:
        return np.asarray(z[start:stop], dtype=np.float64)

    notes = (
        known.notes
        if known
        else _quality_notes(comm, z.shape, sizes, rows_of)
        if boundary is None
        else ()
    )

    def make_surface(dtype: np.dtype) -> Surface:
        unit = known.unit if known else ""
        made = surface_from_rows(
            z.shape, sizes, rows_of, comm, dtype, of_each_rank, scene.surface.free, Checksum(), unit
        )
        head["heights"] = made.checksum
        head.setdefault("setup_seconds", time.monotonic() - begun)
        checksum = made.checksum if hasattr(scene.surface, "path") else None  # of a measured map
        return replace(
            made, prepared=known.prepared if known else (), quality_notes=notes, checksum=checksum
        )

    done, stopped = _Done(), False
    try:
        if comm.size > 1:
            compile_once(comm, scene.solver, scene.surface.boundary or "periodic", scene.material)
            _press(comm, scene, make_surface, progress, done)
        else:
            with announced(partial(print, file=sys.stderr) if progress else None):
                sound(lambda: _press(comm, scene, make_surface, progress, done))
    except KeyboardInterrupt:
        if comm.size > 1 or not (
            done.steps and loads_of(loads)
        ):  # other ranks may not have been interrupted
            raise
        stopped = True
    steps, contacts, surface = done.steps, done.contacts[: len(done.steps)], done.surface
    head |= {
        "scene": scene.to_toml(),
        "identity": scene.identity(),
        "versions": json.dumps(versions()),
        "start_time": started,
    }
    if known is None or known.table is None:
        head["identity"] += f" of {head['heights']}"
    stored = [_fields(scene.output.fields, contact) for contact in contacts]
    result = Result(
        None,
        surface_attributes(scene, surface),
        steps,
        list(range(len(steps))),
        worst(steps),
        head,
        stored,
    )
    if stopped:
        result = replace(
            result, status="interrupted", notes=(f"interrupted: {result.missing_loads}",)
        )
    found = solutions_of(result, contacts, surface.rows, comm)
    _warn(comm, steps)
    if stopped:
        raise Interrupted(found) from None
    return found if loads_of(loads) else found[0]


@dataclass
class _Done:
    """What `_press` has done so far: attributes of the steps, their contacts (None where no field
    is kept), and the surface."""

    steps: list = field(default_factory=list)
    contacts: list = field(default_factory=list)
    surface: Any = None


def _press(
    comm: Comm,
    scene: Scene,
    make_surface: Callable[[np.dtype], Surface],
    progress: bool,
    done: _Done,
) -> None:
    """Solve all loads; `done` is kept up to date. Collective."""
    done.steps, done.contacts = [], []
    sweep = sweep_of(scene, make_surface)
    say = Reporter(comm, scene.solver, quiet=not progress, bar=progress)
    loads = sweep.pressures(scene.load)
    try:
        for index, load in enumerate(loads):
            begun = time.monotonic()
            say.step(index, len(loads), *load_shown(scene.load, index, sweep, load))
            try:
                step = sweep.solve(load, say.watch)
            finally:
                say.done()
            contact = step.contact
            attributes = step_attributes(scene, index, step, time.monotonic() - begun)
            if index + 1 < len(loads) and scene.output.fields:  # the next load overwrites these
                contact = replace(contact, g=contact.g.copy(), p=contact.p.copy())
            done.contacts.append(contact if scene.output.fields else None)
            done.surface = sweep.surface
            done.steps.append(attributes)  # last: a load is done with it
    finally:
        for grid in {
            id(one.surface.grid): one.surface.grid for one in done.contacts if one is not None
        }.values():
            for fft in grid.planned():
                grid.forget_fft(fft.dtype)


def _fields(names: Iterable[str], contact: Contact | None) -> dict[str, Slab]:
    """{name: Slab} of a contact, computed as they are read; none of None."""
    if contact is None:
        return {}
    start, n = contact.surface.rows[0], (contact.surface.n[0], contact.surface.n[1])
    found: dict[str, Any] = {
        name: contact.field(name) if name in FIELDS else heights_of(contact.surface)
        for name in names
    }
    return {name: Slab(lazy, start, n) for name, lazy in found.items()}


def _quality_notes(
    comm: Comm, n: Sequence[int], sizes: tuple[float, ...], rows: Rows
) -> tuple[str, ...]:
    """Notes on an array of which nobody said that it is periodic. Collective."""
    found = Topography(
        tuple(n), sizes, lambda start, stop: checked(rows(start, stop), start, "surface")
    )
    return tuple(MapQuality(found, comm).notes((True, True)))


def _warn(comm: Comm, steps: Sequence[dict]) -> None:
    notes = [note for step in steps for note in (step["note"] or "").split("; ")]
    for note in dict.fromkeys(notes) if comm.rank == 0 else ():
        if note.endswith(DIFFERENT_UNITS):
            warnings.warn(note, stacklevel=3)
    for index, step in enumerate(steps):
        if step["status"] != "converged" and comm.rank == 0:
            which = f"load {index + 1}: " if len(steps) > 1 else ""
            errors = ", ".join(
                f"{step[name]:.1e}" for name in ("a_r_error", "gap_error", "pressure_error")
            )
            warnings.warn(
                f"{which}not converged ({step['status']}): estimated errors of area, mean gap,"
                f" pressure: {errors}",
                NotConverged,
                stacklevel=3,
            )  # where the caller of solve is


def _require_the_same(comm: Comm, scene: Scene, shape: Sequence[int]) -> None:
    """Raise SceneError on all ranks where they were not called with the same arguments."""
    digest = int.from_bytes(
        hashlib.blake2b(repr((scene.to_toml(), tuple(shape))).encode(), digest_size=6).digest()
    )  # fits a float64
    if comm.min([digest])[0] != comm.max([digest])[0]:
        raise SceneError(
            "hpc_gfmd.solve: found other arguments on some ranks, allowed: the same, with the whole"
            " map on each"
        )


def _checked(heights: Any) -> np.ndarray:
    """The array as it is. Raises SceneError for what is no complete height map."""
    if isinstance(heights, str | PathLike):
        raise SceneError(
            f"heights: found {str(heights)!r}, allowed: an array, or"
            f" hpc_gfmd.read_surface({str(heights)!r})"
        )
    if np.ma.is_masked(heights):
        raise SceneError("heights: found masked points, allowed: a complete height map")
    try:
        heights = np.asanyarray(heights)
    except (TypeError, ValueError) as error:
        raise SceneError(
            f"heights: found {one_line(str(error))}, allowed: a real array with two axes, not empty"
        ) from None
    if heights.ndim != 2 or heights.size == 0 or heights.dtype.kind not in "fiu":
        found = f"shape {heights.shape} of {one_line(str(heights.dtype), 80)}"
        raise SceneError(f"heights: found {found}, allowed: a real array with two axes, not empty")
    return heights
