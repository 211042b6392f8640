"""Reading result files, what an interrupted run left, and checkpoints. Executes nothing, needs no
MPI."""

import json
import os
from collections.abc import Mapping, Sequence
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

FORMAT = "hpc-gfmd"
CHECKPOINT = "hpc-gfmd checkpoint"
FORMAT_VERSION = 3
# (table, key) that scenes in older files may have, and that changed no result
WITHDRAWN = (("machine", "checkpoint_seconds"),)


@dataclass(frozen=True)
class Result:
    """The content of a result file, or of a solution in memory.

    Attributes
    ----------
    path : Path or None
        Of the file; None in memory.
    surface : dict
        Attributes of the surface.
    steps : list of dict
        Attributes of each load step.
    indices : list of int
        Numbers of the load steps.
    status : str
        Of the whole run; "running" or "interrupted" if it is not finished.
    head : dict
        Attributes of the root.
    fields : list of dict
        Fields of each load step by name: Stored in a file, Slab in memory.
    folder : Path or None
        Of a run that is not finished.
    notes : tuple of str
        What a reader should know, a line each.
    version : int
        Format version, which a pickle keeps.
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
            f"{places.get(name, group)}/{name}": field.data if isinstance(field, Slab) else field
            for group, fields in zip(self.groups, self.fields, strict=True)
            for name, field in fields.items()
        }

    @property
    def facts(self) -> dict[str, Any]:
        """What the head says in one number or text."""
        return {name: self.head[name] for name in names_of([self.head])}

    def some(self, steps: slice | list[int], **changes: Any) -> "Result":
        """Return a result with some of the load steps.

        Parameters
        ----------
        steps : slice or list of int
            Their places in `steps`.
        **changes
            Attributes to replace.

        Returns
        -------
        Result
            A copy; this one stays as it is.
        """
        places = range(len(self.steps))[steps] if isinstance(steps, slice) else steps
        names = "steps", "indices", "fields"
        picked: dict[str, Any] = {name: [getattr(self, name)[k] for k in places] for name in names}
        return replace(self, **picked, **changes)

    def only(
        self, indices: Sequence[int] | None = None, fields: Sequence[str] | None = None
    ) -> "Result":
        """Return a result with some of the load steps and fields.

        Parameters
        ----------
        indices : sequence of int, optional
            Numbers of the load steps; default: all.
        fields : sequence of str, optional
            Names of the fields; default: all.

        Returns
        -------
        Result
            A copy; this one stays as it is.

        Raises
        ------
        SceneError
            For those that the result does not have.
        """
        chosen = self if indices is None else self.some(self.places(indices))
        if fields is None:
            return chosen
        present = sorted({name for of_step in self.fields for name in of_step})
        for name in fields:
            if name not in present:
                raise SceneError(f"fields: found {name}, allowed: {', '.join(present) or 'none'}")
        kept = [
            {name: of_step[name] for name in of_step if name in fields} for of_step in chosen.fields
        ]
        return replace(chosen, fields=kept)

    @property
    def missing_loads(self) -> str:
        """Which of the loads that its scene asks for are not there, as a text."""
        key, loads = self.scene.load.given
        missing = [
            f"{k + 1} ({key} = {format_quantity(load)})"
            for k, load in enumerate(loads)
            if k not in self.indices
        ]
        if not missing:
            return "all loads are finished"
        return f"loads {', '.join(missing)} of {len(loads)} are missing"


def group_of(index: int) -> str:
    """Return the group of a load step in a file."""
    return f"steps/{index:04d}"


def read_result(path: str | os.PathLike) -> Result:
    """Read a result file, or, if there is none, what an interrupted run left beside it. Raises
    SceneError (one line) if there is nothing, or the file is no HDF5, damaged, foreign or of
    another version."""
    path = Path(path)
    folder = partial_folder(path)
    if not path.exists() and folder.is_dir():
        return read_partial(path)
    result = read_file(path)
    newer = folder / HEAD
    if newer.exists() and newer.stat().st_mtime_ns > path.stat().st_mtime_ns:
        note = (
            f"a newer run was interrupted, or is running: {len(step_files(folder))} finished load"
            f" steps in {folder}"
        )
        return replace(result, notes=(note,))
    return result


def read_partial(path: str | os.PathLike) -> Result:
    """Read the finished loads of a run that has not written `path` yet.

    Its status is "interrupted", or "running". Raises SceneError as `read_result`.
    """
    path = Path(path)
    folder = partial_folder(path)
    if not (folder / HEAD).exists():
        raise SceneError(f"{path}: no such file, and no interrupted run beside it")
    parts = read_parts(folder / HEAD, step_files(folder))
    status = "running" if is_held(folder) else "interrupted"
    return replace(parts, path=path, folder=folder, status=status)


def read_parts(head: Path, steps: Mapping[int, Path]) -> Result:
    """Read the files of a run that goes on, each of which is a result file of its own.

    One that is damaged says nothing about the others: it is left out, and named in `notes`.

    Parameters
    ----------
    head : Path
        The file without a load.
    steps : dict
        The files with one load each, by its number.

    Returns
    -------
    Result
        With all loads that can be read.

    Raises
    ------
    SceneError
        Where nothing can be read.
    """
    parts: list[Result] = []
    notes = []
    for index, file in [(None, head), *steps.items()]:
        try:
            part = read_file(file)
            if index is not None and part.indices != [index]:
                raise SceneError(f"{file}: holds no load step {index}")
            if parts and part.head.get("identity") != parts[0].head.get("identity"):
                raise SceneError(f"{file}: belongs to another scene")
            parts.append(part)
        except SceneError as error:
            notes.append(f"left out: {error}")
    if not parts:
        raise SceneError(notes[0].removeprefix("left out: "))
    return replace(
        parts[0],
        steps=[step for part in parts for step in part.steps],
        indices=[index for part in parts for index in part.indices],
        fields=[fields for part in parts for fields in part.fields],
        notes=tuple(notes),
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
    checkpoint = read_file(path, CHECKPOINT)
    if checkpoint.head.get("identity") != identity:
        raise SceneError(f"{path}: a checkpoint of another scene, allowed: of this one")
    complete = [{"p", "seconds", "iterations", "fft_pairs"} <= {*step} for step in checkpoint.steps]
    if complete != [True] or "gap" not in checkpoint.fields[0]:
        raise SceneError(f"{path}: a checkpoint of another version of hpc_gfmd, allowed: of this")
    return checkpoint


def read_file(path: Path, kind: str = FORMAT) -> Result:
    """Read all that one file says, its load steps in the order of their numbers.

    Parameters
    ----------
    path : Path
        The file.
    kind : str
        Its format: FORMAT or CHECKPOINT.

    Returns
    -------
    Result
        Fields are read later, slab by slab.

    Raises
    ------
    SceneError
        For whatever goes wrong.
    """
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
    elif path.stat().st_size == 0:
        unfit = "found an empty file, allowed: a result file"
    elif not h5py.is_hdf5(path):
        unfit = "not an HDF5 file"
    else:
        return
    raise SceneError(f"{path}: {unfit}")


def _fields(path: Path, group: Any, n: list[int]) -> dict[str, Stored]:
    """Find the fields in a group of an open file, to be read slab by slab later. Raises ValueError
    if one does not fit the surface."""
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
            fields[name] = Stored(
                path, data.name.lstrip("/"), data.shape, data.dtype, int(data.attrs[CHECKSUM])
            )
    return fields


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
    if isinstance(text, str):
        return one_line(text, len(text) + 1)
    return [_printable(item) for item in text]
