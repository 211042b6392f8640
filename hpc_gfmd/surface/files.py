"""Height maps from files, peaks up, read a few rows at a time: .npy, HDF5, NetCDF, and what SurfaceTopography reads if installed."""

from pathlib import Path

import numpy as np

from ..errors import SceneError


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
            reason = " ".join(str(error).split())[:200]
            raise SceneError(f"surface.path: {self.path} cannot be read as {spec.format}: {reason}") from None
        shape = getattr(self, "shape", ())
        if len(shape) != 2 or 0 in shape:
            raise SceneError(f"surface.path: found an array of shape {tuple(shape)} in {self.path}, allowed: two axes, not empty")
        if self.dtype.kind not in "fiu":
            raise SceneError(f"surface.path: found values of type {self.dtype} in {self.path}, allowed: real numbers")

    def rows(self, start, stop):
        """Rows start <= i < stop as float64. Raises SceneError if a height is not finite."""
        try:
            z = np.asarray(self.read(start, stop), dtype=np.float64)
        except Exception as error:
            raise SceneError(f"surface.path: reading {self.path} failed: {' '.join(str(error).split())[:200]}") from None
        if not np.isfinite(z).all():
            i, j = np.argwhere(~np.isfinite(z))[0]
            raise SceneError(f"surface.path: found {z[i, j]} at ({start + i}, {j}) in {self.path}, allowed: finite heights")
        return z

    def _npy(self, spec):
        data = np.load(self.path, mmap_mode="r", allow_pickle=False)
        if not isinstance(data, np.ndarray):
            raise ValueError("not a single array")
        self.shape, self.dtype = data.shape, data.dtype
        return lambda start, stop: data[start:stop]

    def _hdf5(self, spec):
        import h5py

        with h5py.File(self.path, "r", locking=False) as file:
            data = file.get(spec.dataset)
            if not isinstance(data, h5py.Dataset):
                names = []
                file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
                raise SceneError(f"surface.dataset: found {spec.dataset!r}, allowed in {self.path}: "
                                 f"{', '.join(names[:10]) or 'nothing, there is no data set'}")
            self.shape, self.dtype = data.shape, data.dtype

        def read(start, stop):
            with h5py.File(self.path, "r", locking=False) as file:
                return file[spec.dataset][start:stop]

        return read

    def _netcdf(self, spec):
        if self.path.read_bytes()[:4] == b"\x89HDF":
            return self._hdf5(spec)
        from scipy.io import netcdf_file

        file = netcdf_file(self.path, "r", mmap=True)
        names = [name for name, v in file.variables.items() if len(v.shape) == 2]
        if spec.dataset in names:
            name = spec.dataset
        elif len(names) == 1:
            name = names[0]
        else:
            raise SceneError(f"surface.dataset: found {spec.dataset!r}, allowed in {self.path}: {', '.join(names)}")
        data = file.variables[name].data
        self.shape, self.dtype = data.shape, data.dtype
        return lambda start, stop: np.array(data[start:stop])

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
