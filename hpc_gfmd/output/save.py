"""A result written as a file, or taken into memory, wherever its fields are."""

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..util.errors import SceneError
from .fields import Slab
from .numbers import About
from .read import Result
from .record import RunFile


def in_memory(result: Result) -> Result:
    """Copy a Result without what refers to a solver or to a file."""

    def copy(field: Any) -> Slab:
        return Slab(field.read(), getattr(field, "start", 0), field.shape)

    return replace(
        result,
        fields=[{name: copy(field) for name, field in fields.items()} for fields in result.fields],
    )


def save(
    result: Result, path: Any, force: bool, rows: tuple[int, int], comm: Any, about: About
) -> Path:
    """Write a result file as a run does; rows: of the fields, on this rank; about: as of RunFile.
    Collective. See Solutions.save."""
    path, said = Path(path), result.surface
    if path.suffix.lower() not in (".h5", ".hdf5"):
        raise SceneError(f"path: found {str(path)!r}, allowed: a path that ends in .h5 or .hdf5")

    head = {
        name: value
        for name, value in result.head.items()
        if name not in ("status", "end_time", "io")
    }
    with RunFile(
        comm, path, said["n"], rows, head, said, resume=False, force=force, about=about
    ) as file:
        for note in file.notes if comm.rank == 0 else ():
            warnings.warn(note, stacklevel=3)  # where the caller of Solution.save is
        file.take(result)
        file.finish(result.status)
    return path
