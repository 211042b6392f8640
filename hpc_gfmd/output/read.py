"""Reading result files: whole ones, and what an interrupted run left. Executes nothing, needs no MPI."""

import os
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from .. import errors
from ..errors import SceneError
from ..parallel.guard import one_line
from ..parallel.h5 import CHECKSUM, Stored, inside
from .attributes import attributes_of
from .folder import HEAD, is_held, partial_folder, step_files

FORMAT, FORMAT_VERSION = "hpc-gfmd", 3


@dataclass(frozen=True)
class Result:
    """What a result file says.

    path: of the file, None in memory; surface: attributes of the surface; steps: one dict of attributes per load step, indices: their
    numbers; status: of the whole run ("running" or "interrupted" if the file was never finished);
    head: all root attributes; fields: per step {name: Stored}, to be read slab by slab;
    folder: of the unfinished run, otherwise None; notes: what else a reader should know, one line each.
    """

    path: Path | None
    surface: dict
    steps: list[dict]
    indices: list[int]
    status: str
    head: dict
    fields: list[dict[str, Stored]] = field(repr=False)
    folder: Path | None = None
    notes: tuple[str, ...] = ()

    @property
    def scene_toml(self) -> str:
        """The scene that was solved."""
        return str(self.head.get("scene", ""))


def read_result(path) -> Result:
    """The result file, or, if there is none, what an interrupted run left beside it.

    Raises SceneError (one line) if there is nothing, or the file is no HDF5, damaged, foreign or of another version.
    """
    path = Path(path)
    return read_whole(path) if path.exists() or not partial_folder(path).is_dir() else read_partial(path)


def read_whole(path) -> Result:
    """A finished file. Raises SceneError as read_result."""
    result = _read(Path(path))
    newer = partial_folder(path) / HEAD
    if newer.exists() and newer.stat().st_mtime_ns > result.path.stat().st_mtime_ns:
        left = len(step_files(newer.parent))
        note = f"a newer run was interrupted, or is running: {left} finished load steps in {newer.parent}"
        return replace(result, notes=(note,))
    return result


def read_partial(path) -> Result:
    """The finished steps of a run that has not written `path` yet, status "interrupted" (or "running").

    Every file in the folder is a result file of its own, with one load step or none, so that one which is damaged says nothing about
    the others: it is left out, and named in `notes`. Raises SceneError as read_result.
    """
    path, folder = Path(path), partial_folder(path)
    if not (folder / HEAD).exists():
        raise SceneError(f"{path}: no such file, and no interrupted run beside it")
    parts, notes = {}, []
    for index, file in {None: folder / HEAD, **step_files(folder)}.items():
        try:
            part = _read(file)
            if index is not None and part.indices != [index]:
                raise SceneError(f"{file}: holds no load step {index}")
            if any(part.head.get("identity") != other.head.get("identity") for other in parts.values()):
                raise SceneError(f"{file}: belongs to another scene")
            parts[index] = part
        except SceneError as error:
            notes.append(f"left out: {error}")
    if not parts:
        raise SceneError(notes[0].removeprefix("left out: "))
    first = next(iter(parts.values()))
    parts.pop(None, None)
    return Result(path, first.surface, [part.steps[0] for part in parts.values()], list(parts),
                  "running" if is_held(folder) else "interrupted", first.head, [part.fields[0] for part in parts.values()],
                  folder, tuple(notes))


@contextmanager
def reading(path, kind=FORMAT):
    """`with reading(path) as file`: an h5py file of ours; whatever goes wrong inside is one SceneError."""
    import h5py

    path = Path(path)
    unfit = ("no such file" if not path.exists() else
             f"is the folder of a run, allowed: {path.with_suffix('')}" if path.is_dir() and path.suffix == ".partial" else
             "is a folder, not a result file" if path.is_dir() else
             "is no file" if not path.is_file() else
             "no permission to read it" if not os.access(path, os.R_OK) else
             "not an HDF5 file" if not h5py.is_hdf5(path) else None)
    if unfit is not None:
        raise SceneError(f"{path}: {unfit}")
    try:
        with h5py.File(path, "r", locking=False) as file:
            version = file.attrs.get("format_version")
            if version not in (None, FORMAT_VERSION):
                raise SceneError(f"{path}: format_version is {errors.one_line(str(version))}, this program reads {FORMAT_VERSION}")
            if version is None or attributes_of(file).get("format") != kind:
                raise SceneError(f"{path}: not a {'result' if kind == FORMAT else 'checkpoint'} of hpc-gfmd (format = {kind!r})")
            yield file
    except SceneError:
        raise
    except Exception as error:
        raise SceneError(f"{path}: the file is damaged ({one_line(error)})") from error


def fields_of(path, group, n) -> dict[str, Stored]:
    """The fields in a group of an open file, to be read slab by slab later. Raises ValueError if one does not fit the surface."""
    found = {}
    for name in group:
        data = inside(group, name)
        if len(getattr(data, "shape", ())) == 2:
            if data.dtype.kind not in "fc" or list(data.shape) != list(n):
                raise ValueError(f"{name} holds {data.shape} of {data.dtype}, the surface has {tuple(n)} points")
            found[name] = Stored(path, data.name.lstrip("/"), data.shape, data.dtype, int(data.attrs[CHECKSUM]))
    return found


def _read(path) -> Result:
    """All that one file says, its load steps in the order of their numbers."""
    with reading(path) as file:
        head, surface = attributes_of(file), attributes_of(inside(file, "surface"))
        found = inside(file, "steps") if "steps" in file else ()
        steps = [inside(found, name) for name in sorted(filter(str.isdigit, found), key=int)]
        indices, n = [int(step.name.rpartition("/")[2]) for step in steps], surface.get("n", ())
        return Result(path, surface, [attributes_of(step) for step in steps], indices, str(head.get("status", "unknown")), head,
                      [fields_of(path, step, n) for step in steps])
