"""From the keywords of a Python call to a scene: each goes to the table that has a key of its name,
and the scene checks it."""

from typing import Any

import numpy as np

from ..scene import ArrayScene, Load, Machine, Material, Output, Scene, Solver
from ..scene.explain import nearest
from ..scene.not_modelled import ONLY, is_not_modelled
from ..scene.surface import Surface
from ..scene.table import Table
from ..util.errors import SceneError
from .prepared import PreparedSurface, plain

CALLER = "hpc_gfmd.solve"
TABLES: dict[str, type[Table]] = {
    "surface": Surface,
    "material": Material,
    "load": Load,
    "solver": Solver,
    "output": Output,
    "machine": Machine,
}
OF_RUNS = (
    "path",
    "dtype",
    "compression",
    "wall_seconds",
    "checkpoint_seconds",
    "memory_gib",
)  # without a result file they do nothing
HOMES = {
    key: table
    for table, model in TABLES.items()
    for key in model.model_fields
    if key not in OF_RUNS
}


def scene_of_keywords(
    given: dict[str, Any], more: dict[str, Any], surface: PreparedSurface | None = None
) -> Scene:
    """The scene of what was given (None: not given) and more, on a surface, or on an array (None).
    Raises SceneError."""
    wrong = [key for key in more if key in OF_RUNS]
    if wrong:
        raise SceneError(
            f"{CALLER}: found {wrong[0]}, allowed: in a scene, whose run writes a file"
        )
    wrong = [key for key in more if key not in HOMES and is_not_modelled(key)]
    if wrong:
        raise SceneError(f"{CALLER}: {wrong[0]}: {ONLY}, allowed: what hpc-gfmd help scene lists")
    if given.get("nu1") is not None and more.get("nu1") is not None:
        raise SceneError(f"{CALLER}: found nu and nu1, allowed: one of them")
    given = {key: plain(value) for key, value in given.items() if value is not None}
    given |= {
        key: plain(value) for key, value in more.items() if value is not None or key not in HOMES
    }
    tables: dict[str, dict[str, Any]] = {"load": {}}
    for key, value in given.items():
        table = HOMES.get(key) or HOMES[nearest(key, HOMES)]
        tables.setdefault(table, {})[key] = value
    if surface is None:
        return ArrayScene.from_dict(tables, CALLER)
    said = tables.pop("surface", {})
    if said:
        key = next(iter(said))
        raise SceneError(
            f"{key}: found {said[key]} beside a surface that knows its"
            f" {'sizes' if key == 'physical_sizes' else key}, allowed: read_surface or"
            f" make_surface(..., {key}=...)"
        )
    if surface.table is not None:
        return Scene.from_dict(tables | {"surface": surface.table}, CALLER)
    sizes = [f"{size!r} m" if surface.unit else size for size in map(float, surface.sizes)]
    ends = ["free" if end else "periodic" for end in surface.free]
    return ArrayScene.from_dict(
        tables | {"surface": {"physical_sizes": sizes, "boundary": ends}}, CALLER
    )


def loads_of(given: dict[str, Any]) -> bool:
    """Whether the load that was given is a list of loads."""
    return any(
        isinstance(value, list | tuple) or np.ndim(value) > 0
        for value in given.values()
        if not isinstance(value, str | None)
    )
