"""Reading result files: whole ones, and what an interrupted run left. Executes nothing, needs no MPI."""

import json
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..errors import SceneError
from ..parallel import h5_seal
from ..parallel.guard import one_line
from ..parallel.h5 import Stored
from ..parallel.h5_layout import FORMAT, FORMAT_VERSION
from . import lock

HEAD = "head.h5"  # of a partial folder


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
        head, surface = _attributes(file), _attributes(file["surface"])
    steps = {}
    for index, step_path in step_files(folder).items():
        try:
            with opened(step_path) as file:
                steps[index] = _step(file, step_path, "")
        except SceneError:
            continue
    return _result(path, head, surface, steps, "running" if lock.is_held(folder) else "interrupted", folder)


def step_files(folder: Path) -> dict[int, Path]:
    """Finished steps of a partial folder by index."""
    return {int(p.stem[5:]): p for p in sorted(folder.glob("step-*.h5")) if p.stem[5:].isdigit()}


def _read_whole(path: Path) -> Result:
    with opened(path) as file:
        head, surface = _attributes(file), _attributes(file["surface"])
        names = sorted(name for name in file.get("steps", ()) if name.isdigit())
        steps = {int(name): _step(file[f"steps/{name}"], path, f"steps/{name}/") for name in names}
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
def opened(path):
    """`with opened(path) as file`: a checked h5py file of ours; whatever goes wrong inside is one SceneError."""
    import h5py

    path = Path(path)
    try:
        seal = _checked_seal(path)
        with h5py.File(path, "r", locking=False) as file:
            name, version = (_plain(file.attrs.get(key)) for key in ("format", "format_version"))
            if name == FORMAT and (not isinstance(version, int) or version > FORMAT_VERSION):
                known = f"this program reads up to {FORMAT_VERSION}"
                raise SceneError(f"{path}: format_version is {version!r}, {known}")
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


def _checked_seal(path) -> str:
    """Refuse what the HDF5 library had better not see."""
    if path.is_dir():
        raise SceneError(f"{path}: is a folder, not a result file")
    seal = h5_seal.check(path)
    if seal == "foreign":
        raise SceneError(f"{path}: not an HDF5 file")
    if seal == "short":
        raise SceneError(f"{path}: the file is cut short")
    if seal != "intact" and not h5_seal.survives_reading(path, FORMAT):
        raise SceneError(f"{path}: the file is damaged")
    return seal


def _step(group, path: Path, prefix: str) -> tuple[dict, dict[str, Stored]]:
    import h5py

    attributes = _attributes(group)
    stored = {
        name: Stored(path, prefix + name, item.shape, item.dtype, item.chunks is not None)
        for name, item in group.items()
        if isinstance(item, h5py.Dataset) and item.ndim == 2
    }
    for name in ("format", "format_version"):
        attributes.pop(name, None)
    return attributes, stored


def _attributes(group) -> dict:
    return {name: _plain(value) for name, value in group.attrs.items()}


def _plain(value):
    """NumPy scalars and arrays as Python numbers, text and lists."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    return value.decode("utf-8") if isinstance(value, bytes) else value
