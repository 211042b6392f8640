"""Result files, what an interrupted run has left, and checkpoints; nothing in them is executed."""

import json
import os
from dataclasses import replace
from math import prod
from pathlib import Path
from typing import Any

from ..parallel.committed import committed_file, reading
from ..parallel.h5 import Stored, inside
from ..util.errors import SceneError, is_mistake, one_line, reason
from .describe import RECORD
from .folder import GROWING, has_begun, is_held, of_earlier_version, partial_folder
from .result import FORMAT_VERSION, Result

FORMAT = "hpc-gfmd"
CHECKPOINT = "hpc-gfmd checkpoint"  # the gap of a stopped load, on the solver's grid
MEMORY = "hpc-gfmd memory"  # what the loads up to one left at each point
NUMBERS = {  # that a state has at least; on_coarser_grids: CoarseContacts
    CHECKPOINT: {"p", "seconds", "iterations", "fft_pairs", "on_coarser_grids"},
    MEMORY: set(),
}


def read_result(path: str | os.PathLike) -> Result:
    """Read a result file, else the finished loads of an interrupted run beside it; fields are read
    later. A note says if a newer run is unfinished.
    """
    path = Path(path)
    folder = partial_folder(path)
    if not path.exists() and folder.is_dir():
        return read_partial(path)
    result = read_file(path)
    newer = folder / GROWING
    if has_begun(folder) and newer.stat().st_mtime_ns > path.stat().st_mtime_ns:
        finished = len(read_file(newer).steps)
        note = (
            f"a newer run was interrupted, or is running: {finished} finished load steps in"
            f" {folder}"
        )
        return replace(result, notes=(*result.notes, note))
    return result


def read_partial(path: str | os.PathLike) -> Result:
    """Read the finished loads of a run without a result, "running" (locked) or "interrupted"."""
    path = Path(path)
    folder = partial_folder(path)
    if of_earlier_version(folder):
        raise SceneError(f"{folder}: an interrupted run of another version, allowed: of this one")
    if not has_begun(folder):
        if is_held(folder):
            raise SceneError(f"{path}: another run is writing this file; no load is finished yet")
        raise SceneError(f"{path}: no such file, and no interrupted run beside it")
    status = "running" if is_held(folder) else "interrupted"
    result = read_file(folder / GROWING)
    return replace(result, path=path, folder=folder, status=status)


def read_state(path: Path, kind: str, identity: str) -> Result | None:
    """Read a state of STATES, one step, that a run of this identity has left; None without it."""
    if not path.exists():
        return None
    state = read_file(path, kind)
    name = kind.split()[1]
    if state.head.get("identity") != identity:
        raise SceneError(f"{path}: a {name} of another scene, allowed: of this one")
    if len(state.steps) != 1 or not NUMBERS[kind] <= state.steps[0].keys():
        raise SceneError(f"{path}: a {name} of another version of hpc_gfmd, allowed: of this")
    return state


def read_file(path: Path, kind: str = FORMAT) -> Result:
    """Read one file of the format `kind`, but for the values of its fields, which are `Stored`."""
    _require_hdf5(path)
    try:
        with reading(path) as file:
            version = file.attrs.get("format_version")
            if version not in (None, FORMAT_VERSION):
                raise SceneError(
                    f"{path}: format_version is {one_line(str(version))}, this program reads"
                    f" {FORMAT_VERSION}"
                )
            head = _attributes(file) if version is not None else {}
            if head.get("format") != kind:
                raise SceneError(
                    f"{path}: not a {'result' if kind == FORMAT else kind.split()[1]} of hpc-gfmd"
                    f" (format = {kind!r})"
                )
            surface = _attributes(inside(file, "surface"))
            group = inside(file, "steps") if "steps" in file else ()
            steps = {
                int(name): inside(group, name)
                for name in sorted(filter(str.isdigit, group), key=int)
            }
            fields = [_fields(path, step, surface.get("n", [])) for step in steps.values()]
            return Result(
                path,
                surface,
                [_attributes(step) for step in steps.values()],
                list(steps),
                str(head.get("status", "unknown")),
                head,
                fields,
                notes=tuple(surface.get("notes", [])),
            )
    except SceneError:
        raise
    except Exception as error:
        if is_mistake(error):
            raise
        raise SceneError(f"{path}: the file is damaged ({reason(error)})") from error


def _require_hdf5(path: Path) -> None:
    """Raise SceneError unless `path` is an HDF5 file that may be read."""
    import h5py

    if not path.exists():
        unfit = "no such file"
    elif path.is_dir() and path.suffix == ".partial":
        unfit = f"is the folder of a run, allowed: {path.with_suffix('')}"
    elif path.is_dir():
        unfit = "is a folder, not a result file"
    elif not path.is_file():
        unfit = "is no file"
    elif not os.access(path, os.R_OK):
        unfit = "no permission to read it"
    elif path.stat().st_size == 0:
        unfit = "found an empty file, allowed: a result file"
    elif not committed_file(path).exists() and not h5py.is_hdf5(path):
        unfit = "not an HDF5 file, allowed: a result file"
    else:
        return
    raise SceneError(f"{path}: {unfit}")


def _fields(path: Path, group: Any, n: list[int]) -> dict[str, Stored]:
    """Return {name: Stored} of datasets with two axes; ValueError for other points or no floats."""
    fields = {}
    for name in group:
        data = inside(group, name)
        if len(getattr(data, "shape", ())) == 2:
            if data.dtype.kind not in "fc" or list(data.shape) != list(n):
                raise ValueError(
                    f"{name} holds {data.shape} of {data.dtype}, the surface has {tuple(n)} points"
                )
            stored_bytes = data.id.get_storage_size()
            if data.chunks:  # packed
                stored_bytes = data.id.get_num_chunks() * prod(data.chunks) * data.dtype.itemsize
            if stored_bytes < data.nbytes:
                raise ValueError(f"{name} has no numbers at some points")
            fields[name] = Stored(path, data.name.lstrip("/"), data.shape, data.dtype)
    return fields


def _attributes(group: Any) -> dict:
    """Return a group's attributes in the order of writing; texts, but the scene, in one line."""
    texts = json.loads(group.attrs[RECORD])
    return {
        name: group.attrs[name].tolist()
        if text is None
        else text
        if name == "scene"
        else _printable(text)
        for name, text in texts.items()
    }


def _printable(text: Any) -> Any:
    """Return a text, or a list of texts, on one line each and without control characters."""
    if isinstance(text, str):
        return one_line(text, len(text) + 1)
    return [_printable(item) for item in text]
