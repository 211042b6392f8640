"""Height maps from files, peaks up, read a few rows at a time: .npy, HDF5, NetCDF, and what SurfaceTopography reads if installed."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np

from .. import errors
from ..errors import SceneError
from ..parallel import h5_inside, h5_probe
from .heights import checked
from .packed import Packing

NPY = b"\x93NUMPY"
PIECE_ROWS = 64
HDF5 = b"\x89HDF\r\n\x1a\n"  # how an HDF5 file begins, unless its user keeps something before it


def look(path, dataset):
    """Read an HDF5 file as a height map is read; its numbers, too, if they are in chunks."""
    found = HeightMap(SimpleNamespace(path=path, format="hdf5", dataset=dataset))
    for start in range(0, found.shape[0] if found.packed else 0, PIECE_ROWS):
        h5_probe.attempt(found.rows, start, min(start + PIECE_ROWS, found.shape[0]))


class HeightMap:
    """shape (n_x, n_y) and rows(start, stop) -> float64 (stop - start, n_y). Raises SceneError for anything unreadable.

    probe: find out first, in a process of its own, whether the HDF5 library survives the file.
    """

    def __init__(self, spec, probe=False):
        self.path = Path(spec.path)
        self.probe = probe
        if not self.path.is_file():
            raise SceneError(f"surface.path: found {self.path}, which is no file, allowed: the path of a height map")
        opener = {"npy": self._npy, "hdf5": self._hdf5, "netcdf": self._netcdf}.get(spec.format, self._other)
        try:
            self.read = opener(spec)
        except SceneError:
            raise
        except Exception as error:
            raise SceneError(f"surface.path: {self.path} cannot be read as {spec.format}: {errors.one_line(str(error))}") from None
        shape = getattr(self, "shape", None) or ()
        if len(shape) != 2 or min(shape) < 1:
            raise SceneError(f"surface.path: found an array of shape {tuple(shape)} in {self.path}, allowed: two axes, not empty")
        if self.dtype.kind not in "fiu":
            found = errors.one_line(str(self.dtype), 80)
            raise SceneError(f"surface.path: found values of type {found} in {self.path}, allowed: real numbers")

    def rows(self, start, stop):
        """Rows start <= i < stop as float64. Raises SceneError if a height is no number to compute with."""
        try:
            with np.errstate(over="ignore"):  # of long double; infinity is seen below
                z = np.asarray(self.read(start, stop), dtype=np.float64)
        except Exception as error:
            raise SceneError(f"surface.path: reading {self.path} failed: {errors.one_line(str(error))}") from None
        return checked(z, start, "surface.path", f" in {self.path}")

    def _npy(self, spec):
        with open(self.path, "rb") as file:
            if file.read(len(NPY)) != NPY:  # numpy.load would take it for something else, and say how to unpickle it
                raise ValueError("it does not begin as a .npy file does")
        data = np.load(self.path, mmap_mode="r", allow_pickle=False)
        self.shape, self.dtype = data.shape, data.dtype
        return lambda start, stop: data[start:stop]

    def _hdf5(self, spec):
        import h5py

        if self.probe and h5py.is_hdf5(self.path) and not h5_probe.survives(look, self.path, spec.dataset):
            raise ValueError("the file is damaged")
        with h5py.File(self.path, "r", locking=False) as file:
            data = h5_inside.item(file, spec.dataset)
            if not isinstance(data, h5py.Dataset):
                names = []
                file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
                self._no_dataset(spec, names)
            self.shape, self.dtype = data.shape, data.dtype
            packing = Packing(data.attrs)
            self.packed = data.chunks is not None and data.id.get_storage_size() > 0

        def read(start, stop):
            with h5py.File(self.path, "r", locking=False) as file:
                return packing.unpacked(h5_inside.item(file, spec.dataset)[start:stop])

        return read

    def _netcdf(self, spec):
        with open(self.path, "rb") as file:
            if file.read(len(HDF5)) == HDF5:
                return self._hdf5(spec)
        from scipy.io import netcdf_file

        file = netcdf_file(self.path, "r", mmap=True)
        names = [name for name, v in file.variables.items() if len(v.shape) == 2]
        name = names[0] if len(names) == 1 else spec.dataset
        if name not in names:
            self._no_dataset(spec, names)
        data = file.variables[name].data
        self.shape, self.dtype = data.shape, data.dtype
        packing = Packing(vars(file.variables[name]))
        # asked anew for each piece: the file may be closed only when nothing refers to its memory any more
        return lambda start, stop: packing.unpacked(np.array(file.variables[name].data[start:stop]))

    def _no_dataset(self, spec, names):
        found, allowed = errors.one_line(repr(spec.dataset)), errors.one_line(", ".join(names[:10]), 400)
        raise SceneError(f"surface.dataset: found {found}, allowed in {self.path}: {allowed or 'nothing, it has no data set'}")

    def _other(self, spec):
        try:
            import SurfaceTopography
        except ImportError:
            raise SceneError(f"surface.path: found {self.path}, allowed: .npy, .h5, .hdf5, .nc "
                             f"(and more where the package SurfaceTopography is installed)") from None
        data = SurfaceTopography.read_topography(str(self.path)).heights()
        if np.ma.isMaskedArray(data) and data.mask.any():
            raise SceneError(f"surface.path: {self.path} has undefined points, allowed: a complete height map")
        self.shape, self.dtype = data.shape, data.dtype
        return lambda start, stop: np.asarray(data[start:stop])
