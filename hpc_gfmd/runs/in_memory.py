"""The steps of `solve`: arguments to a scene and a surface, and its loads in memory."""

import json
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from math import prod
from os import PathLike
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from ..contact.contact import Contact
from ..contact.fields import heights_of
from ..driver.warmup import compile_once
from ..kernels.cache import on_first_compile
from ..output.fields import FIELDS, Slab
from ..output.result import Result
from ..parallel.comm import Comm
from ..parallel.grid import Grid
from ..parallel.guard import collective_errors, on_rank_0, raise_on_all
from ..parallel.thread_count import threads_of
from ..scene import Scene, load_scene
from ..surface import Precision, Size, Surface, build_surface, open_surface, precision_of
from ..surface.build import surface_of
from ..surface.heights import StoredRows, array_of
from ..surface.metadata import is_topography
from ..surface.quality import edges_of
from ..surface.topography import Topography
from ..util.errors import SceneError, SurfaceWarning
from ..util.versions import versions
from .keywords import changed_scene, scene_of_keywords
from .loads import Run, check, step_attributes, with_loads, worst_status
from .prepared import PreparedSurface
from .progress import Reporter, bar_stream
from .pull_off import PullOff
from .solutions import Solutions
from .surfaces import surface_of_topography

Heights = Any  # an array, a PreparedSurface, a Topography of SurfaceTopography, or a scene
Kept = dict[np.dtype, Surface]  # surfaces by precision
DOUBLE = np.dtype(np.float64)
SMALL = 2**16  # points of a surface that is made once, in double precision, and kept in both

# The surfaces of prepared heights, which cannot be written to, for as long as these live: a second
# solve finds them ready. By whether both axes are kept.
_surfaces: WeakKeyDictionary[PreparedSurface, dict[bool, Kept]] = WeakKeyDictionary()


# -- the scene and its surface


def is_scene(surface: Any) -> bool:
    """Whether an argument is a scene or the path of one, which ends in .toml."""
    is_path = isinstance(surface, str | PathLike) and str(surface).endswith(".toml")
    return is_path or isinstance(surface, Scene)


def scene_and_surface(
    comm: Comm, heights: Heights, arguments: dict[str, Any]
) -> tuple[Scene, "Surfaces"]:
    """Return the validated scene for the arguments of `solve`, and what makes its surface.
    SceneError on all ranks, also where arguments differ between ranks. Collective.
    """
    if is_scene(heights):
        scene = _changed(comm, heights, arguments)
        return scene, surfaces_of_scene(comm, scene)
    scene, topography, prepared = _scene_and_map(comm, heights, arguments)
    return scene, _surfaces_of(comm, scene, topography, prepared)


def _scene_and_map(
    comm: Comm, heights: Heights, arguments: dict[str, Any]
) -> tuple[Scene, Topography, PreparedSurface | None]:
    """Return the scene for heights in memory, and these as a map; with the PreparedSurface that
    they are, if they are one. Collective.
    """
    with collective_errors(comm, "reading the arguments"):
        if is_topography(heights):
            heights = surface_of_topography(heights, arguments.get("boundary"))
            arguments = arguments | {"boundary": None}
        prepared = heights if isinstance(heights, PreparedSurface) else None
        scene = scene_of_keywords(arguments, prepared)
        check(scene)
        if prepared is None:
            topography = _map_of_array(array_of(heights, is_complete=True), scene.surface)
        else:
            topography = _map_of_prepared(prepared)
    if comm.size > 1:
        _require_the_same(comm, scene, topography.n)
    return scene, topography, prepared


def _map_of_prepared(surface: PreparedSurface) -> Topography:
    return Topography(
        surface.heights.shape,
        surface.sizes,
        StoredRows(surface.heights),
        surface.unit,
        prepared=surface.prepared,
        notes=tuple(map(SurfaceWarning, surface.notes)),
    )


def _map_of_array(array: np.ndarray, spec: Any) -> Topography:
    """Return an array as the map that is pressed; SceneError if it needs a boundary."""
    sizes = tuple(map(float, spec.physical_sizes))
    as_it_is = Topography(array.shape, sizes, StoredRows(array))
    if spec.boundary is None:
        edges_of(as_it_is).require_meeting("boundary")
    return as_it_is.mirrored(spec.mirrored).on_form(spec.radii)


def _changed(comm: Comm, scene: Scene | str | PathLike, arguments: dict[str, Any]) -> Scene:
    """Return the scene that is given, with the other arguments. Collective."""

    def read() -> Scene:
        original = scene if isinstance(scene, Scene) else load_scene(scene)
        made = changed_scene(original, arguments)
        check(made)
        return made

    return on_rank_0(comm, "reading the scene", read)


def _require_the_same(comm: Comm, scene: Scene, shape: tuple[int, ...]) -> None:
    """Raise SceneError on all ranks if some of them have another scene or shape of the heights."""
    arguments = scene.to_toml(), shape
    error = SceneError(
        "hpc_gfmd.solve: found other arguments on some ranks, allowed: the same, with the whole map"
        " on each"
    )
    raise_on_all(comm, None if comm.bcast(arguments) == arguments else error)


@dataclass
class Surfaces:
    """Makes the surface of a scene in the precision with which it is called, on all ranks."""

    comm: Comm
    threads: int  # of each rank
    size: Size
    make: Callable[[Precision], Surface]  # make(precision) makes it
    # Surfaces that can be used again, to which new ones are added; None if they cannot.
    kept: Kept | None = None
    rounds: bool = False  # whether a kept surface in single precision is one in double, rounded
    is_described: bool = True  # whether the scene describes the heights completely
    is_measured: bool = True  # whether the heights are from a file
    # of heights that are in memory or in a file; None before the first surface
    checksum: str | None = None

    def __call__(self, precision: Precision) -> Surface:
        """Return the surface in a precision, a kept one if there is one. Collective."""
        surface = self.make(precision) if self.kept is None else self._of(self.kept, precision)
        self.checksum = surface.checksum
        return surface if self.is_measured else replace(surface, checksum=None)

    def _of(self, kept: Kept, precision: Precision) -> Surface:
        if kept:
            made = self._with_grid_of_this_thread(next(iter(list(kept.values()))))
        else:
            made = self.make(DOUBLE if self.rounds else precision)
            kept[made.gap.dtype] = made
        dtype = precision_of(precision, made)
        if dtype == made.gap.dtype:
            return made
        if dtype in kept:
            return self._with_grid_of_this_thread(kept[dtype])
        if self.rounds:
            kept[dtype] = replace(made, h=made.gap.astype(dtype))
        else:
            kept[dtype] = self.make(dtype)
        return kept[dtype]

    def _with_grid_of_this_thread(self, surface: Surface) -> Surface:
        """Return a kept surface on a grid whose scratch memory belongs to this thread."""
        grid = surface.grid
        kept = Grid.kept(grid.n, grid.sizes, grid.comm, self.threads, nominal=grid.nominal)
        return replace(surface, grid=kept)


def surfaces_of_scene(
    comm: Comm, scene: Scene, keep: bool = False, is_only_one: bool = True
) -> Surfaces:
    """Return what makes the surface of a scene. Collective. keep: it is made once in each precision
    and stays in memory; is_only_one: its file stays open until then.
    """
    topography: Topography | None = None  # of a file, on rank 0, until the first surface is made

    def opened_size() -> Size:
        nonlocal topography
        topography, size = open_surface(scene.surface)
        return size

    def opened() -> Topography | None:
        nonlocal topography
        handed_over = topography
        topography = None
        return handed_over

    size = on_rank_0(comm, "reading the surface", opened_size)
    if not is_only_one:
        topography = None
    threads = threads_of(comm, scene.machine.threads, prod(size.n))
    low_memory = scene.solver.low_memory

    def make(precision: Precision) -> Surface:
        whole = scene.may_break_symmetry
        return build_surface(scene.surface, comm, precision, threads, low_memory, whole, opened)

    return Surfaces(comm, threads, size, make, {} if keep and not low_memory else None)


def _surfaces_of(
    comm: Comm, scene: Scene, topography: Topography, prepared: PreparedSurface | None
) -> Surfaces:
    """Return what makes the surface of a scene from a map of heights in memory."""
    n_x, n_y = topography.n
    is_small = n_x * n_y <= SMALL
    kept: Kept | None = {} if is_small else None
    whole = scene.may_break_symmetry
    if prepared is not None and comm.size == 1 and not prepared.heights.flags.writeable:
        kept = _surfaces.setdefault(prepared, {}).setdefault(whole, {})
    threads = threads_of(comm, scene.machine.threads, n_x * n_y)

    def make(precision: Precision) -> Surface:
        return surface_of(topography, comm, precision, threads, scene.surface.free, True, whole)

    is_described = prepared is not None and prepared.table is not None
    is_measured = hasattr(scene.surface, "path")
    size = Size((n_x, n_y), topography.sizes)
    return Surfaces(comm, threads, size, make, kept, is_small, is_described, is_measured)


# -- its loads


@contextmanager
def kernels_ready(comm: Comm, scene: Scene) -> Iterator[None]:
    """Compile the kernels of a scene, on one rank first; one process says so on standard error."""
    if comm.size > 1:
        compile_once(comm, scene, partial(step_attributes, scene, 0, seconds=0.0))
        yield
    else:
        with on_first_compile(Reporter(comm, scene.solver, False, False, sys.stderr).say):
            yield


def solve_loads(
    comm: Comm,
    scene: Scene,
    surfaces: Surfaces,
    progress: bool,
    keep_interrupted: bool,
    pull_off_error: float | None = None,
) -> tuple[Solutions, dict[str, Any]]:
    """Solve all loads of a scene; return them, with the fields it asks for, and the attributes of
    the surface. Collective. keep_interrupted: Ctrl-C after the first load ends the sweep, on one
    process.
    """
    start_time = datetime.now(UTC).isoformat(timespec="seconds")
    begun = time.monotonic()
    reporter = Reporter(comm, scene.solver, not progress, progress, bar_stream())
    steps: list[dict] = []
    contacts: list[Contact | None] = []
    interrupted = False
    try:
        with kernels_ready(comm, scene):
            run = Run(scene, surfaces, reporter)
            rows = run.surface.rows
            setup_seconds = time.monotonic() - begun
            pull_off = None if pull_off_error is None else PullOff(run, pull_off_error)
            for load in (pull_off or run).solve():
                is_last = pull_off is None and load.index + 1 == len(run.loads)
                contacts.append(_kept(load.contact, is_last) if scene.output.fields else None)
                steps.append(load.numbers)  # now the load is finished
                run.show({load.index: load.numbers})
                del load  # its fields make room for the next one
    except KeyboardInterrupt:
        # under MPI other ranks may not have been interrupted
        if comm.size > 1 or not (steps and keep_interrupted):
            raise
        interrupted = True
        del contacts[len(steps) :]
        pull_off = None
    if pull_off is not None:
        steps = [steps[k] for k in pull_off.order]
        contacts = [contacts[k] for k in pull_off.order]
        name, values = run.scene.load.prescribed
        scene = with_loads(run.scene, **{name: [values[k] for k in pull_off.order]})
    _forget_transforms(contacts)
    status = "interrupted" if interrupted else worst_status(steps)
    attributes = run.attributes
    head = {
        "heights": surfaces.checksum or "",
        "start_time": start_time,
        "setup_seconds": setup_seconds,
    }
    suffix = "" if surfaces.is_described else f" of {surfaces.checksum}"

    def make_result() -> Result:
        identity = scene.identity() + suffix
        return _result(scene, steps, contacts, status, attributes, head | {"identity": identity})

    solutions = Solutions(steps, make_result, rows, comm, status=status, contacts=contacts)
    return solutions, attributes


def _kept(contact: Contact, is_last: bool) -> Contact:
    """Return a contact whose fields no next load overwrites: a copy unless it is the last one."""
    return contact if is_last else replace(contact, g=contact.g.copy(), p=contact.p.copy())


def _forget_transforms(contacts: Iterable[Contact | None]) -> None:
    """Free the memory of the transforms on the grids of contacts that are kept."""
    for contact in contacts:
        if contact is not None:
            grid = contact.surface.grid
            for transform in grid.planned():
                grid.forget_fft(transform.dtype)


def _result(
    scene: Scene,
    steps: list[dict],
    contacts: list[Contact | None],
    status: str,
    attributes: dict[str, Any],
    head: dict[str, Any],
) -> Result:
    """Return finished loads as a result file would hold them; fields are computed when read."""
    head = {"scene": scene.to_toml(), "versions": json.dumps(versions()), **head}
    names = scene.output.fields
    fields = [{} if contact is None else _fields(names, contact) for contact in contacts]
    indices = list(range(len(steps)))
    notes = tuple(attributes.get("notes", []))
    result = Result(None, attributes, steps, indices, status, head, fields, notes=notes)
    if status == "interrupted":
        result = replace(result, notes=(*notes, f"interrupted: {result.missing_loads}"))
    return result


def _fields(names: Iterable[str], contact: Contact) -> dict[str, Slab]:
    """Return {name: Slab} of a contact; the fields are computed when they are read."""
    surface = contact.surface
    start = surface.rows[0]
    n = (surface.n[0], surface.n[1])
    return {
        name: Slab(contact.field(name) if name in FIELDS else heights_of(surface), start, n)
        for name in names
    }
