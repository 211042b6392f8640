"""Reading result files, what an interrupted run left, and checkpoints. Executes nothing, needs no
MPI."""

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import prod
from pathlib import Path
from typing import Any

from ..parallel.h5 import CHECKSUM, Stored, inside, reading
from ..scene import ArrayScene, Scene
from ..scene.model import parse_toml
from ..util.errors import SceneError, one_line, reason
from ..util.quantities import format_quantity
from .describe import RECORD
from .fields import Slab
from .folder import HEAD, is_held, partial_folder, step_files
from .numbers import names_of

FORMAT, CHECKPOINT, FORMAT_VERSION = "hpc-gfmd", "hpc-gfmd checkpoint", 3
# (table, key) that scenes in older files may have, and that changed no result
WITHDRAWN = (("machine", "checkpoint_seconds"),)


@dataclass(frozen=True)
class Result:
    """What a result file says.

    path: of the file, None in memory; head, surface, steps: attributes of the root, the surface and
    each load step; indices: numbers of the steps; status: of the whole run ("running" or
    "interrupted" if it was never finished); fields: per step {name: Stored}, or Slab in memory;
    folder: of the unfinished run, otherwise None; notes: what else a reader should know, one line
    each; version: of what is said here, which a pickle keeps.
    """

    path: Path | None
    surface: dict
    steps: list[dict]
    indices: list[int]
    status: str
    head: dict
    fields: list[dict[str, Any]] = field(repr=False)
    folder: Path | None = None
    notes: tuple[str, ...] = ()
    version: int = field(default=FORMAT_VERSION, repr=False)

    def __setstate__(self, state: dict[str, Any]) -> None:
        if state.get("version") != FORMAT_VERSION:
            raise SceneError("a pickle of another version of hpc_gfmd, allowed: of this one")
        vars(self).update(state)

    @property
    def scene_toml(self) -> str:
        """The scene that was solved."""
        return str(self.head.get("scene", ""))

    @property
    def scene(self) -> Scene:
        """The same; where heights were an array, with the sizes and the boundary alone as its
        surface."""
        table = parse_toml(self.scene_toml, str(self.path))
        for name, key in WITHDRAWN:
            if isinstance(table.get(name), dict):
                table[name].pop(key, None)
        return (Scene if "kind" in table.get("surface", {}) else ArrayScene).from_dict(
            table, str(self.path)
        )

    @property
    def remarks(self) -> list[str]:
        """What to say beside what was made of it, a line each."""
        unfinished = f"! the run is {self.status}: only its finished load steps are there"
        return [f"note: {note}" for note in self.notes] + [unfinished] * (self.folder is not None)

    @property
    def numbered(self) -> dict[int, dict]:
        """The attributes of the load steps, by their numbers."""
        return dict(zip(self.indices, self.steps, strict=True))

    @property
    def groups(self) -> dict[str, dict]:
        """The attributes of the load steps, by their groups in a file."""
        return {group_of(index): step for index, step in self.numbered.items()}

    def places(self, numbers: Sequence[int]) -> list[int]:
        """Return where load steps of these numbers are in `steps`. Raises SceneError for those that
        are not there."""
        for number in numbers:
            if number not in self.indices:
                allowed = ", ".join(map(str, self.indices)) or "none"
                raise SceneError(f"step: found {number}, allowed: {allowed}")
        return [self.indices.index(number) for number in numbers]

    @property
    def datasets(self) -> dict[str, Any]:
        """The fields by their places in a file, heights once: Stored, or the slab in memory."""
        places = {"heights": "surface"}
        return {
            f"{places.get(name, group)}/{name}": one.data if isinstance(one, Slab) else one
            for group, fields in zip(self.groups, self.fields)
            for name, one in fields.items()
        }

    @property
    def facts(self) -> dict[str, Any]:
        """What the head says in one number or text."""
        return {name: self.head[name] for name in names_of([self.head])}

    def some(self, steps: slice | list[int], **other: Any) -> "Result":
        """Keep some load steps alone, by their places; other: what is said otherwise."""
        at = range(len(self.steps))[steps] if isinstance(steps, slice) else steps
        names = "steps", "indices", "fields"
        picked: dict[str, Any] = {name: [getattr(self, name)[k] for k in at] for name in names}
        return replace(self, **picked, **other)

    def only(
        self, indices: Sequence[int] | None = None, fields: Sequence[str] | None = None
    ) -> "Result":
        """Keep the steps of these numbers and these fields alone (None: all). Raises SceneError for
        those that are not there."""
        some = self if indices is None else self.some(self.places(indices))
        if fields is None:
            return some
        there = sorted({name for each in self.fields for name in each})
        for name in fields:
            if name not in there:
                raise SceneError(f"fields: found {name}, allowed: {', '.join(there) or 'none'}")
        kept = [{name: each[name] for name in each if name in fields} for each in some.fields]
        return replace(some, fields=kept)

    @property
    def missing_loads(self) -> str:
        """Which of the loads that its scene asks for are not there, as a text."""
        key, loads = self.scene.load.given
        left = [
            f"{k + 1} ({key} = {format_quantity(load)})"
            for k, load in enumerate(loads)
            if k not in self.indices
        ]
        return (
            f"loads {', '.join(left)} of {len(loads)} are not there"
            if left
            else "all loads are there"
        )


def group_of(index: int) -> str:
    """Return the group of a load step in a file."""
    return f"steps/{index:04d}"


def read_result(path: str | os.PathLike) -> Result:
    """Read a result file, or, if there is none, what an interrupted run left beside it. Raises
    SceneError (one line) if there is nothing, or the file is no HDF5, damaged, foreign or of
    another version."""
    path, folder = Path(path), partial_folder(path)
    if not path.exists() and folder.is_dir():
        return read_partial(path)
    result, newer = _read(path), folder / HEAD
    if newer.exists() and newer.stat().st_mtime_ns > path.stat().st_mtime_ns:
        note = (
            f"a newer run was interrupted, or is running: {len(step_files(folder))} finished load"
            f" steps in {folder}"
        )
        return replace(result, notes=(note,))
    return result


def read_partial(path: str | os.PathLike) -> Result:
    """Read the finished steps of a run that has not written `path` yet, status "interrupted" (or
    "running").

    Every file in the folder is a result file of its own, with one load step or none, so that one
    which is damaged says nothing about the others: it is left out, and named in `notes`. Raises
    SceneError as read_result.
    """
    path, folder = Path(path), partial_folder(path)
    if not (folder / HEAD).exists():
        raise SceneError(f"{path}: no such file, and no interrupted run beside it")
    parts: list[Result] = []
    notes = []
    for index, file in [(None, folder / HEAD), *step_files(folder).items()]:
        try:
            part = _read(file)
            if index is not None and part.indices != [index]:
                raise SceneError(f"{file}: holds no load step {index}")
            if parts and part.head.get("identity") != parts[0].head.get("identity"):
                raise SceneError(f"{file}: belongs to another scene")
            parts.append(part)
        except SceneError as error:
            notes.append(f"left out: {error}")
    if not parts:
        raise SceneError(notes[0].removeprefix("left out: "))
    steps, indices, fields = (
        [one for part in parts for one in getattr(part, name)]
        for name in ("steps", "indices", "fields")
    )
    return replace(
        parts[0],
        path=path,
        steps=steps,
        indices=indices,
        fields=fields,
        folder=folder,
        notes=tuple(notes),
        status="running" if is_held(folder) else "interrupted",
    )


def read_checkpoint(path: Path, identity: str) -> Result | None:
    """Read the gap of a load that was stopped, a file of the same layout with one load step.

    Parameters
    ----------
    path : Path
        The file.
    identity : str
        Of the scene that it has to belong to.

    Returns
    -------
    Result or None
        With one step and its field "gap"; None if there is no such file.

    Raises
    ------
    SceneError
        As `read_result`, and for what another scene or another version of the program wrote.
    """
    if not path.exists():
        return None
    checkpoint = _read(path, CHECKPOINT)
    if checkpoint.head.get("identity") != identity:
        raise SceneError(f"{path}: a checkpoint of another scene, allowed: of this one")
    known = [{"p", "seconds", "iterations", "fft_pairs"} <= {*step} for step in checkpoint.steps]
    if known != [True] or "gap" not in checkpoint.fields[0]:
        raise SceneError(f"{path}: a checkpoint of another version of hpc_gfmd, allowed: of this")
    return checkpoint


def _read(path: Path, kind: str = FORMAT) -> Result:
    """Read all that one file says, its load steps in the order of their numbers; whatever goes
    wrong is one SceneError."""
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
                    f"{path}: not a {'result' if kind == FORMAT else 'checkpoint'} of hpc-gfmd"
                    f" (format = {kind!r})"
                )
            surface, group = (
                _attributes(inside(file, "surface")),
                inside(file, "steps") if "steps" in file else (),
            )
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
            )
    except SceneError:
        raise
    except Exception as error:
        raise SceneError(f"{path}: the file is damaged ({reason(error)})") from error


def _require_hdf5(path: Path) -> None:
    """Raise SceneError for what is no HDF5 file that may be read."""
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
    elif not h5py.is_hdf5(path):
        unfit = "not an HDF5 file"
    else:
        return
    raise SceneError(f"{path}: {unfit}")


def _fields(path: Path, group: Any, n: list[int]) -> dict[str, Stored]:
    """Find the fields in a group of an open file, to be read slab by slab later. Raises ValueError
    if one does not fit the surface."""
    found = {}
    for name in group:
        data = inside(group, name)
        if len(getattr(data, "shape", ())) == 2:
            if data.dtype.kind not in "fc" or list(data.shape) != list(n):
                raise ValueError(
                    f"{name} holds {data.shape} of {data.dtype}, the surface has {tuple(n)} points"
                )
            there = data.id.get_storage_size()
            if data.chunks:  # packed
                there = data.id.get_num_chunks() * prod(data.chunks) * data.dtype.itemsize
            if there < data.nbytes:
                raise ValueError(f"{name} has no numbers at some points")
            found[name] = Stored(
                path, data.name.lstrip("/"), data.shape, data.dtype, int(data.attrs[CHECKSUM])
            )
    return found


def _attributes(group: Any) -> dict:
    """Return attributes as Python numbers, texts and lists, in the order in which they were
    written."""
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
    """Put a text, or each of a list of them, in one line: a terminal would obey control
    characters."""
    return (
        one_line(text, len(text) + 1)
        if isinstance(text, str)
        else [_printable(one) for one in text]
    )
