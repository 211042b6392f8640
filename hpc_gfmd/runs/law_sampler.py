"""The loads of an interface law: of surfaces in memory, or of scenes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from operator import attrgetter
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from ..contact.fields import heights_of
from ..output.summary import surface_line
from ..parallel.guard import on_rank_0
from ..parallel.world import comm_of
from ..scene import Scene, load_scene
from ..scene.history import refuse_relaxation
from ..scene.settings import HOW
from ..util.errors import SceneError
from .in_memory import Surfaces, is_scene, kernels_ready, scene_and_surface, surfaces_of_scene
from .loads import Run, check, with_loads
from .progress import Reporter

if TYPE_CHECKING:
    from ..surface import Surface

ACCURACY_SHARE = 0.1  # of the law's error: accuracy of its loads, so that it does not deviate by it
Steps = list[dict[str, Any]]  # attributes of loads: several of one surface, or one of each surface


class Sampler:
    """Solves all surfaces of a law at given pressures, the first of which is `pressure`. After the
    first loads it has `surface` (attributes of the first one) and `gaps` (mean gap of each at
    touch). Collective.
    """

    def __init__(
        self,
        surfaces: Any,
        quantities: Sequence[str],
        error: float,
        realisations: int,
        keys: Mapping[str, Any],
        comm: Any,
        progress: bool,
        pressure: float,
    ) -> None:
        listed = list(surfaces) if isinstance(surfaces, list | tuple) else [surfaces]
        has_scenes = _has_scenes(listed, keys)
        with_stiffness = "conductance" in quantities and "stiffness" not in quantities
        self.observables = [*quantities, *["stiffness"] * with_stiffness]
        self.accuracy = ACCURACY_SHARE * error
        self.pressure = pressure
        self.progress = progress
        self.surface: dict[str, Any] = {}
        self.gaps: dict[int, float] = {}
        self.members: list[tuple[Scene, Surfaces]]
        self.comm = comm_of(comm)
        if has_scenes:
            self.members = self._scenes(listed, realisations)
        elif realisations != 1:
            raise SceneError("realisations: found with heights, allowed: with scenes")
        else:
            self.members = [self._heights(heights, keys) for heights in listed]

    def _scenes(
        self, listed: Sequence[str | PathLike | Scene], realisations: int
    ) -> list[tuple[Scene, Surfaces]]:
        """Return all realisations of the scenes, each with what makes its surface."""
        scenes = [
            made
            for scene in listed
            for made in on_rank_0(
                self.comm, "reading the scene", partial(_realisations, scene, realisations)
            )
        ]
        keep = len(scenes) == 1  # more are made again: together they may not fit into the memory
        return [
            (
                self._of_law(self._refined(scene)),
                surfaces_of_scene(self.comm, scene, keep, is_only_one=keep),
            )
            for scene in scenes
        ]

    def _refined(self, scene: Scene) -> Scene:
        """Return a scene whose accuracy suffices for the law."""
        solver = scene.solver
        if solver.residual is not None:
            return scene
        accuracy = min(solver.accuracy or self.accuracy, self.accuracy)
        return scene.model_copy(update={"solver": solver.model_copy(update={"accuracy": accuracy})})

    def _heights(self, heights: Any, keys: Mapping[str, Any]) -> tuple[Scene, Surfaces]:
        """Return a scene of heights in memory, and what makes their surface."""
        if keys.get("relaxation") is not None:
            refuse_relaxation({"material": keys}, "interface_law")
        for key in HOW:
            if key in keys:
                raise SceneError(
                    f"{key}: found in a law, whose loads do not follow from each other, allowed: a"
                    " law without it"
                )
        accuracy = {"accuracy": self.accuracy} if "residual" not in keys else {}
        arguments = {"pressure": self.pressure} | accuracy | dict(keys)
        scene, surfaces = scene_and_surface(self.comm, heights, arguments)
        return self._of_law(scene), surfaces

    def _of_law(self, scene: Scene) -> Scene:
        """Return a scene whose load and output are those of the law."""
        tables = scene.model_dump(exclude_none=True)
        refuse_relaxation(tables)
        tables["load"] = {"pressure": self.pressure}
        tables["output"] = {"observables": self.observables}
        scene = type(scene).from_dict(tables)
        check(scene)
        return scene

    def __call__(self, pressures: Sequence[float]) -> list[Steps]:
        """Solve all surfaces at some pressures; return their loads' attributes by surface."""
        return [self._solve(k, pressures) for k in range(len(self.members))]

    def _solve(self, k: int, pressures: Sequence[float]) -> Steps:
        scene, surfaces = self.members[k]
        scene = with_loads(scene, pressure=pressures)
        reporter = Reporter(self.comm, scene.solver, not self.progress)
        with kernels_ready(self.comm, scene):
            run = Run(scene, surfaces, reporter)
            self.surface = self.surface or run.attributes
            if k not in self.gaps:
                self.gaps[k] = self._gap_at_touch(run.surface)
            steps = map(attrgetter("numbers"), run.solve())
            points = run.surface.grid.N / run.surface.images  # images touch together
            return [_of_interface(step, scene.material.E_star, points) for step in steps]

    def _gap_at_touch(self, surface: Surface) -> float:
        """Return the mean gap when the highest point of a surface just touches."""
        total = float(self.comm.sum([float(np.sum(heights_of(surface)[:], dtype=float))])[0])
        return -total / (surface.n[0] * surface.n[1])

    @property
    def gap_at_touch(self) -> float:
        """Mean over the surfaces of the mean gap when the highest point just touches."""
        return float(np.mean(list(self.gaps.values())))

    @property
    def about(self) -> list[str]:
        """Lines on the surfaces: the first title of a scene, and the first surface."""
        titles = [scene.title for scene, _ in self.members if scene.title]
        return [*titles[:1], surface_line(self.surface)]


def _has_scenes(surfaces: Sequence[Any], keys: Mapping[str, Any]) -> bool:
    """Whether surfaces are scenes; SceneError if only some are, or keywords stand beside them."""
    if not surfaces:
        raise SceneError("surfaces: found none, allowed: one surface, or a list of them")
    scenes = [is_scene(surface) or isinstance(surface, str | PathLike) for surface in surfaces]
    if any(scenes) and (keys or not all(scenes)):
        beside = f"{next(iter(keys))}=" if keys else "heights"
        raise SceneError(
            f"surfaces: found scenes beside {beside}, allowed: scenes alone, which say all"
        )
    return any(scenes)


def _of_interface(step: dict[str, Any], E_star: float, points: float) -> dict[str, Any]:
    """Return a load with the number of its contact points, of so many in all, and the conductance
    stiffness/E_star: no spreading resistance of the body.
    """
    step = step | {"contact_points": step["a_r"] * points}
    stiffness = step.get("stiffness")
    if step.get("conductance") is None or stiffness is None:
        return step
    return step | {"conductance": stiffness / E_star}


def _realisations(scene: str | PathLike | Scene, realisations: int) -> list[Scene]:
    """Return copies of a scene with the seeds seed, seed + 1, ...; for 1 only the scene itself."""
    original = scene if isinstance(scene, Scene) else load_scene(scene, needs_load=False)
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
