"""Height maps from files, peaks up: .npy, HDF5 and NetCDF a few rows at a time, others as a whole
on every rank."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import prod
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np

from ..parallel.h5 import inside
from ..scene.surface import ANY
from ..util.errors import SceneError, one_line
from ..util.file_names import require_name
from . import instruments, pictures, text
from .heights import require_map
from .metadata import NAMES, Map, Metadata, by_attributes, by_axes
from .packed import unpacker

MASK = "mask"  # where it is not 0 there is no height (SurfaceTopography)
SMALL = 4096  # bytes of what an archive says of sizes and units


@dataclass(frozen=True)
class FileArray:
    """Heights in a file: the numbers of the array `name`, unpacked, nan where the whole numbers of
    an array MASK beside it are not 0. find(name): an array, what is sliced as one, or None."""

    shape: tuple[int, ...]
    dtype: np.dtype
    name: str
    unpacked: Callable[[np.ndarray], np.ndarray]
    find: Callable[[str], Any]

    def __getitem__(self, part: Any) -> np.ndarray:
        z = self.unpacked(self.find(self.name)[part])
        mask = self.find(MASK)
        another = self.name.rpartition("/")[2] != MASK
        fits = another and getattr(mask, "shape", None) == self.shape
        if not fits or mask[part].dtype.kind not in "bui":
            return z
        return np.where(mask[part], np.nan, z)


def open_map(spec: Any) -> Map:
    """Open the height map of a scene.File, of one path: (its numbers, two axes; the Metadata beside
    them). Raises SceneError for anything unreadable, and for what holds no heights."""
    path = Path(spec.path)
    require_name("surface.path", path)
    if not path.is_file():
        raise SceneError(
            f"surface.path: found {path}, which is no file, allowed: the path of a height map"
        )
    suffix = path.suffix.lower()
    kind, opener = next(
        (kind, opener)
        for kind, (opener, own) in OPENERS.items()
        if suffix in own.split() or not own
    )
    try:
        data, said = opener(path, spec)
        require_map(data, "surface.path", f" in {path}")
    except SceneError:
        raise
    except Exception as error:
        raise SceneError(
            f"surface.path: {path} cannot be read as {kind}: {one_line(str(error))}"
        ) from None
    return data, said


def _npy(path: Path, spec: Any) -> Map:
    return np.lib.format.open_memmap(path, mode="r"), Metadata()  # never unpickles, unlike load


def _npz(path: Path, spec: Any) -> Map:
    with np.load(path, allow_pickle=False) as file:
        arrays = [name for name in file.files if f"{name}.npy" in file.zip.namelist()]
        heads = {name: _npz_head(file.zip, name) for name in arrays}
        name = _one_of([name for name, (shape, _) in heads.items() if len(shape) == 2], spec)
        sizes = {key: prod(shape) * dtype.itemsize for key, (shape, dtype) in heads.items()}
        said = by_attributes({key: file[key] for key in NAMES if sizes.get(key, SMALL) < SMALL})
        if file.zip.getinfo(f"{name}.npy").file_size < sizes[name]:
            raise ValueError(f"{name} is shorter than it says")

    @cache
    def find(key: str) -> Any:  # unpacked where it is first read: by then it is known to fit
        with np.load(path, allow_pickle=False) as file:
            return file[key] if key in heads and not heads[key][1].hasobject else None

    return FileArray(*heads[name], name, np.asarray, find), said


def _npz_head(archive: ZipFile, name: str) -> tuple[tuple[int, ...], np.dtype]:
    """Read shape and type of an array in an archive, of which nothing is unpacked."""
    with archive.open(f"{name}.npy") as file:
        version = np.lib.format.read_magic(file)
        read = np.lib.format.read_array_header_1_0
        shape, _, dtype = (read if version == (1, 0) else np.lib.format.read_array_header_2_0)(file)
    return shape, dtype


def _hdf5(path: Path, spec: Any) -> Map:
    import h5py

    with h5py.File(path, "r", locking=False) as file:
        data = inside(file, spec.dataset) if spec.dataset in file else None
        if not isinstance(data, h5py.Dataset):  # nothing, or a group
            names: list[str] = []
            file.visit(names.append)
            maps = [name for name in names if len(getattr(file[name], "shape", None) or ()) == 2]
            data = inside(file, _one_of(maps, spec))
        axes = [
            (axis[0].name.rpartition("/")[2], dict(axis[0].attrs), axis[0])
            for axis in data.dims
            if len(axis)
        ]
        attributes = dict(data.attrs)
        said = (
            by_axes(attributes, axes) if len(axes) == 2 else by_attributes(attributes, file.attrs)
        )
        # Chunks that the next rows need as well are kept: unpacking a large one takes long.
        band = data.chunks[0] * prod(data.shape[1:]) * data.dtype.itemsize if data.chunks else 0
        folder = data.parent.name
        head = data.shape, data.dtype, data.name, unpacker(attributes)
    kept = max(2 * band, 2**20)
    beside = h5py.File(path, "r", locking=False, rdcc_nbytes=kept, rdcc_nslots=10007)[folder]
    return FileArray(
        *head, cache(lambda key: inside(beside, key) if beside.get(key) else None)
    ), said


def _netcdf(path: Path, spec: Any) -> Map:
    import h5py
    from scipy.io import netcdf_file

    if h5py.is_hdf5(path):  # NetCDF 4
        return _hdf5(path, spec)
    file = netcdf_file(path, "r", mmap=True)
    name = _one_of([key for key, found in file.variables.items() if len(found.shape) == 2], spec)
    variable = file.variables[name]
    shape = variable.data.shape
    axes = [
        (axis, vars(x) if x else {}, x.data if x and x.shape == (n,) else None)
        for axis, n in zip(variable.dimensions, shape)
        for x in [file.variables.get(axis)]
    ]
    said = by_axes(vars(variable), axes)
    return FileArray(
        shape,
        variable.data.dtype,
        name,
        unpacker(vars(variable)),
        # found anew for each piece: the file may be closed only when nothing refers to its memory
        lambda key: file.variables.get(key),
    ), said


def _one_of(names: list[str], spec: Any) -> str:
    """Choose the data set that the scene names, or the only one that may be meant. Raises
    SceneError."""
    maps = [name for name in names if name != MASK]
    name = maps[0] if len(maps) == 1 and spec.dataset == ANY else spec.dataset
    if name not in names:
        allowed = one_line(", ".join(names[:10]), 400) or "nothing, it has no map"
        raise SceneError(
            f"surface.dataset: found {one_line(repr(spec.dataset))}, allowed in {spec.path}:"
            f" {allowed}"
        )
    return name


OPENERS = {  # and extensions; "": all others
    "npy": (_npy, ".npy"),
    "npz": (_npz, ".npz"),
    "hdf5": (_hdf5, ".h5 .hdf5"),
    "netcdf": (_netcdf, ".nc"),
    "text": (text.read, ".txt .csv .asc .dat .xyz"),
    "picture": (pictures.read, ".tif .tiff .png"),
    "other": (instruments.read, ""),  # by SurfaceTopography
}
