"""The scene that the keywords of a Python call describe.

Each keyword goes to the table that has a key of its name, and the scene validates it.
"""

from typing import Any

import numpy as np

from ..scene import ArrayScene, LoadTable, Scene
from ..scene.explain import nearest
from ..scene.model import HEIGHTS_IN_MEMORY
from ..scene.not_modelled import not_modelled
from ..scene.table import Table
from ..util.errors import SceneError
from .prepared import PreparedSurface
from .surfaces import plain

CALLER = "hpc_gfmd.solve"
# keys that do nothing without a result file
OF_RUNS = "path", "dtype", "compression", "wall_seconds", "memory_gib"
TABLE_OF_KEY = {  # the table of each key
    key: table
    for table, model in ArrayScene.model_fields.items()
    if isinstance(model.annotation, type) and issubclass(model.annotation, Table)
    for key in model.annotation.model_fields
    if key not in OF_RUNS
}


def scene_of_keywords(
    named: dict[str, Any], further: dict[str, Any], surface: PreparedSurface | None
) -> Scene:
    """Return the validated scene that the arguments of `hpc_gfmd.solve` describe.

    Parameters
    ----------
    named : dict
        Arguments in its signature; None stands for those that were not given.
    further : dict
        Further keywords that were given, even if they are None.
    surface : PreparedSurface or None
        The rough surface; None if the heights are an array.

    Returns
    -------
    Scene
        A Scene if the surface knows the table [surface] it is from, else an ArrayScene.

    Raises
    ------
    SceneError
        For an unknown keyword, a wrong value, and sizes or boundaries of a surface that has its
        own.
    """
    for key in further:
        if key in OF_RUNS:
            raise SceneError(f"{CALLER}: found {key}, allowed: in a scene, whose run writes a file")
        if key not in TABLE_OF_KEY and (why := not_modelled(key)):
            raise SceneError(f"{CALLER}: {key}: {why}, allowed: what hpc-gfmd help scene lists")
    if named.get("nu1") is not None and "nu1" in further:
        raise SceneError(f"{CALLER}: found nu and nu1, allowed: one of them")
    tables: dict[str, dict[str, Any]] = {"load": {}}
    for key, value in (named | further).items():
        if value is not None or key not in TABLE_OF_KEY:
            table = TABLE_OF_KEY.get(key) or TABLE_OF_KEY[nearest(key, TABLE_OF_KEY)]
            tables.setdefault(table, {})[key] = plain(value)
    if surface is None:
        return ArrayScene.from_dict(tables, CALLER)
    settings = tables.pop("surface", {})
    if settings:
        key = next(iter(settings))
        raise SceneError(
            f"{key}: found {settings[key]} beside a surface that knows its"
            f" {'sizes' if key == 'physical_sizes' else key}, allowed: read_surface,"
            f" prepare_surface or make_surface(..., {key}=...)"
        )
    if surface.table is not None:
        if further.get("low_memory"):
            raise SceneError(f"{CALLER}: {HEIGHTS_IN_MEMORY}")
        return Scene.from_dict(tables | {"surface": surface.table}, CALLER)
    sizes = [f"{size!r} m" if surface.unit else size for size in map(float, surface.sizes)]
    ends = ["free" if end else "periodic" for end in surface.free]
    return ArrayScene.from_dict(
        tables | {"surface": {"physical_sizes": sizes, "boundary": ends}}, CALLER
    )


def several_loads(arguments: dict[str, Any]) -> bool:
    """Whether the load among the arguments of `hpc_gfmd.solve` is a list (of any length)."""
    values = (arguments.get(key) for key in LoadTable.model_fields)
    return any(np.ndim(value) > 0 for value in values if value is not None)
