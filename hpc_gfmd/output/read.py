"""Reading result files: whole ones, and what an interrupted run left. Executes nothing, needs no MPI."""

import json
import os
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from .. import errors
from ..errors import SceneError
from ..parallel.guard import one_line
from ..parallel.h5 import CHECKSUM, Stored, inside
from . import lock
from .attributes import attributes_of

FORMAT, FORMAT_VERSION = "hpc-gfmd", 3
HEAD = "head.h5"  # of a partial folder


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
    scene_toml: str
    versions: dict
    head: dict
    fields: list[dict[str, Stored]] = field(repr=False)
    folder: Path | None = None
    notes: tuple[str, ...] = ()


def followed(path) -> Path:
    """The file that a path stands for: a link is not replaced by a result, what it names is."""
    return Path(os.path.realpath(path)) if os.path.islink(path) else Path(path)


def partial_folder(path) -> Path:
    """Where a run that writes `path` keeps its finished steps and checkpoints."""
    path = followed(path)
    return path.with_name(path.name + ".partial")


def read_result(path) -> Result:
    """The result file, or, if there is none, what an interrupted run left beside it.

    Raises SceneError (one line) if there is nothing, or the file is no HDF5, damaged, foreign or of another version.
    """
    path = Path(path)
    return read_whole(path) if path.exists() or not partial_folder(path).is_dir() else read_partial(path)


def read_whole(path) -> Result:
    """A finished file. Raises SceneError as read_result."""
    path = Path(path)
    head, surface, steps = _content(path)
    newer, notes = partial_folder(path) / HEAD, ()
    if newer.exists() and newer.stat().st_mtime_ns > path.stat().st_mtime_ns:
        left = len(step_files(newer.parent))
        notes = (f"a newer run was interrupted, or is running: {left} finished load steps in {newer.parent}",)
    return _result(path, head, surface, steps, str(head.get("status", "unknown")), None, notes)


def read_partial(path) -> Result:
    """The finished steps of a run that has not written `path` yet, status "interrupted" (or "running").

    Every file in the folder is a result file of its own, with one load step or none, so that one which is damaged says nothing about
    the others: it is left out, and named in `notes`. Raises SceneError as read_result.
    """
    path, folder = Path(path), partial_folder(path)
    if not (folder / HEAD).exists():
        raise SceneError(f"{path}: no such file, and no interrupted run beside it")
    first, steps, notes = None, {}, []
    for index, part in {None: folder / HEAD, **step_files(folder)}.items():
        try:
            head, surface, found = _content(part)
            if index is not None and list(found) != [index]:
                raise SceneError(f"{part}: holds no load step {index}")
            first = first or (head, surface)
            if head.get("identity") != first[0].get("identity"):
                raise SceneError(f"{part}: belongs to another scene")
            steps |= found
        except SceneError as error:
            notes.append(f"left out: {error}")
    if first is None:
        raise SceneError(notes[0].removeprefix("left out: "))
    return _result(path, *first, steps, "running" if lock.is_held(folder) else "interrupted", folder, tuple(notes))


def step_files(folder: Path) -> dict[int, Path]:
    """Finished steps of a partial folder by index."""
    return dict(sorted((int(p.stem[5:]), p) for p in folder.glob("step-*.h5") if p.stem[5:].isdigit()))


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


def _content(path) -> tuple[dict, dict, dict]:
    """Root attributes, those of the surface, and {index: (attributes, fields)} of the load steps in the order of their numbers."""
    with reading(path) as file:
        surface, steps = attributes_of(inside(file, "surface")), inside(file, "steps") if "steps" in file else ()
        groups = {int(name): inside(steps, name) for name in steps if name.isdigit()}
        return attributes_of(file), surface, {index: (attributes_of(group), fields_of(path, group, surface.get("n", ())))
                                              for index, group in sorted(groups.items())}


def _result(path, head, surface, steps, status, folder, notes) -> Result:
    attributes, fields = zip(*steps.values(), strict=True) if steps else ((), ())
    scene, versions = str(head.get("scene", "")), json.loads(head.get("versions", "{}"))
    return Result(path, surface, list(attributes), list(steps), status, scene, versions, head, list(fields), folder, notes)
