"""From the keywords of a Python call to a scene: each goes to the table that has a key of its name,
and the scene checks it."""

from typing import Any

import numpy as np

from ..scene import ArrayScene, Load, Scene
from ..scene.explain import nearest
from ..scene.not_modelled import not_modelled
from ..scene.table import Table
from ..util.errors import SceneError
from .prepared import PreparedSurface, plain

CALLER = "hpc_gfmd.solve"
# without a result file these do nothing
OF_RUNS = "path", "dtype", "compression", "wall_seconds", "memory_gib"
HOMES = {  # key: its table
    key: table
    for table, model in ArrayScene.model_fields.items()
    if isinstance(model.annotation, type) and issubclass(model.annotation, Table)
    for key in model.annotation.model_fields
    if key not in OF_RUNS
}


def scene_of_keywords(
    given: dict[str, Any], more: dict[str, Any], surface: PreparedSurface | None
) -> Scene:
    """Make the scene of what was given (None: not given) and more, on a surface, or on an array
    (None). Raises SceneError."""
    for key in more:
        if key in OF_RUNS:
            raise SceneError(f"{CALLER}: found {key}, allowed: in a scene, whose run writes a file")
        if key not in HOMES and (why := not_modelled(key)):
            raise SceneError(f"{CALLER}: {key}: {why}, allowed: what hpc-gfmd help scene lists")
    if given.get("nu1") is not None and "nu1" in more:
        raise SceneError(f"{CALLER}: found nu and nu1, allowed: one of them")
    tables: dict[str, dict[str, Any]] = {"load": {}}
    for key, value in (given | more).items():
        if value is not None or key not in HOMES:
            table = HOMES.get(key) or HOMES[nearest(key, HOMES)]
            tables.setdefault(table, {})[key] = plain(value)
    if surface is None:
        return ArrayScene.from_dict(tables, CALLER)
    said = tables.pop("surface", {})
    if said:
        key = next(iter(said))
        raise SceneError(
            f"{key}: found {said[key]} beside a surface that knows its"
            f" {'sizes' if key == 'physical_sizes' else key}, allowed: read_surface,"
            f" prepare_surface or make_surface(..., {key}=...)"
        )
    if surface.table is not None:
        return Scene.from_dict(tables | {"surface": surface.table}, CALLER)
    sizes = [f"{size!r} m" if surface.unit else size for size in map(float, surface.sizes)]
    ends = ["free" if end else "periodic" for end in surface.free]
    return ArrayScene.from_dict(
        tables | {"surface": {"physical_sizes": sizes, "boundary": ends}}, CALLER
    )


def several_loads(given: dict[str, Any]) -> bool:
    """Tell whether the load that was given is a list of loads."""
    values = (given.get(key) for key in Load.model_fields)
    return any(np.ndim(value) > 0 for value in values if value is not None)
