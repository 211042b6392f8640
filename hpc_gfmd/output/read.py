"""Reading result files: whole ones, and what an interrupted run left. Executes nothing, needs no MPI."""

import json
import os
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from .. import errors
from ..errors import SceneError
from ..parallel import h5_inside
from ..parallel.guard import one_line
from ..parallel.h5 import Stored
from ..parallel.h5_sum import CHECKSUM, unsealed
from . import lock

FORMAT, FORMAT_VERSION = "hpc-gfmd", 2
HEAD = "head.h5"  # of a partial folder


@dataclass(frozen=True)
class Result:
    """What a result file says.

    path: of the file, None in memory; surface: attributes of the surface; steps: one dict of attributes per load step, indices: their
    numbers;
    status: of the whole run ("running" or "interrupted" if the file was never finished);
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
    if path.exists() or not partial_folder(path).is_dir():
        return read_whole(path)
    return read_partial(path)


def read_whole(path) -> Result:
    """A finished file. Raises SceneError as read_result."""
    path = Path(path)
    with reading(path) as file:
        found = _content(file, path)
    newer = partial_folder(path) / HEAD
    notes = ()
    if newer.exists() and newer.stat().st_mtime_ns > path.stat().st_mtime_ns:
        left = len(step_files(newer.parent))
        notes = (f"a newer run was interrupted, or is running: {left} finished load steps in {newer.parent}",)
    return _result(path, *found, str(found[0].get("status", "unknown")), notes=notes)


def read_partial(path) -> Result:
    """The finished steps of a run that has not written `path` yet, status "interrupted" (or "running").

    Every file in the folder is a result file of its own, with one load step or none, so that one which is damaged says nothing about
    the others: it is left out, and named in `notes`. Raises SceneError as read_result.
    """
    path, folder = Path(path), partial_folder(path)
    if not (folder / HEAD).exists():
        raise SceneError(f"{path}: no such file, and no interrupted run beside it")
    found, steps, notes = [], {}, []
    for index, part in {None: folder / HEAD, **step_files(folder)}.items():
        try:
            with reading(part) as file:
                content = _content(file, part)
            if index is not None and list(content[2]) != [index]:
                raise SceneError(f"{part}: holds no load step {index}")
            if found and content[0].get("identity") != found[0][0].get("identity"):
                raise SceneError(f"{part}: belongs to another scene")
        except SceneError as error:
            notes.append(f"left out: {error}")
        else:
            found.append(content)
            steps |= content[2]
    if not found:
        raise SceneError(notes[0].removeprefix("left out: "))
    status = "running" if lock.is_held(folder) else "interrupted"
    return _result(path, *found[0][:2], steps, status, folder=folder, notes=tuple(notes))


def step_files(folder: Path) -> dict[int, Path]:
    """Finished steps of a partial folder by index."""
    return dict(sorted((int(p.stem[5:]), p) for p in folder.glob("step-*.h5") if p.stem[5:].isdigit()))


@contextmanager
def reading(path, kind=FORMAT):
    """`with reading(path) as file`: an h5py file of ours; whatever goes wrong inside is one SceneError."""
    import h5py

    path = Path(path)
    try:
        if path.exists() and not path.is_file():
            run = f"the folder of a run, allowed: {path.with_suffix('')}" if path.suffix == ".partial" else "no file"
            raise SceneError(f"{path}: is {'a folder, not a result file' if path.is_dir() and path.suffix != '.partial' else run}")
        with open(path, "rb"):
            pass  # says what the system says
        if not h5py.is_hdf5(path):
            raise SceneError(f"{path}: not an HDF5 file")
        with h5py.File(path, "r", locking=False) as file:
            version = file.attrs.get("format_version")
            if version not in (None, FORMAT_VERSION):
                raise SceneError(f"{path}: format_version is {errors.one_line(str(version))}, this program reads {FORMAT_VERSION}")
            if version is None or unsealed(file).get("format") != kind:
                raise SceneError(f"{path}: not a {'result' if kind == FORMAT else 'checkpoint'} of hpc-gfmd (format = {kind!r})")
            yield file
    except FileNotFoundError:
        raise SceneError(f"{path}: no such file") from None
    except PermissionError:
        raise SceneError(f"{path}: no permission to read it") from None
    except SceneError:
        raise
    except Exception as error:
        raise SceneError(f"{path}: the file is damaged ({one_line(error)})") from error


def fields_of(path, group, n) -> dict[str, Stored]:
    """The fields in a group of an open file, to be read slab by slab later. Raises ValueError if one does not fit the surface."""
    found = {}
    for name, item in h5_inside.items(group):
        if len(getattr(item, "shape", ())) == 2:
            if item.dtype.kind not in "fc" or list(item.shape) != list(n):
                raise ValueError(f"{name} holds {item.shape} of {item.dtype}, the surface has {tuple(n)} points")
            found[name] = Stored(path, item.name.lstrip("/"), item.shape, item.dtype, int(item.attrs[CHECKSUM]))
    return found


def _content(file, path) -> tuple[dict, dict, dict]:
    """Root attributes, those of the surface, and {index: (attributes, fields)} of the load steps in the order of their numbers."""
    surface, steps = h5_inside.item(file, "surface"), h5_inside.item(file, "steps")
    if surface is None:
        raise ValueError("it has no surface")
    surface, groups = unsealed(surface), {int(name): group for name, group in h5_inside.items(steps) if name.isdigit()} if steps else {}
    return unsealed(file), surface, {index: (unsealed(groups[index]), fields_of(path, groups[index], surface.get("n", ())))
                                     for index in sorted(groups)}


def _result(path, head, surface, steps, status, **more) -> Result:
    attributes, fields = zip(*steps.values(), strict=True) if steps else ((), ())
    scene, versions = str(head.get("scene", "")), json.loads(head.get("versions", "{}"))
    return Result(path, surface, list(attributes), list(steps), status, scene, versions, head, list(fields), **more)
