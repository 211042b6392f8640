"""What is done with what a result says, in memory or in a file: its fields read, all of it saved, drawn, copied."""

import tomllib
import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import SceneError
from .fields import Slab
from .output.read import Result
from .output.record import RunFile
from .scene import ArrayScene, Scene
from .scene.model import parse_toml

if TYPE_CHECKING:
    from .plotting.style import Figure


def whole(field: Any) -> np.ndarray:
    """All rows of a parallel.h5.Stored field, or those of this rank of a fields.Slab. Raises GfmdError where the file is damaged."""
    return field.read()


def in_memory(result: Result) -> Result:
    """The Result without what refers to a solver or to a file."""
    def copy(field: Any) -> Slab:
        return Slab(whole(field), getattr(field, "start", 0), field.shape)

    return replace(result, fields=[{name: copy(field) for name, field in fields.items()} for fields in result.fields])


def scene_of(result: Result) -> Scene:
    """The scene of a Result; of one whose heights were an array, with the sizes and the boundary alone as its surface."""
    table = parse_toml(result.scene_toml, str(result.path))
    return (Scene if "kind" in table.get("surface", {}) else ArrayScene).from_dict(table, str(result.path))


def missing_loads(result: Result) -> str:
    """Which of the loads that its scene asks for a Result does not have."""
    key, loads = next((key, value) for key, value in tomllib.loads(result.scene_toml)["load"].items() if isinstance(value, list))
    left = [f"{k + 1} ({key} = {value})" for k, value in enumerate(loads) if k not in result.indices]
    return f"loads {', '.join(left)} of {len(loads)} are not there" if left else "all loads are there"


def draw(result: Result, comm: Any, what: str | None, how: dict[str, Any]) -> "Figure":
    """A figure by plotting.plot. Raises SceneError where fields are spread over ranks."""
    from .plotting import plot

    if comm.size > 1:
        raise SceneError(f"plot: found fields that are spread over {comm.size} ranks, allowed: save, and plot the file")
    return plot(result, what, **how)


def save(result: Result, path: Any, force: bool, rows: tuple[int, int], comm: Any) -> Path:
    """Write a result file as a run does; rows: of the fields, on this rank. Collective. See Solutions.save."""
    path, said = Path(path), result.surface
    if path.suffix.lower() not in (".h5", ".hdf5"):
        raise SceneError(f"path: found {str(path)!r}, allowed: a path that ends in .h5 or .hdf5")

    def slab(field: Any) -> Any:
        return field.data if isinstance(field, Slab) else field

    head = {name: value for name, value in result.head.items() if name not in ("status", "end_time", "io")}
    with RunFile(comm, path, said["n"], rows, head, said, force=force) as file:
        for note in file.notes if comm.rank == 0 else ():
            warnings.warn(note, stacklevel=3)  # where the caller of Solution.save is
        heights = next((fields["heights"] for fields in result.fields if "heights" in fields), None)
        if heights is not None:
            file.update(height_field=slab(heights))
        for index, (step, fields) in enumerate(zip(result.steps, result.fields, strict=True)):
            file.write_step(index, step, {name: slab(field) for name, field in fields.items() if name != "heights"})
        file.finish(result.status)
    return path
