"""From a scene to its solved loads and their attributes, for runs with files and for solves in
memory.
"""

import time
from collections.abc import Callable, Iterator, Sequence
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
from ..contact.response import DUALITY
from ..driver.branches import RETRACTION
from ..driver.load import Load, Unfinished
from ..driver.sweep import Sweep, make_sweep
from ..laws import attraction_of, law_names
from ..parallel import interrupt
from ..scene import File, LoadTable, Scene, each, has_unit
from ..scene.explain import require_known
from ..solvers import solver_names
from ..solvers.base import Progress
from ..surface import Surface
from ..util.errors import SceneError
from ..util.quantities import format_quantity
from .progress import Reporter

# the last one is the worst
STATUS_ORDER = "converged", "separated", "max_iterations", "stagnated", "nonfinite", "interrupted"


def check(scene: Scene) -> None:
    """Raise SceneError for invalid names and combinations that `Scene` itself does not check.

    These are unknown names (solver, observables, distributions, law), distributions that need a
    periodic surface, an accuracy that free boundaries do not reach, fields that the material or
    low_memory excludes, and low_memory with adhesion or without nested iteration. Nothing is read
    or allocated.
    """
    require_periodic(scene.output.distributions, scene.surface.free, "output.distributions")
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


def sweep_of(scene: Scene, make_surface: Callable[[np.dtype], Surface]) -> Sweep:
    """Return the sweep that solves the loads of a scene; it makes the surface in a first precision.

    Collective.

    Parameters
    ----------
    scene : Scene
        What is solved.
    make_surface : callable
        ``make_surface(dtype)`` returns its surface in a precision; collective. The sweep calls it
        again later if a load needs another precision.

    Returns
    -------
    Sweep
        No load is solved yet.

    Raises
    ------
    SceneError
        If a load or length of the scene has a unit and the height map has none, or vice versa, and
        as `make_surface`.
    """
    sweep = make_sweep(
        make_surface,
        scene.solver,
        scene.material.E_star,
        getattr(scene.surface, "lam_s", None),
        duality=not {"error_bounds", *DUALITY}.isdisjoint(scene.output.observables or ()),
        body=body_of(scene.material, scene.surface.free),
        hardness=scene.material.hardness,
        attraction=attraction_of(scene.material),
        branch=scene.load.branch,
        unique=scene.load.unique,
    )
    _require_consistent_units(scene, sweep.surface)
    return sweep


def _require_consistent_units(scene: Scene, surface: Surface) -> None:
    """Raise SceneError if a length or force has a unit and the height map none, or vice versa.

    Only a surface from a file is checked, and only numbers other than 0.
    """
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
    """Return the attributes of a surface, by the names of the result file.

    Parameters
    ----------
    scene : Scene
        What is solved.
    surface : Surface
        Its surface, in any precision.

    Returns
    -------
    dict
        Numbers, lists and texts by name; empty texts are left out. Of a surface without a spectrum
        eps_t, eps_f and eps_c are nan; of one without a seed "seed" is -1.
    """
    spec = scene.surface
    attributes = {
        "n": list(surface.n),
        "physical_sizes": list(surface.sizes),
        "h_rms": surface.h_rms,
        "g_rms": surface.g_rms,
        "kind": getattr(spec, "kind", "array"),
        "boundary": ", ".join("free" if ends else "periodic" for ends in spec.free),
        "unit": surface.unit or scene.length_unit,
        "pressure_unit": scene.pressure_unit,
        "prepared": "; ".join(surface.prepared),
        **{name: getattr(spec, name, float("nan")) for name in ("eps_t", "eps_f", "eps_c")},
        "seed": getattr(spec, "seed", -1),
        "hurst": getattr(spec, "hurst", ""),
    }
    return {name: value for name, value in attributes.items() if value != ""}


def solved(
    scene: Scene,
    sweep: Sweep,
    loads: Sequence[Load],
    say: Reporter,
    watch: Callable[[int, float], bool] = lambda index, seconds: False,
    indices: Sequence[int] | None = None,
    unfinished_of: Callable[[int], tuple[Unfinished, float] | None] = lambda index: None,
) -> Iterator[tuple[int, Contact, float]]:
    """Solve loads one after the other and yield each; the next one is solved when it is requested.

    Collective. All runs use this loop. On the retraction branch the loads before the first of
    `indices` are solved, too, if it needs their solution; they are not yielded.

    Parameters
    ----------
    scene : Scene
        What is solved.
    sweep : Sweep
        That of the scene.
    loads : sequence of Load
        All loads of the scene, as from `Sweep.loads`.
    say : Reporter
        Shows the progress of each load.
    watch : callable, optional
        Called after every iteration with the index of the load and the seconds spent on it; if it
        returns true, the load is stopped with the status "interrupted".
    indices : sequence of int, optional
        The loads to solve; default: all.
    unfinished_of : callable, optional
        Called with the index of a load; returns the state of that load from a run that was stopped
        and the seconds spent on it, or None if it has to start from the beginning.

    Yields
    ------
    (int, Contact, float)
        Index, solution and seconds spent. The next load overwrites the fields of the contact.
    """
    wanted = range(len(loads)) if indices is None else indices
    _solve_loads_before(scene, sweep, loads, next(iter(wanted), 0), unfinished_of)
    for index in wanted:
        load = loads[index]
        unfinished, seconds_before = unfinished_of(index) or (None, 0.0)
        begun = time.monotonic() - seconds_before

        def watched(
            iterations: int, progress: Progress, index: int = index, begun: float = begun
        ) -> bool:
            """Show the progress after an iteration; return whether the load has to stop."""
            say.watch(iterations, progress)
            return watch(index, time.monotonic() - begun)

        say.step(index, len(loads), *_shown_target(scene, sweep, load, index))
        try:
            contact = sweep.solve(load, watched, unfinished)
        finally:
            say.done()
        yield index, contact, time.monotonic() - begun
        del contact, unfinished  # their fields make room for the next load


def _solve_loads_before(
    scene: Scene,
    sweep: Sweep,
    loads: Sequence[Load],
    index: int,
    unfinished_of: Callable[[int], tuple[Unfinished, float] | None],
) -> None:
    """Solve the loads before `index` if load `index` has to start from their solution. Collective.

    It has to on the retraction branch, unless `unfinished_of` returns its own stored state. Nothing
    is returned: the solutions only remain in the sweep.
    """
    if scene.load.branch == RETRACTION and unfinished_of(index) is None:
        for load in loads[:index]:
            sweep.solve(load, lambda *_: interrupt.check(sweep.surface.grid.comm))


def _shown_target(scene: Scene, sweep: Sweep, load: Load, index: int) -> tuple[str, float]:
    """Return (name, value) of a load for the line of progress.

    Of a force, area, gap or approach: as the scene prescribes it for load `index`, in its units. Of
    any pressure: ("p_star", p* of `load`).
    """
    for name, value in _target(scene.load, index).items():
        return name.removeprefix("target_"), value
    return "p*", load.value / sweep.working.pressure_unit


def _target(load: LoadTable, index: int) -> dict[str, float]:
    """Return {"target_NAME": value} of load `index`, in the scene's units.

    NAME is force, area, gap or approach; {} if the scene prescribes p_star or pressure.
    """
    name, values = load.prescribed
    return {} if name in ("p_star", "pressure") else {f"target_{name}": float(values[index])}


def step_attributes(scene: Scene, index: int, contact: Contact, seconds: float) -> dict[str, Any]:
    """Return the attributes of a solved load, by the names of the result file.

    Collective. It computes the default observables, and the observables and distributions that the
    scene requests.

    Parameters
    ----------
    scene : Scene
        What is solved.
    index : int
        Number of the load.
    contact : Contact
        Its solution.
    seconds : float
        Time spent on it.

    Returns
    -------
    dict
        Numbers, lists and texts by name. An observable without a value is None; a distribution to
        which no point contributes is left out.
    """
    observables = observables_named([*default_observables(), *(scene.output.observables or ())])
    numbers = {name: observable(contact) for name, observable in observables.items()}
    for name, distribution in all_distributions().items():
        if name in scene.output.distributions:
            arrays = distribution(contact)
            numbers |= {
                f"{name}_{part}": values.tolist() for part, values in (arrays or {}).items()
            }
    area, gap, pressure = contact.certificate.errors
    attributes = {
        "p": contact.p_mean,
        "p_star": contact.p_star,
        "iterations": contact.iterations,
        "fft_pairs": contact.fft_pairs,
        "wall_seconds": seconds,
        "status": contact.status,
        "a_r_error": area,
        "a_r_discretisation": float(a_r_discretisation(contact)),
        "gap_discretisation": None if contact.of_grid is None else contact.of_grid.gap,
        "pressure_max_discretisation": (
            None if contact.of_grid is None else contact.of_grid.pressure_max
        ),
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
