"""From a scene to its solved loads and their attributes, the same for files, memory and laws.

`check` refuses what the scene's own fields cannot, `sweep_of` makes the sweep that the tables of a
scene describe, `Run` solves its loads one after another, and `step_attributes` turns a contact into
the numbers of the result file.
"""

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..bodies import body_of
from ..contact import (
    all_distributions,
    default_observables,
    observable_names,
    observables_named,
    require_periodic,
)
from ..contact.area import a_r_discretisation
from ..contact.contact import Contact
from ..contact.peak import pressure_max_discretisation
from ..contact.response import DUALITY
from ..driver.branches import APPROACH
from ..driver.contact_model import ContactModel
from ..driver.history import History
from ..driver.load import Load, Unfinished
from ..driver.precision import DOUBLE
from ..driver.precision_forecast import first_of_scene
from ..driver.sweep import Sweep
from ..laws import attraction_of, law_names
from ..parallel import interrupt
from ..scene import File, LoadTable, Scene, each, has_unit
from ..scene.explain import require_known
from ..scene.table import about
from ..solvers import solver_names
from ..solvers.base import Progress
from ..surface import Precision, Surface
from ..surface.doubtful_numbers import modulus_notes
from ..util.errors import SceneError, SurfaceWarning
from ..util.quantities import SI, format_quantity
from .progress import Reporter
from .table import GrowingTable

MEAN_PRESSURES = "p_star", "pressure"  # loads whose values are p_star and p of the result
# the last one is the worst
STATUS_ORDER = "converged", "separated", "max_iterations", "stagnated", "nonfinite", "interrupted"


def check(scene: Scene) -> None:
    """Raise SceneError for names and combinations that `Scene` itself does not check."""
    require_periodic(scene.output.distributions, scene.surface.free, "output.distributions")
    bounds = {"error_bounds", *DUALITY} & {*(scene.output.observables or ())}
    if bounds and scene.remembers:
        raise SceneError(
            f"output.observables: found {min(bounds)!r}, a bound for the last step of a history"
            " alone, allowed with load.history or load.time: others"
        )
    for key, names, allowed in (
        ("solver.name", [scene.solver.name], ["auto", *solver_names()]),
        ("output.observables", scene.output.observables or (), observable_names()),
        ("output.distributions", scene.output.distributions, all_distributions()),
    ):
        for name in names:
            require_known(key, name, allowed)
    adhesion = scene.material.adhesion
    if adhesion is not None:
        require_known("material.adhesion.law", adhesion.law, law_names())
        if scene.solver.low_memory:
            raise SceneError(
                "solver.low_memory: found true with material.adhesion, whose stability takes ten"
                " more fields, allowed: false"
            )
    error_of_body = body_of(scene.material, scene.surface.free).error
    accuracy = scene.solver.accuracy
    if accuracy and accuracy <= error_of_body:
        raise SceneError(
            f"solver.accuracy: found {accuracy:g}, allowed with a free boundary: above"
            f" {error_of_body:g}, or a residual"
        )
    if "plastic" in scene.output.fields and scene.material.hardness is None:
        raise SceneError('output.fields: found "plastic", allowed with material.hardness')
    if scene.solver.low_memory and scene.solver.nested is False:
        raise SceneError('solver.nested: found false, allowed with solver.low_memory: true, "auto"')
    if scene.solver.low_memory and "displacement" in scene.output.fields:
        raise SceneError(
            'output.fields: found "displacement", allowed with solver.low_memory: pressure, gap,'
            " heights"
        )


def sweep_of(scene: Scene, make_surface: Callable[[Precision], Surface]) -> Sweep:
    """Return the sweep of a scene, whose surface make_surface(precision) makes. Collective."""
    model = ContactModel(
        float(scene.material.E_star),
        body_of(scene.material, scene.surface.free),
        scene.material.hardness,
        attraction_of(scene.material),
        scene.branch,
        scene.load.unique,
        getattr(scene.surface, "lam_s", None),
    )
    duality = not {"error_bounds", *DUALITY}.isdisjoint(scene.output.observables or ())
    settings = scene.solver
    if scene.remembers and settings.precision == "auto" and first_of_scene(scene) == DOUBLE:
        settings = settings.model_copy(update={"precision": "double"})  # no surface in single
    sweep = Sweep(make_surface, settings, model, duality, table=scene.load)
    _require_consistent_units(scene, sweep.surface)
    return sweep


def history_of(scene: Scene, sweep: Sweep) -> History | None:
    """Return what solves the loads of a scene whose loads leave a memory; None for others."""
    if not scene.remembers:
        return None
    elements = [(float(share), float(tau)) for share, tau in scene.material.relaxation or ()]
    return History(sweep, elements, keeps_dents=scene.load.history)


def _require_consistent_units(scene: Scene, surface: Surface) -> None:
    """Raise SceneError if a length or force has a unit and the map has none, or the reverse."""
    lengths_and_forces = {
        "material.thickness": (scene.material.thickness, "2 um"),
        "load.gap_mean": (scene.load.gap_mean, "50 nm"),
        "material.adhesion.range": (
            scene.material.adhesion and scene.material.adhesion.range,
            "2 nm",
        ),
        "load.approach": (scene.load.approach, "10 nm"),
        "load.force": (scene.load.force, "5 mN"),
    }
    if not isinstance(scene.surface, File):
        return
    for key, (value, example) in lengths_and_forces.items():
        for number in each(value):
            if number and has_unit(number) != bool(surface.unit):
                if surface.unit:
                    kind = "plain"
                    allowed = f'"{example}"'
                else:
                    kind = "with a unit"
                    allowed = "a plain number, as in the height map"
                raise SceneError(
                    f"{key}: found {format_quantity(number)}, {kind}, allowed with this height"
                    f" map: {allowed}"
                )


def surface_attributes(scene: Scene, surface: Surface) -> dict[str, Any]:
    """Return the attributes of a surface by their names in the file; nan (seed: -1) if unknown."""
    spec = scene.surface
    attributes = {
        "n": list(surface.n),
        "physical_sizes": list(surface.sizes),
        "h_rms": surface.h_rms,
        "g_rms": surface.g_rms,
        "kind": getattr(spec, "kind", "array"),
        "boundary": ", ".join("free" if is_free else "periodic" for is_free in spec.free),
        "unit": surface.unit or scene.length_unit,
        "pressure_unit": scene.pressure_unit,
        "time_unit": scene.time_unit,
        "prepared": list(surface.prepared),
        "notes": [str(note) for note in notes_on(scene, surface)],
        **{name: getattr(spec, name, float("nan")) for name in ("eps_t", "eps_f", "eps_c")},
        "seed": getattr(spec, "seed", -1),
        "hurst": getattr(spec, "hurst", ""),
    }
    return {name: value for name, value in attributes.items() if value not in ("", [])}


def notes_on(scene: Scene, surface: Surface) -> tuple[SurfaceWarning, ...]:
    """Return what may be wrong with a surface and its units."""
    return (*modulus_notes(scene.material.E_star, surface.unit), *surface.notes)


@dataclass(frozen=True)
class SolvedLoad:
    """One load of a run, as `Run.solve` yields it."""

    index: int  # its number in the scene, from 0
    contact: Contact  # whose fields the next load overwrites
    seconds: float  # time spent on it
    numbers: dict[str, Any]  # `step_attributes`; empty if the load was stopped


Watch = Callable[[], int]  # called after every iteration; true: the load has to stop
UnfinishedOf = Callable[[int], tuple[Unfinished, float] | None]  # state of a load, seconds spent


class Run:
    """The loads of a scene on its surface, which make_surface(precision) makes. Collective.

    `sweep` solves them: a Sweep, or a History if loads leave a memory, which is then also
    `history`, else None. `attributes`: of the surface, by their names in the file.
    """

    def __init__(
        self, scene: Scene, make_surface: Callable[[Precision], Surface], reporter: Reporter
    ) -> None:
        self.scene = scene
        self.reporter = reporter
        sweep = sweep_of(scene, make_surface)
        self.history = history_of(scene, sweep)
        self.sweep = self.history or sweep
        self.loads = self.sweep.loads(scene.load)
        self.attributes = surface_attributes(scene, self.surface)
        self.table = GrowingTable(self.attributes, scene.output.observables or ())

    @property
    def surface(self) -> Surface:
        """The surface in the precision of the present load."""
        return self.sweep.surface

    def solve(
        self,
        indices: Sequence[int] | None = None,
        stops: Watch = lambda: False,
        unfinished_of: UnfinishedOf = lambda index: None,
    ) -> Iterator[SolvedLoad]:
        """Solve loads one after another and yield each; all kinds of runs use this loop.

        The next load is solved when it is asked for. On the retraction branch, in a cycle of
        adhesion, and without the stored memory of a history, the loads before the first of
        `indices` are solved, too, but not yielded.

        Parameters
        ----------
        indices : sequence of int, optional
            The loads to solve; default: all.
        stops : callable, optional
            Whether to stop; the load then has the status "interrupted".
        unfinished_of : callable, optional
            The state of a load that an earlier run has begun, and the seconds spent on it.
        """
        wanted = range(len(self.loads)) if indices is None else indices
        if self.history is not None:
            begins_anew = not self.history.has_begun
        else:
            is_followed = self.scene.branch != APPROACH
            begins_anew = is_followed and bool(wanted) and unfinished_of(wanted[0]) is None
        if begins_anew and wanted:
            for load in self.loads[: wanted[0]]:
                self.sweep.solve(load, lambda *_: interrupt.check(self.surface.grid.comm))
        for index in wanted:
            unfinished, seconds_before = unfinished_of(index) or (None, 0.0)
            yield self._solve(index, stops, unfinished, seconds_before)
            del unfinished  # its fields make room for the next load

    def solve_further(self, pressure: float, gap: np.ndarray) -> SolvedLoad:
        """Solve one more load from a gap (local slab, program's unit) and add it to `loads`."""
        name, values = self.scene.load.prescribed
        E_star = float(self.scene.material.E_star)
        area = float(np.prod(self.surface.sizes))
        value = pressure / self.scene.load.unit(E_star, self.surface.g_rms, area)
        self.scene = with_loads(self.scene, **{name: [*values, value]})
        self.loads.append(Load("pressure", pressure))
        start = Unfinished(gap, pressure, 0, 0.0)
        return self._solve(len(self.loads) - 1, unfinished=start)

    def _solve(
        self,
        index: int,
        stops: Watch = lambda: False,
        unfinished: Unfinished | None = None,
        seconds_before: float = 0.0,
    ) -> SolvedLoad:
        begun = time.monotonic() - seconds_before
        self.reporter.step(self._title(index))
        try:
            contact = self.sweep.solve(self.loads[index], self._watch(stops), unfinished)
        finally:
            self.reporter.done()
        seconds = time.monotonic() - begun
        is_stopped = contact.status == "interrupted"
        numbers = {} if is_stopped else step_attributes(self.scene, index, contact, seconds)
        return SolvedLoad(index, contact, seconds, numbers)

    def show(self, steps: dict[int, dict]) -> None:
        """Print the table rows of finished loads, by their numbers."""
        # a row takes longer than an iteration of a small contact
        if steps and not self.reporter.silent:
            self.reporter.say(self.table.add(steps))

    def _watch(self, stops: Watch) -> Callable[[int, Progress], bool]:
        """Return what the solver calls after every iteration."""

        def watch(iterations: int, progress: Progress) -> bool:
            self.reporter.watch(iterations, progress)
            return bool(stops())

        return watch

    def _title(self, index: int) -> str:
        """Return number and target of a load for the line of progress; p* for any pressure."""
        name, values = self.scene.load.prescribed
        target = f"{name} = {values[index]:.4g}"
        if name in MEAN_PRESSURES:
            target = f"p* = {self.loads[index].value / self.sweep.working.pressure_unit:.4g}"
        return f"load {index + 1}/{len(self.loads)}, {target}"


def with_loads(scene: Scene, **loads: Iterable[float]) -> Scene:
    """Return a scene with other numbers for keys of [load] that it has, in SI units if it has
    units.
    """
    tables = scene.model_dump(exclude_none=True)
    for name, numbers in loads.items():
        dimension = about(LoadTable.model_fields[name])["unit"]
        has_units = has_unit(getattr(scene.load, name))
        if dimension in ("pressure", "force"):  # a load of 0 needs no unit
            has_units = has_units or bool(scene.pressure_unit)
        if has_units:
            tables["load"][name] = [f"{float(number)!r} {SI[dimension]}" for number in numbers]
        else:
            tables["load"][name] = [float(number) for number in numbers]
    return type(scene).from_dict(tables)


def _target(load: LoadTable, index: int) -> dict[str, float]:
    """Return {"target_NAME": value}, scene's units, of a load that is no pressure, else {}."""
    name, values = load.prescribed
    return {} if name in MEAN_PRESSURES else {f"target_{name}": float(values[index])}


def step_attributes(scene: Scene, index: int, contact: Contact, seconds: float) -> dict[str, Any]:
    """Return the attributes of a load by their names in the file; None if unknown. Collective."""
    observables = observables_named([*default_observables(), *(scene.output.observables or ())])
    numbers = {name: observable(contact) for name, observable in observables.items()}
    for name, distribution in all_distributions().items():
        if name in scene.output.distributions:
            arrays = distribution(contact)
            numbers |= {
                f"{name}_{part}": values.tolist() for part, values in (arrays or {}).items()
            }
    area, gap, pressure = contact.certificate.errors
    times = scene.load.time
    attributes = {
        **({} if times is None else {"time": float(times[index])}),
        "p": contact.p_mean,
        "p_star": contact.p_star,
        "iterations": contact.iterations,
        "fft_pairs": contact.fft_pairs,
        "wall_seconds": seconds,
        "status": contact.status,
        "a_r_error": area,
        "a_r_discretisation": a_r_discretisation(contact),
        "gap_discretisation": contact.gap_discretisation,
        "pressure_max_discretisation": pressure_max_discretisation(contact),
        "p_error": contact.certificate.p0_error,
        "gap_error": gap,
        "pressure_error": pressure,
        "precision": contact.g.dtype.name,
        "residual": contact.certificate.residual,
        "note": contact.note,
    }
    return attributes | _target(scene.load, index) | contact.certificate.attributes() | numbers


def worst_status(steps: Sequence[dict]) -> str:
    """Return the worst status (STATUS_ORDER) of load steps, at least one, from their attributes."""
    return max((step["status"] for step in steps), key=STATUS_ORDER.index)
