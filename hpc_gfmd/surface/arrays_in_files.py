"""Height maps that are arrays in a file (.npy, .npz, HDF5, NetCDF), read a few rows at a time."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from math import prod
from typing import Any
from zipfile import ZipFile

import numpy as np

from ..parallel.h5 import inside
from ..scene.height_maps import ANY
from ..util.errors import SceneError, one_line
from .contents import Contents
from .metadata import ATTRIBUTES, Map, Metadata, by_attributes, by_axes
from .packed import unpacker

MASK = "mask"  # where it is not 0 there is no height (SurfaceTopography)
SMALL = 4096  # bytes of what an archive says of sizes and units


@dataclass(frozen=True)
class FileArray:
    """Heights in a file: array[i0:i1] or array[:, j0:j1] reads this part, nan where missing."""

    shape: tuple[int, ...]
    dtype: np.dtype  # of the numbers as they are stored
    name: str  # of the array in the file
    # converts the numbers as they are stored to heights
    unpacked: Callable[[np.ndarray], np.ndarray]
    # takes the name of an array; returns it, or anything sliced like one, or None
    find: Callable[[str], Any]
    # Whether an array "mask" lies beside the heights; where it is not 0 the height is missing.
    has_mask: bool = False

    def __getitem__(self, part: Any) -> np.ndarray:
        """Read a part of the heights, nan where the mask is 1; ValueError unless it is 0 or 1."""
        z = self.unpacked(self.find(self.name)[part])
        return masked(z, np.asarray(self.find(MASK)[part])) if self.has_mask else z


def masked(z: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Return heights with nan where a mask of 0 and 1 is not 0; ValueError for other numbers."""
    if mask.dtype.kind == "f" and not np.isin(mask, (0, 1)).all():
        raise ValueError(f"found an array {MASK} of other numbers than 0 and 1 beside it")
    return np.where(mask, np.nan, z)


def read_npy(contents: Contents, spec: Any) -> Map:
    """Open an array of numpy.save, memory-mapped unless packed; pickled objects are refused."""
    if contents.unpacked is None:
        return np.lib.format.open_memmap(contents.path, mode="r"), Metadata()
    return np.lib.format.read_array(contents.open(), allow_pickle=False), Metadata()


def read_npz(contents: Contents, spec: Any) -> Map:
    """Read the only array of numpy.savez, or `dataset`; mask, sizes and units may lie beside it."""
    with np.load(contents.source, allow_pickle=False) as file:
        arrays = [name for name in file.files if f"{name}.npy" in file.zip.namelist()]
        heads = {name: _head_in_archive(file.zip, name) for name in arrays}
        name, other_names = one_of({name: shape for name, (shape, _) in heads.items()}, spec)
        sizes = {key: prod(shape) * dtype.itemsize for key, (shape, dtype) in heads.items()}
        metadata = by_attributes(
            {key: file[key] for key in ATTRIBUTES if sizes.get(key, SMALL) < SMALL}
        )
        if file.zip.getinfo(f"{name}.npy").file_size < sizes[name]:
            raise ValueError(f"{name} is shorter than it says")
        shape, _ = heads[name]
        has_mask = name != MASK and MASK in heads and is_mask(*heads[MASK], shape)
        heights = file[name]
        if has_mask:
            heights = masked(heights, file[MASK])
    return heights, replace(metadata, channel=name, other_channels=other_names)


def read_hdf5(contents: Contents, spec: Any) -> Map:
    """Open one data set of an HDF5 or NetCDF 4 file, with metadata from attributes of it, its axes
    and the file; the file stays open as long as the FileArray exists.
    """
    import h5py

    with h5py.File(contents.source, "r", locking=False) as file:
        data = inside(file, spec.dataset) if spec.dataset in file else None
        other_names: tuple[str, ...] = ()
        if not isinstance(data, h5py.Dataset):  # nothing, or a group
            names: list[str] = []
            file.visit(names.append)
            shapes = {name: getattr(file[name], "shape", None) or () for name in names}
            name, other_names = one_of(shapes, spec)
            data = inside(file, name)
        axes = [
            (axis[0].name.rpartition("/")[2], dict(axis[0].attrs), axis[0])
            for axis in data.dims
            if len(axis)
        ]
        attributes = dict(data.attrs)
        with_axes = len(axes) == 2
        metadata = by_axes(attributes, axes) if with_axes else by_attributes(attributes, file.attrs)
        if "MATLAB_class" in attributes:  # which writes columns before rows
            metadata = replace(
                metadata, transposed=True, direction="along the first index in MATLAB"
            )
        # Chunks that the next rows need as well are kept: unpacking a large one takes long.
        is_y_first = metadata.transposed if spec.first_axis is None else spec.first_axis == "y"
        chunk_rows = data.chunks[int(is_y_first)] if data.chunks and data.ndim == 2 else 0
        band = chunk_rows * data.nbytes // max(data.shape[int(is_y_first)], 1) if chunk_rows else 0
        folder = data.parent.name
        shape = data.shape
        dtype = data.dtype
        name = data.name
        is_other = name.rpartition("/")[2] != MASK
        mask = data.parent.get(MASK) if is_other else None
        has_mask = mask is not None and is_mask(
            getattr(mask, "shape", ()), getattr(mask, "dtype", np.dtype("O")), shape
        )
    kept = max(2 * band, 2**20)
    opened = h5py.File(contents.source, "r", locking=False, rdcc_nbytes=kept, rdcc_nslots=10007)
    beside = opened[folder]
    find = cache(lambda key: inside(beside, key) if beside.get(key) else None)
    array = FileArray(shape, dtype, name, unpacker(attributes), find, has_mask)
    return array, replace(metadata, channel=name.strip("/"), other_channels=other_names)


def read_netcdf(contents: Contents, spec: Any) -> Map:
    """Open one variable of a NetCDF 3 file, which stays open as long as the FileArray exists."""
    from scipy.io import netcdf_file

    file = netcdf_file(contents.source, "r", mmap=contents.unpacked is None)
    shapes = {name: variable.shape for name, variable in file.variables.items()}
    name, other_names = one_of(shapes, spec)
    variable = file.variables[name]
    shape = variable.data.shape
    axes = []
    for axis, n in zip(variable.dimensions, shape):
        x = file.variables.get(axis)
        axes.append((axis, vars(x) if x else {}, x.data if x and x.shape == (n,) else None))
    mask = file.variables.get(MASK) if name != MASK else None
    has_mask = mask is not None and is_mask(mask.shape, mask.data.dtype, shape)
    # found anew for each piece: the file may be closed only when nothing refers to its memory
    array = FileArray(
        shape,
        variable.data.dtype,
        name,
        unpacker(vars(variable)),
        lambda key: file.variables.get(key),
        has_mask,
    )
    return array, replace(by_axes(vars(variable), axes), channel=name, other_channels=other_names)


def one_of(shapes: Mapping[str, tuple[int, ...]], spec: Any) -> tuple[str, tuple[str, ...]]:
    """Return the name of the height map, the one the scene names or else the only array with two
    axes, and the other names. Arrays "mask" and single rows or columns need to be named.
    """
    flat = [name for name, shape in shapes.items() if len(shape) == 2]
    maps = [name for name in flat if name != MASK]
    wide = [name for name in maps if min(shapes[name]) > 1]  # MATLAB's vectors are not
    maps = wide or maps
    if len(maps) == 1 and spec.dataset == ANY:
        return maps[0], ()
    if spec.dataset not in flat:
        allowed = one_line(", ".join(maps[:10]), 400) or "nothing, it has no map" + (
            " but lines of numbers, such as a profile" if 1 in map(len, shapes.values()) else ""
        )
        raise SceneError(
            f"surface.dataset: found {one_line(repr(spec.dataset))}, allowed in {spec.path}:"
            f" {allowed}"
        )
    return spec.dataset, tuple(name for name in maps if name != spec.dataset)


def is_mask(
    shape: tuple[int, ...] | None, dtype: np.dtype, shape_of_heights: tuple[int, ...]
) -> bool:
    """Whether the array "mask" marks missing points; not if it is NumPy's scalar for "nothing"."""
    if shape == () and dtype.kind == "b":  # NumPy's for "nothing is masked"
        return False
    if shape != shape_of_heights or dtype.kind not in "buif":
        raise ValueError(
            f"found an array {MASK} of shape {shape} of {one_line(str(dtype), 40)} beside heights"
            f" of shape {shape_of_heights}, allowed: 0 and 1 for each of their points"
        )
    return True


def _head_in_archive(archive: ZipFile, name: str) -> tuple[tuple[int, ...], np.dtype]:
    """Return (shape, dtype) of the array `name` in a .npz archive; only its header is read."""
    with archive.open(f"{name}.npy") as file:
        version = np.lib.format.read_magic(file)
        read = np.lib.format.read_array_header_1_0
        shape, _, dtype = (read if version == (1, 0) else np.lib.format.read_array_header_2_0)(file)
    return shape, dtype
