"""The steps of `solve`: arguments to a scene and a surface, its loads, and their solutions."""

import json
import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from ..contact.contact import Contact, heights_of
from ..driver.warmup import compile_once
from ..kernels.cache import on_first_compile
from ..output.fields import FIELDS, Slab
from ..output.result import Result
from ..parallel.comm import Comm
from ..parallel.grid import Grid
from ..parallel.guard import collective_errors, raise_on_all
from ..parallel.thread_count import threads_of
from ..scene import Scene
from ..surface.arrays import complete_array, is_topography
from ..surface.build import Surface, surface_of
from ..surface.prepare import mirrored
from ..surface.quality import edges_of
from ..surface.topography import Topography
from ..util.errors import SceneError
from ..util.versions import versions
from .keywords import scene_of_keywords
from .loads import check, solved, step_attributes, surface_attributes, sweep_of, worst_status
from .prepared import PreparedSurface
from .progress import Reporter, bar_stream
from .solutions import Solutions
from .surfaces import surface_of_topography
from .table import GrowingTable

Heights = Any  # an array, a PreparedSurface or a Topography of SurfaceTopography

# The surfaces of prepared heights, which cannot be written to, for as long as these live: a second
# solve finds them ready.
_surfaces: WeakKeyDictionary[PreparedSurface, dict[tuple[np.dtype, bool], Surface]] = (
    WeakKeyDictionary()
)


# -- the scene and its surface


def scene_of(
    comm: Comm, heights: Heights, keywords: dict[str, Any], more: dict[str, Any]
) -> tuple[Scene, np.ndarray | PreparedSurface]:
    """Return the scene and the heights that the arguments of `solve` describe, both validated.

    Collective.

    Parameters
    ----------
    comm : Comm
        All ranks.
    heights
        As for `solve`.
    keywords : dict
        The named arguments of `solve` that are keys of a scene; None for one that is not given.
    more : dict
        Its other arguments.

    Returns
    -------
    Scene
        What is to be solved.
    ndarray or PreparedSurface
        The heights; an array has no missing points.

    Raises
    ------
    SceneError
        On all ranks, for invalid arguments, or different ones on some ranks.
    """
    with collective_errors(comm, "reading the arguments"):
        wall = heights
        if is_topography(heights):
            wall = surface_of_topography(heights, keywords["boundary"])
            keywords = keywords | {"boundary": None}
        prepared = wall if isinstance(wall, PreparedSurface) else None
        scene = scene_of_keywords(keywords, more, prepared)
        check(scene)
        if prepared is None:
            wall = complete_array(wall)
            _require_boundary(wall, scene)
    if comm.size > 1:
        _require_the_same(comm, scene, _array_of(wall).shape)
    return scene, wall


def _require_boundary(heights: np.ndarray, scene: Scene) -> None:
    """Raise SceneError if opposite edges do not meet and the scene does not say what is there."""
    if scene.surface.boundary is None:
        question = edges_of(lambda start, stop: heights[start:stop], heights.shape).question()
        if question:
            raise SceneError(question)


def _array_of(wall: np.ndarray | PreparedSurface) -> np.ndarray:
    """Return the heights as an array, without a copy."""
    return wall.heights if isinstance(wall, PreparedSurface) else wall


@dataclass
class Surfaces:
    """Makes the surface of a scene in the precision with which it is called, on all ranks.

    Attributes
    ----------
    comm : Comm
        All ranks.
    scene : Scene
        What is solved.
    topography : Topography
        The heights with their sizes.
    threads : int
        Threads of each rank.
    ready : dict or None
        Surfaces by precision that are kept from one solve to the next; None if the heights may
        change.
    is_made : bool
        Whether the scene describes the heights completely.
    begun : float
        When the solve began, by time.monotonic.
    checksum : str or None
        Checksum of the heights; None before the first surface.
    setup_seconds : float or None
        Seconds from `begun` to the first surface; None before it.
    """

    comm: Comm
    scene: Scene
    topography: Topography
    threads: int
    ready: dict[tuple[np.dtype, bool], Surface] | None
    is_made: bool
    begun: float = field(default_factory=time.monotonic)
    checksum: str | None = None
    setup_seconds: float | None = None

    def __call__(self, dtype: np.dtype) -> Surface:
        """Return the surface in a precision, a kept one if there is one. Collective.

        Sets `checksum` and, at first, `setup_seconds`. Only a surface from a file has its checksum.
        """
        whole = self.scene.may_break_symmetry
        if self.ready is not None and (dtype, whole) in self.ready:
            surface = self._with_grid_of_this_thread(self.ready[dtype, whole])
        else:
            free = self.scene.surface.free
            surface = surface_of(self.topography, self.comm, dtype, self.threads, free, True, whole)
            if self.ready is not None:
                self.ready[dtype, whole] = surface
        self.checksum = surface.checksum
        if self.setup_seconds is None:
            self.setup_seconds = time.monotonic() - self.begun
        is_measured = hasattr(self.scene.surface, "path")
        return surface if is_measured else replace(surface, checksum=None)

    def _with_grid_of_this_thread(self, surface: Surface) -> Surface:
        """Return a kept surface on a grid whose scratch memory belongs to this thread."""
        grid = surface.grid
        kept = Grid.kept(grid.n, grid.sizes, self.comm, self.threads, nominal=grid.nominal)
        return replace(surface, grid=kept)


def surfaces_of(comm: Comm, scene: Scene, wall: np.ndarray | PreparedSurface) -> Surfaces:
    """Return the object that makes the surface of a scene from its heights, in any precision.

    Collective. No surface is made yet.

    Parameters
    ----------
    comm : Comm
        All ranks.
    scene : Scene
        What is solved.
    wall : ndarray or PreparedSurface
        Its heights.

    Returns
    -------
    Surfaces
        For `sweep_of`.
    """
    begun = time.monotonic()
    array = _array_of(wall)

    def rows_of(start: int, stop: int) -> np.ndarray:
        """Return some rows of the heights in double precision."""
        return np.asarray(array[start:stop], dtype=np.float64)

    ready = None
    if isinstance(wall, PreparedSurface):
        topography = Topography(
            array.shape, wall.sizes, rows_of, wall.unit, prepared=wall.prepared, notes=wall.notes
        )
        if comm.size == 1 and not array.flags.writeable:
            ready = _surfaces.setdefault(wall, {})
    else:
        sizes = tuple(float(size) for size in scene.surface.physical_sizes or ())
        topography = Topography(array.shape, sizes, rows_of)
        topography = mirrored(topography, scene.surface.mirrored).on_form(scene.surface.radii)
    is_made = isinstance(wall, PreparedSurface) and wall.table is not None
    threads = threads_of(comm, scene.machine.threads, array.size)
    return Surfaces(comm, scene, topography, threads, ready, is_made, begun)


# -- its loads


@dataclass
class SolvedLoads:
    """The finished loads of a scene.

    Attributes
    ----------
    steps : list of dict
        Their attributes, by the names of the result file.
    contacts : list of Contact or None
        Their solutions; None for each load if no field is kept.
    surface : Surface or None
        The surface in the precision of the last load; None before the first load.
    interrupted : bool
        Whether Ctrl-C came before all loads were finished.
    """

    steps: list[dict] = field(default_factory=list)
    contacts: list[Contact | None] = field(default_factory=list)
    surface: Surface | None = None
    interrupted: bool = False


def solve_loads(
    comm: Comm, scene: Scene, surfaces: Surfaces, progress: bool, keep_interrupted: bool
) -> SolvedLoads:
    """Solve all loads of a scene.

    Collective. On one process a line on standard error tells if kernels are compiled. At the end
    the transforms on the grids of kept contacts are freed.

    Parameters
    ----------
    comm : Comm
        All ranks.
    scene : Scene
        What is solved.
    surfaces : Surfaces
        Makes its surface.
    progress : bool
        Whether to draw a progress bar and print a table row of each load.
    keep_interrupted : bool
        Whether Ctrl-C after the first load ends the sweep early, on one process; otherwise
        KeyboardInterrupt is raised.

    Returns
    -------
    SolvedLoads
        The loads that are finished.
    """
    say = Reporter(comm, scene.solver, not progress, progress, bar_stream())
    loads = SolvedLoads()

    def solve_all() -> None:
        sweep = sweep_of(scene, surfaces)
        loads_of_scene = sweep.loads(scene.load)
        table = GrowingTable(
            surface_attributes(scene, sweep.surface), scene.output.observables or ()
        )
        for index, contact, seconds in solved(scene, sweep, loads_of_scene, say):
            attributes = step_attributes(scene, index, contact, seconds)
            loads.surface = contact.surface
            kept = (
                _contact_to_keep(contact, copy=index + 1 < len(loads_of_scene))
                if scene.output.fields
                else None
            )
            loads.contacts.append(kept)
            loads.steps.append(attributes)  # now the load is finished
            if progress:  # rows take longer than a small contact's iteration
                say.say(table.add({index: attributes}))

    try:
        if comm.size > 1:
            compile_once(comm, scene, lambda contact: step_attributes(scene, 0, contact, 0.0))
            solve_all()
        else:
            # said without `progress`, too: nothing else explains the wait
            with on_first_compile(Reporter(comm, scene.solver, False, False, sys.stderr).say):
                solve_all()
    except KeyboardInterrupt:
        # under MPI other ranks may not have been interrupted
        if comm.size > 1 or not (loads.steps and keep_interrupted):
            raise
        loads.interrupted = True
        del loads.contacts[len(loads.steps) :]
    _forget_transforms(loads.contacts)
    return loads


def _contact_to_keep(contact: Contact, copy: bool) -> Contact:
    """Return a contact whose fields the next load does not overwrite.

    With `copy` it has copies of them; without it, if there is no next load, it is the same object.
    """
    return replace(contact, g=contact.g.copy(), p=contact.p.copy()) if copy else contact


def _forget_transforms(contacts: Iterable[Contact | None]) -> None:
    """Free the memory of the transforms on the grids of contacts that are kept."""
    for contact in contacts:
        if contact is not None:
            grid = contact.surface.grid
            for transform in grid.planned():
                grid.forget_fft(transform.dtype)


# -- its solutions


def collect(
    comm: Comm, scene: Scene, surfaces: Surfaces, loads: SolvedLoads, start_time: str
) -> Solutions:
    """Return the solutions of the loads that are finished.

    Parameters
    ----------
    comm : Comm
        All ranks.
    scene : Scene
        What was solved.
    surfaces : Surfaces
        Has made its surface.
    loads : SolvedLoads
        At least one.
    start_time : str
        When `solve` was called.

    Returns
    -------
    Solutions
        Their fields are computed when they are read.
    """
    assert loads.surface is not None  # of the first load
    identity = scene.identity()
    if not surfaces.is_made:  # the scene does not say all about the heights
        identity += f" of {surfaces.checksum}"
    head = {
        "heights": surfaces.checksum,
        "setup_seconds": surfaces.setup_seconds,
        "scene": scene.to_toml(),
        "identity": identity,
        "versions": json.dumps(versions()),
        "start_time": start_time,
    }
    names = scene.output.fields
    result = Result(
        path=None,
        surface=surface_attributes(scene, loads.surface),
        steps=loads.steps,
        indices=list(range(len(loads.steps))),
        status=worst_status(loads.steps),
        head=head,
        fields=[{} if contact is None else _fields(names, contact) for contact in loads.contacts],
    )
    if loads.interrupted:
        note = f"interrupted: {result.missing_loads}"
        result = replace(result, status="interrupted", notes=(note,))
    return Solutions(result, loads.surface.rows, comm, loads.contacts)


def _fields(names: Iterable[str], contact: Contact) -> dict[str, Slab]:
    """Return {name: Slab} of a contact; the fields are computed when they are read."""
    surface = contact.surface
    start = surface.rows[0]
    n = (surface.n[0], surface.n[1])
    return {
        name: Slab(contact.field(name) if name in FIELDS else heights_of(surface), start, n)
        for name in names
    }


def _require_the_same(comm: Comm, scene: Scene, shape: tuple[int, ...]) -> None:
    """Raise SceneError on all ranks if some of them have another scene or shape of the heights.

    Collective. The heights themselves are not compared.
    """
    arguments = scene.to_toml(), shape
    error = SceneError(
        "hpc_gfmd.solve: found other arguments on some ranks, allowed: the same, with the whole map"
        " on each"
    )
    raise_on_all(comm, None if comm.bcast(arguments) == arguments else error)
