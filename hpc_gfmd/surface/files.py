"""Height maps from files, peaks up, read a few rows at a time: .npy, HDF5, NetCDF, and what SurfaceTopography reads if installed."""

from pathlib import Path

import numpy as np

from .. import errors
from ..errors import SceneError
from ..parallel import h5_inside
from .heights import checked
from .packed import Packing

NPY = b"\x93NUMPY"
HDF5 = b"\x89HDF\r\n\x1a\n"  # how an HDF5 file begins, unless its user keeps something before it


class HeightMap:
    """shape (n_x, n_y) and rows(start, stop) -> float64 (stop - start, n_y). Raises SceneError for anything unreadable."""

    def __init__(self, spec):
        self.path = Path(spec.path)
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

        with h5py.File(self.path, "r", locking=False) as file:
            data = h5_inside.item(file, spec.dataset)
            if not isinstance(data, h5py.Dataset):
                names = []
                file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
                self._no_dataset(spec, names)
            self.shape, self.dtype = data.shape, data.dtype
            packing = Packing(data.attrs)
            band = data.chunks[0] * data.shape[1] * data.dtype.itemsize if data.chunks and data.ndim == 2 else 0
        # chunks that the next rows need as well are kept while the data set is open: unpacking a large one each time takes for ever
        file = h5py.File(self.path, "r", locking=False, rdcc_nbytes=max(2 * band, 2**20), rdcc_nslots=10007)
        data = h5_inside.item(file, spec.dataset)
        return lambda start, stop: packing.unpacked(data[start:stop])

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
