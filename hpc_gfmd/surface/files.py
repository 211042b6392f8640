"""Height maps from files, peaks up: .npy, HDF5 and NetCDF a few rows at a time, others as a whole
on every rank."""

from collections.abc import Callable, Mapping
from functools import cache
from math import prod
from pathlib import Path
from typing import Any, NoReturn
from zipfile import ZipFile

import numpy as np

from ..parallel.h5 import driver, inside, io_way
from ..util import errors
from ..util.errors import SceneError
from . import instruments, text
from .metadata import NAMES, Metadata, by_attributes, by_axes, ends
from .packed import Packing

Read = Callable[[slice, slice], np.ndarray]  # of rows and columns
NPY = b"\x93NUMPY"
ANY = "surface"  # the data set of a scene that names none
MASK = "mask"  # where it is not 0 there is no height (SurfaceTopography)
SMALL = 4096  # bytes of what an archive says of sizes and units
HDF5 = b"\x89HDF\r\n\x1a\n"  # how an HDF5 file begins, unless its user keeps something before it


class HeightMap:
    """shape (n_x, n_y), rows(start, stop) -> float64 (stop - start, n_y), nan where the file has no
    height, and what else is `said`.

    Raises SceneError for anything unreadable.
    """

    shape: tuple[int, ...]
    dtype: np.dtype

    def __init__(self, spec: Any) -> None:
        self.path = Path(spec.path)
        self.metadata = Metadata()
        self._hdf5_data: _Hdf5Data | None = None
        if not self.path.is_file():
            raise SceneError(
                f"surface.path: found {self.path}, which is no file, allowed: the path of a"
                " height map"
            )
        opener = {
            "npy": self._npy,
            "npz": self._npz,
            "hdf5": self._hdf5,
            "netcdf": self._netcdf,
        }.get(spec.format, self._whole)
        try:
            self.read = opener(spec)
        except SceneError:
            raise
        except Exception as error:
            raise SceneError(
                f"surface.path: {self.path} cannot be read as {spec.format}:"
                f" {errors.one_line(str(error))}"
            ) from None
        shape = getattr(self, "shape", None) or ()
        if len(shape) != 2 or min(shape) < 1:
            raise SceneError(
                f"surface.path: found an array of shape {tuple(shape)} in {self.path}, allowed: two"
                " axes, not empty"
            )
        if self.dtype.kind not in "fiu":
            found = errors.one_line(str(self.dtype), 80)
            raise SceneError(
                f"surface.path: found values of type {found} in {self.path}, allowed: real numbers"
            )
        if self.metadata.transposed:
            self.shape, along_y = self.shape[::-1], self.read
            self.read = lambda rows, columns: along_y(columns, rows).T

    def rows(self, start: int, stop: int) -> np.ndarray:
        """Rows start <= i < stop as float64. Raises SceneError if they cannot be read."""
        try:
            with np.errstate(over="ignore"):  # of long double; infinity is seen below
                return np.asarray(self.read(slice(start, stop), slice(None)), dtype=np.float64)
        except Exception as error:
            raise SceneError(
                f"surface.path: reading {self.path} failed: {errors.one_line(str(error))}"
            ) from None

    def read_together(self, comm: Any) -> None:
        """From here to `close` an HDF5 file is read by MPI-IO where there are several ranks, each
        of its own rows. Collective."""
        if self._hdf5_data is not None and io_way(comm) == "mpio":
            self._hdf5_data.close()
            self._hdf5_data.open(**driver(comm))

    def close(self) -> None:
        """Of an HDF5 file; collective after read_together."""
        if self._hdf5_data is not None:
            self._hdf5_data.close()

    def _npy(self, spec: Any) -> Read:
        with open(self.path, "rb") as file:
            if (
                file.read(len(NPY)) != NPY
            ):  # numpy.load would take it for something else, and say how to unpickle it
                raise ValueError("it does not begin as a .npy file does")
        data = np.load(self.path, mmap_mode="r", allow_pickle=False)
        return self._array(data)

    def _npz(self, spec: Any) -> Read:
        with np.load(self.path, allow_pickle=False) as file:
            inside = {*file.zip.namelist()}
            names = [name for name in file.files if f"{name}.npy" in inside]
            heads = {name: _npz_head(file.zip, name) for name in names}
            name = self._one_of(
                [name for name, (shape, _) in heads.items() if len(shape) == 2], spec
            )
            sizes = {key: prod(shape) * dtype.itemsize for key, (shape, dtype) in heads.items()}
            small = (key for key in NAMES if sizes.get(key, SMALL) < SMALL)
            self.metadata = by_attributes({key: file[key] for key in small})
            self.shape, self.dtype = heads[name]
            if file.zip.getinfo(f"{name}.npy").file_size < sizes[name]:
                raise ValueError(f"{name} is shorter than it says")

        @cache
        def array() -> np.ndarray:  # unpacked where it is first read: by then it is known to fit
            with np.load(self.path, allow_pickle=False) as file:
                return file[name]

        return lambda rows, columns: array()[rows, columns]

    def _hdf5(self, spec: Any) -> Read:
        import h5py

        with h5py.File(self.path, "r", locking=False) as file:
            names = []
            file.visititems(
                lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None
            )
            name = (
                self._one_of([n for n in names if len(file[n].shape or ()) == 2], spec)
                if spec.dataset not in file
                else spec.dataset
            )
            data = inside(file, name)
            if not isinstance(data, h5py.Dataset):
                self._no_dataset(spec, names)
            self.shape, self.dtype = data.shape, data.dtype
            scales = [scale[0] for scale in data.dims if len(scale)] if data.ndim == 2 else []
            axes = [
                (scale.name.rpartition("/")[2], dict(scale.attrs), ends(scale), len(scale))
                for scale in scales
            ]
            self.metadata = (
                by_axes(dict(data.attrs), axes)
                if len(axes) == 2
                else by_attributes(data.attrs, file.attrs)
            )
            packing = Packing(data.attrs)
            band = (
                data.chunks[0] * data.shape[1] * data.dtype.itemsize
                if data.chunks and data.ndim == 2
                else 0
            )
        self._hdf5_data = _Hdf5Data(self.path, name, packing, band)
        return self._hdf5_data.read

    def _netcdf(self, spec: Any) -> Read:
        with open(self.path, "rb") as file:
            if file.read(len(HDF5)) == HDF5:
                return self._hdf5(spec)
        from scipy.io import netcdf_file

        file = netcdf_file(self.path, "r", mmap=True)
        name = self._one_of(
            [name for name, variable in file.variables.items() if len(variable.shape) == 2], spec
        )
        data = file.variables[name].data
        self.shape, self.dtype = data.shape, data.dtype
        self.metadata = by_axes(
            vars(file.variables[name]),
            [
                self._axis(file.variables.get(axis), axis, n)
                for axis, n in zip(file.variables[name].dimensions, data.shape)
            ],
        )
        packing = Packing(vars(file.variables[name]))
        masked = MASK in file.variables and file.variables[MASK].shape == data.shape

        def read(rows: slice, columns: slice) -> np.ndarray:
            # asked anew for each piece: the file may be closed only when nothing refers to its
            # memory any more
            z = packing.unpacked(np.array(file.variables[name].data[rows, columns]))
            return np.where(file.variables[MASK].data[rows, columns], np.nan, z) if masked else z

        return read

    @staticmethod
    def _axis(
        variable: Any, name: str, n: int
    ) -> tuple[str, Mapping[str, Any], np.ndarray | None, int]:
        if variable is None:
            return name, {}, None, n
        return name, vars(variable), ends(variable.data) if variable.shape == (n,) else None, n

    def _whole(self, spec: Any) -> Read:
        if spec.format == "text":
            heights, self.metadata = text.read(self.path, spec)
        else:
            heights, self.metadata = instruments.read(self.path, spec.dataset)
        return self._array(heights)

    def _array(self, data: np.ndarray) -> Read:
        self.shape, self.dtype = data.shape, data.dtype
        return lambda rows, columns: data[rows, columns]

    def _one_of(self, names: list[str], spec: Any) -> str:
        """The data set that the scene names, or the only one that may be meant. Raises
        SceneError."""
        maps = [name for name in names if name != MASK]
        name = maps[0] if len(maps) == 1 and spec.dataset == ANY else spec.dataset
        if name not in names:
            self._no_dataset(spec, names)
        return name

    def _no_dataset(self, spec: Any, names: list[str]) -> NoReturn:
        found, allowed = (
            errors.one_line(repr(spec.dataset)),
            errors.one_line(", ".join(names[:10]), 400),
        )
        raise SceneError(
            f"surface.dataset: found {found}, allowed in {self.path}:"
            f" {allowed or 'nothing, it has no data set'}"
        )


def _npz_head(archive: ZipFile, name: str) -> tuple[tuple[int, ...], np.dtype]:
    """Shape and type of an array, of which nothing is unpacked."""
    with archive.open(f"{name}.npy") as file:
        version = np.lib.format.read_magic(file)
        read = np.lib.format.read_array_header_1_0
        shape, _, dtype = (read if version == (1, 0) else np.lib.format.read_array_header_2_0)(file)
    return shape, dtype


class _Hdf5Data:
    """A data set that stays open: chunks that the next rows need as well are kept, because
    unpacking a large one each time takes for ever. band: bytes of the chunks that make complete
    rows. Refers to no HeightMap, so that it is closed as soon as that is gone."""

    def __init__(self, path: str | Path, name: str, packing: Packing, band: int) -> None:
        self.path, self.name, self.packing = path, name, packing
        self.cache = {"rdcc_nbytes": max(2 * band, 2**20), "rdcc_nslots": 10007}
        self.open(locking=False)

    def open(self, **how: Any) -> None:
        import h5py

        self.file = h5py.File(self.path, "r", **how, **self.cache)
        self.data = self.file[self.name]

    def read(self, rows: slice, columns: slice) -> np.ndarray:
        return self.packing.unpacked(self.data[rows, columns])

    def close(self) -> None:
        self.file.close()
