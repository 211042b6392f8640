"""Solvers of the loads of an interface law: of surfaces in memory, or of scenes on all ranks."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from os import PathLike
from typing import Any

import numpy as np

from ..contact.contact import heights_of
from ..output.summary import surface_line
from ..parallel.comm import Comm
from ..parallel.guard import on_rank_0
from ..parallel.thread_count import threads_of
from ..parallel.world import comm_of, world
from ..scene import Scene, load_scene
from ..surface import build_surface, surface_size
from ..surface.arrays import is_topography
from ..util.errors import SceneError
from .loads import check, solved, step_attributes, surface_attributes, sweep_of
from .prepared import PreparedSurface
from .progress import Reporter
from .solve import solve
from .surfaces import surface_of_topography

ACCURACY_SHARE = 0.1  # of the law's error: accuracy of its loads, so that it does not deviate by it
Steps = list[dict[str, Any]]  # attributes of loads: several of one surface, or one of each surface
Pressures = Sequence[float | str]


def sampler_of(
    surfaces: Any,
    quantities: Sequence[str],
    error: float,
    realisations: int,
    keys: Mapping[str, Any],
    comm: Any,
    progress: bool,
) -> HeightSampler | SceneSampler:
    """Return the callable that solves all surfaces at given pressures.

    Parameters
    ----------
    surfaces, quantities, error, realisations, keys, comm, progress
        As for `interface_law`.

    Returns
    -------
    HeightSampler or SceneSampler
        Called with pressures it returns the attributes of the loads of each surface.

    Raises
    ------
    SceneError
        For no surface, for scenes beside heights or keywords, and for realisations of heights.
    """
    listed = list(surfaces) if isinstance(surfaces, list | tuple) else [surfaces]
    if not listed:
        raise SceneError("surfaces: found none, allowed: one surface, or a list of them")
    scenes = [isinstance(surface, str | PathLike | Scene) for surface in listed]
    if any(scenes):
        if not all(scenes) or keys:
            beside = f"{next(iter(keys))}=" if keys else "heights"
            raise SceneError(
                f"surfaces: found scenes beside {beside}, allowed: scenes alone, which say all"
            )
        return SceneSampler(listed, quantities, error, realisations, comm, progress)
    if realisations != 1:
        raise SceneError("realisations: found with heights, allowed: with scenes")
    return HeightSampler(listed, quantities, error, keys, progress)


def requested(quantities: Sequence[str]) -> list[str]:
    """Return the observables to compute for a law: also the stiffness, if it has a conductance."""
    with_stiffness = "conductance" in quantities and "stiffness" not in quantities
    return [*quantities, "stiffness"] if with_stiffness else list(quantities)


def of_interface(steps: Steps, E_star: float) -> Steps:
    """Return the attributes of loads with the conductance of an interface: stiffness/E_star.

    That of a body with free edges is smaller: it contains the spreading resistance of the body.
    """
    of_interface = []
    for step in steps:
        stiffness = step.get("stiffness")
        if step.get("conductance") is not None and stiffness is not None:
            step = step | {"conductance": stiffness / E_star}
        of_interface.append(step)
    return of_interface


class HeightSampler:
    """Solves loads of surfaces in memory, on this process.

    Parameters
    ----------
    surfaces : iterable
        What `solve` takes.
    quantities : sequence of str
        Numbers to compute for each load.
    error : float
        Error of the law. The accuracy of the loads is ACCURACY_SHARE of it unless `keys` has
        accuracy or residual.
    keys : mapping
        Further arguments of `solve`.
    progress : bool
        Whether to draw progress bars.
    """

    def __init__(
        self,
        surfaces: Iterable[Any],
        quantities: Sequence[str],
        error: float,
        keys: Mapping[str, Any],
        progress: bool,
    ) -> None:
        surfaces = list(surfaces)
        boundary = keys.get("boundary")
        self.surfaces = [
            surface_of_topography(surface, boundary) if is_topography(surface) else surface
            for surface in surfaces
        ]
        if any(map(is_topography, surfaces)):  # which have it now
            keys = {key: value for key, value in keys.items() if key != "boundary"}
        accuracy = {"accuracy": ACCURACY_SHARE * error} if "residual" not in keys else {}
        self.keys = accuracy | {"observables": requested(quantities), "fields": ()} | dict(keys)
        self.progress = progress
        self.surface: dict[str, Any] = {}

    def __call__(self, pressures: Pressures) -> list[Steps]:
        """Solve all surfaces at some pressures; return the attributes of their loads.

        One list for each surface, in the order of the pressures.
        """
        sampled = []
        for surface in self.surfaces:
            solutions = solve(surface, pressures, progress=self.progress, **self.keys)
            self.surface = self.surface or solutions.result.surface
            sampled.append(
                of_interface(solutions.result.steps, solutions.result.scene.material.E_star)
            )
        return sampled

    def facts(self) -> dict[str, Any]:
        """Return what the law tells of its surfaces; only after the first loads were solved.

        A dict with "surface" (attributes of the first one), "pressure_unit", "gap_at_touch" (mean
        gap when the highest point just touches, in the unit of the heights, averaged over the
        surfaces) and "about" (lines of text).
        """
        heights = [s.heights if isinstance(s, PreparedSurface) else s for s in self.surfaces]
        return {
            "surface": self.surface,
            "pressure_unit": self.surface.get("pressure_unit", ""),
            "gap_at_touch": float(np.mean([np.max(z) - np.mean(z) for z in heights])),
            "about": (surface_line(self.surface),),
        }


class SceneSampler:
    """Solves loads of scenes, on all ranks together.

    Parameters
    ----------
    scenes : sequence of path or Scene
        Their [load] and [output] are ignored. An accuracy that is coarser than ACCURACY_SHARE of
        `error` is refined to that.
    quantities, error, progress
        As for HeightSampler.
    realisations : int
        Number of surfaces of each scene, with consecutive seeds.
    comm : Comm or communicator of mpi4py, optional
        Default: all ranks.
    """

    def __init__(
        self,
        scenes: Sequence[str | PathLike | Scene],
        quantities: Sequence[str],
        error: float,
        realisations: int,
        comm: Any,
        progress: bool,
    ) -> None:
        self.comm: Comm = world() if comm is None else comm_of(comm)
        self.quantities = quantities
        self.accuracy = ACCURACY_SHARE * error
        self.progress = progress
        self.scenes = [
            realisation
            for scene in scenes
            for realisation in on_rank_0(
                self.comm, "reading the scene", partial(_realisations, scene, realisations)
            )
        ]
        self.surface: dict[str, Any] = {}
        self.gaps: dict[int, float] = {}

    def __call__(self, pressures: Pressures) -> list[Steps]:
        """Solve all surfaces at some pressures; return the attributes of their loads. Collective.

        One list for each surface, in the order of the pressures.
        """
        return [self._solve(k, scene, pressures) for k, scene in enumerate(self.scenes)]

    def _solve(self, number: int, scene: Scene, pressures: Pressures) -> Steps:
        """Solve one scene at some pressures and return the attributes of its loads in their order.

        `number` is its place among the scenes. At the first call the mean gap when its highest
        point just touches is stored in `gaps`. Collective.
        """
        tables = tomllib.loads(scene.to_toml())
        tables["load"] = {"pressure": list(pressures)}
        tables["output"] = {"observables": requested(self.quantities)}
        if "residual" not in tables["solver"]:
            of_scene = tables["solver"].get("accuracy", self.accuracy)
            tables["solver"]["accuracy"] = min(of_scene, self.accuracy)
        at_pressures = Scene.from_dict(tables)
        check(at_pressures)
        n, _ = surface_size(scene.surface)
        threads = threads_of(self.comm, scene.machine.threads, n[0] * n[1])
        low_memory = scene.solver.low_memory

        def make_surface(dtype: np.dtype) -> Any:
            return build_surface(scene.surface, self.comm, dtype, threads, low_memory)

        sweep = sweep_of(at_pressures, make_surface)
        attributes = surface_attributes(at_pressures, sweep.surface)
        self.surface = self.surface or attributes
        if number not in self.gaps:
            heights = heights_of(sweep.surface)[:]
            total = float(self.comm.sum([float(np.sum(heights, dtype=float))])[0])
            self.gaps[number] = -total / (n[0] * n[1])
        say = Reporter(self.comm, at_pressures.solver, not self.progress)
        loads = sweep.loads(at_pressures.load)
        steps = [
            step_attributes(at_pressures, index, contact, seconds)
            for index, contact, seconds in solved(at_pressures, sweep, loads, say)
        ]
        return of_interface(steps, at_pressures.material.E_star)

    def facts(self) -> dict[str, Any]:
        """Return what the law tells of its surfaces, as HeightSampler.facts. Not collective.

        "about" begins with the first title that a scene has.
        """
        titles = [scene.title for scene in self.scenes if scene.title]
        return {
            "surface": self.surface,
            "pressure_unit": self.surface.get("pressure_unit", ""),
            "gap_at_touch": float(np.mean(list(self.gaps.values()))),
            "about": (*titles[:1], surface_line(self.surface)),
        }


def _realisations(scene: str | PathLike | Scene, realisations: int) -> list[Scene]:
    """Return copies of a scene with the seeds seed, seed + 1, ..., as many as `realisations`.

    1: only the scene itself. It is read if it is a path. Raises SceneError for any number but 1 of
    a surface without a seed, and for less than 1.
    """
    original = scene if isinstance(scene, Scene) else load_scene(scene)
    if realisations == 1:
        return [original]
    if not hasattr(original.surface, "seed"):
        raise SceneError(
            f"realisations: found {realisations} of a surface without a seed, allowed: 1, or a"
            " self-affine surface"
        )
    if realisations < 1:
        raise SceneError(f"realisations: found {realisations}, allowed: a whole number from 1")
    seeds = range(original.surface.seed, original.surface.seed + realisations)
    surfaces = [original.surface.model_copy(update={"seed": seed}) for seed in seeds]
    return [original.model_copy(update={"surface": surface}) for surface in surfaces]
