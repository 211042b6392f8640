"""The scene that the keywords of a Python call describe; each goes to the table of its key."""

from typing import Any, NoReturn

import numpy as np

from ..scene import ArrayScene, File, Scene
from ..scene.explain import nearest
from ..scene.model import HEIGHTS_IN_MEMORY
from ..scene.not_modelled import not_modelled
from ..scene.read import ALTERNATIVES
from ..scene.settings import LOADS
from ..scene.surface import KINDS
from ..scene.table import Table
from ..util.errors import SceneError
from .prepared import PreparedSurface
from .surfaces import plain

CALLER = "hpc_gfmd.solve"
FIELDS = "pressure", "gap", "heights"  # that are kept unless others are asked for
# keys that do nothing without a result file
OF_RUNS = "path", "dtype", "compression", "wall_seconds", "memory_gib"
TABLE_OF_KEY = {  # the table of each key
    key: table
    for table, model in ArrayScene.model_fields.items()
    if isinstance(model.annotation, type) and issubclass(model.annotation, Table)
    for key in model.annotation.model_fields
    if key not in OF_RUNS
}


def changed_scene(scene: Scene, arguments: dict[str, Any]) -> Scene:
    """Return a scene with the keywords of `hpc_gfmd.solve` beside it; see `scene_of_keywords`."""
    if arguments.get("fields") is None and not scene.output.fields:
        arguments = arguments | {"fields": FIELDS}
    tables = scene.model_dump(exclude_none=True)
    for name, keys in _tables(arguments).items():
        alternatives = ALTERNATIVES.get(name, ())
        replaced = () if keys.keys().isdisjoint(alternatives) else alternatives
        kept = {key: value for key, value in tables.get(name, {}).items() if key not in replaced}
        tables[name] = kept | keys
    return type(scene).from_dict(tables, CALLER)


def _tables(arguments: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return keywords that are not None, sorted into the tables of a scene; `nu` is nu1 there.

    Raises SceneError for those that belong elsewhere, or that are given twice.
    """
    tables: dict[str, dict[str, Any]] = {}
    for name, value in arguments.items():
        key = "nu1" if name == "nu" else name
        if key not in TABLE_OF_KEY:
            _refuse(key)
        if value is not None:
            tables.setdefault(TABLE_OF_KEY[key], {})[key] = plain(value)
    if arguments.get("nu") is not None and "nu1" in arguments:
        raise SceneError(f"{CALLER}: found nu and nu1, allowed: one of them")
    return tables


def _refuse(key: str) -> NoReturn:
    """Raise SceneError for a keyword that is no key, with a similar one that `solve` takes."""
    if key in OF_RUNS:
        raise SceneError(f"{CALLER}: found {key}, allowed: in a scene, whose run writes a file")
    if why := not_modelled(key):
        raise SceneError(f"{CALLER}: {key}: {why}, allowed: what hpc-gfmd help scene lists")
    if key in File.model_fields:
        raise SceneError(
            f"{CALLER}: found {key}, allowed: in hpc_gfmd.prepare_surface(heights, {key}=...),"
            " whose result solve takes"
        )
    if any(key in kind.model_fields for kind in KINDS.values()):
        raise SceneError(f"{CALLER}: found {key}, allowed: in hpc_gfmd.make_surface")
    similar = nearest(key, TABLE_OF_KEY)
    if not similar:
        raise SceneError(f"{CALLER}: {key}: unknown key, allowed: what hpc-gfmd help scene lists")
    table = TABLE_OF_KEY[similar]
    allowed = ", ".join(name for name in TABLE_OF_KEY if TABLE_OF_KEY[name] == table)
    raise SceneError(
        f"{CALLER}: {table}.{key}: unknown key, nearest: {table}.{similar}, allowed: {allowed}"
    )


def scene_of_keywords(arguments: dict[str, Any], surface: PreparedSurface | None) -> Scene:
    """Return the validated scene for arguments of `hpc_gfmd.solve` (None: not given): an ArrayScene
    unless the surface knows its table [surface].
    """
    if arguments.get("fields") is None:
        arguments = arguments | {"fields": FIELDS}
    tables: dict[str, dict[str, Any]] = {"load": {}} | _tables(arguments)
    if surface is None:
        return ArrayScene.from_dict(tables, CALLER)
    settings = tables.pop("surface", {})
    if settings:
        key = next(iter(settings))
        raise SceneError(
            f"{key}: found {settings[key]} beside a surface that is complete, allowed:"
            f" read_surface, prepare_surface or make_surface(..., {key}=...)"
        )
    if surface.table is not None:
        if arguments.get("low_memory"):
            raise SceneError(f"{CALLER}: {HEIGHTS_IN_MEMORY}")
        return Scene.from_dict(tables | {"surface": surface.table}, CALLER)
    sizes = [f"{size!r} m" if surface.unit else size for size in map(float, surface.sizes)]
    ends = ["free" if end else "periodic" for end in surface.free]
    return ArrayScene.from_dict(
        tables | {"surface": {"physical_sizes": sizes, "boundary": ends}}, CALLER
    )


def several_loads(arguments: dict[str, Any]) -> bool | None:
    """Whether the loads (or times) among the arguments of `solve` are a list; None without any."""
    values = [arguments.get(key) for key in (*LOADS, "time")]
    are_lists = [_is_list(value) for value in values if value is not None]
    return any(are_lists) if are_lists else None


def _is_list(value: Any) -> bool:
    try:
        return np.ndim(value) > 0
    except ValueError:  # a list of unequal lists, which the scene refuses
        return True
