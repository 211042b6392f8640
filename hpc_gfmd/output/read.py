"""Reading result files: whole ones, and what an interrupted run left. Executes nothing, needs no MPI."""

import json
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .. import errors
from ..errors import SceneError
from ..parallel import h5_inside, h5_probe, h5_seal, h5_sum
from ..parallel.guard import one_line
from ..parallel.h5 import Stored
from ..parallel.h5_layout import FORMAT, FORMAT_VERSION
from . import check, lock

HEAD = "head.h5"  # of a partial folder
LOOK_ROWS = 64


@dataclass(frozen=True)
class Result:
    """What a result file says.

    surface: attributes of the surface; steps: one dict of attributes per load step, indices: their numbers;
    status: of the whole run ("running" or "interrupted" if the file was never finished);
    head: all root attributes; fields: per step {name: Stored}, to be read slab by slab;
    folder: of the unfinished run, otherwise None.
    """

    path: Path
    surface: dict
    steps: list[dict]
    indices: list[int]
    status: str
    scene_toml: str
    versions: dict
    head: dict
    fields: list[dict[str, Stored]] = field(repr=False)
    folder: Path | None = None


def partial_folder(path) -> Path:
    """Where a run that writes `path` keeps its finished steps and checkpoints."""
    path = Path(path)
    return path.with_name(path.name + ".partial")


def read_result(path) -> Result:
    """The result file, or, if there is none, what an interrupted run left beside it.

    Raises SceneError (one line) if there is nothing, or the file is no HDF5, damaged, foreign or too new.
    """
    path = Path(path)
    if path.exists() or not partial_folder(path).is_dir():
        return _read_whole(path)
    return read_partial(path)


def read_partial(path) -> Result:
    """The finished steps of a run that has not written `path` yet, status "interrupted" (or "running").

    A step file that cannot be read is left out: that step is not done. Raises SceneError as read_result.
    """
    path = Path(path)
    folder = partial_folder(path)
    head_path = folder / HEAD
    if not head_path.exists():
        raise SceneError(f"{path}: no such file, and no interrupted run beside it")
    with opened(head_path) as file:
        head, surface = _head(file)
    steps = {}
    for index, step_path in step_files(folder).items():
        try:
            with opened(step_path) as file:
                steps[index] = _step(file, step_path, "", surface.get("n"))
        except SceneError:
            continue
    return _result(path, head, surface, steps, "running" if lock.is_held(folder) else "interrupted", folder)


def step_files(folder: Path) -> dict[int, Path]:
    """Finished steps of a partial folder by index."""
    return {int(p.stem[5:]): p for p in sorted(folder.glob("step-*.h5")) if p.stem[5:].isdigit()}


def look(path: str) -> None:
    """Read a file without a valid seal as any of its readers would: as a result, a step or a checkpoint, compressed fields and all."""
    result = []
    h5_probe.attempt(lambda: result.append(_read_whole(Path(path), trusted=True)))
    fields = [field for step in result for one in step.fields for field in one.values()]
    try:
        with opened(path, trusted=True) as file:
            h5_probe.attempt(_head, file)
            h5_probe.attempt(_step, file, Path(path), "", None)
            fields += [stored_field(Path(path), name, item) for name, item in h5_inside.items(file) if hasattr(item, "dtype")]
    except SceneError:
        pass
    for field_ in fields:
        for start in range(0, field_.shape[0] if field_.compressed else 0, LOOK_ROWS):
            h5_probe.attempt(field_.read, start, start + LOOK_ROWS)


def _read_whole(path: Path, trusted=False) -> Result:
    with opened(path, trusted) as file:
        head, surface = _head(file)
        steps = h5_inside.item(file, "steps")
        groups = {} if steps is None else {name: group for name, group in h5_inside.items(steps) if name.isdigit()}
        steps = {int(name): _step(groups[name], path, f"steps/{name}/", surface.get("n")) for name in sorted(groups)}
    return _result(path, head, surface, steps, str(head.get("status", "unknown")))


def _result(path, head, surface, steps, status, folder=None) -> Result:
    try:
        versions = json.loads(head.get("versions", "{}"))
    except (ValueError, TypeError):
        versions = {}
    attributes, fields = zip(*steps.values(), strict=True) if steps else ((), ())
    scene = str(head.get("scene", ""))
    return Result(
        path, surface, list(attributes), list(steps), status, scene, versions, head, list(fields), folder
    )


@contextmanager
def opened(path, trusted=False):
    """`with opened(path) as file`: a checked h5py file of ours; whatever goes wrong inside is one SceneError.

    trusted: the HDF5 library may see the file whatever its seal says.
    """
    import h5py

    path = Path(path)
    try:
        seal = _checked_seal(path, trusted)
        with h5py.File(path, "r", locking=False) as file:
            name, version = (_plain(file.attrs.get(key)) for key in ("format", "format_version"))
            if name == FORMAT and (not isinstance(version, int) or version > FORMAT_VERSION):
                known = f"this program reads up to {FORMAT_VERSION}"
                raise SceneError(f"{path}: format_version is {errors.one_line(repr(version))}, {known}")
            if seal == "broken":
                raise SceneError(f"{path}: the file is damaged, or was changed after it was written")
            if name != FORMAT:
                raise SceneError(f"{path}: not a result of hpc-gfmd (no attribute format = '{FORMAT}')")
            yield file
    except FileNotFoundError:
        raise SceneError(f"{path}: no such file") from None
    except PermissionError:
        raise SceneError(f"{path}: no permission to read it") from None
    except SceneError:
        raise
    except Exception as error:
        raise SceneError(f"{path}: the file is damaged ({one_line(error)})") from error


def _checked_seal(path, trusted) -> str:
    """Refuse what the HDF5 library had better not see."""
    if path.is_dir():
        raise SceneError(f"{path}: is a folder, not a result file")
    seal = h5_seal.check(path)
    if seal == "foreign":
        raise SceneError(f"{path}: not an HDF5 file")
    if seal == "short":
        raise SceneError(f"{path}: the file is cut short")
    if seal != "intact" and not trusted and not h5_probe.survives(look, path):
        raise SceneError(f"{path}: the file is damaged")
    return seal


def _head(file) -> tuple[dict, dict]:
    surface = h5_inside.item(file, "surface")
    if surface is None:
        raise ValueError("it has no surface")
    return _attributes(file), check.attributes(_attributes(surface))


def _step(group, path: Path, prefix: str, n) -> tuple[dict, dict[str, Stored]]:
    import h5py

    attributes, stored = _attributes(group), {}
    for name, item in h5_inside.items(group):
        if isinstance(item, h5py.Dataset) and item.ndim == 2:
            check.field(name, item, n)
            stored[name] = stored_field(path, prefix + name, item)
    for name in ("format", "format_version"):
        attributes.pop(name, None)
    return check.attributes(attributes), stored


def stored_field(path, name, dataset) -> Stored:
    """A dataset of an open file, to be read slab by slab later."""
    checksum = _plain(dataset.attrs.get(h5_sum.NAME))
    return Stored(path, name, dataset.shape, dataset.dtype, dataset.chunks is not None, checksum=checksum)


def _attributes(group) -> dict:
    return {name: _plain(value) for name, value in group.attrs.items()}


def _plain(value):
    """NumPy scalars and arrays as Python numbers, text and lists."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    return value.decode("utf-8") if isinstance(value, bytes) else value
