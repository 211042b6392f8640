"""Height maps in NetCDF, as other programs write them."""

import h5py
from scipy.io import netcdf_file


def write(path, z, axes, unit="nm", along="m", classic=False, **attributes):
    """Write a height map.

    Parameters
    ----------
    path : str or Path
    z : array
        Heights.
    axes : dict of array
        Names and coordinates of the axes of z.
    unit, along : str
        Units of heights and of coordinates.
    classic : bool
        NetCDF 3 instead of 4.
    **attributes
        Of the heights.
    """
    attributes = {"units": unit} | attributes
    if classic:
        with netcdf_file(path, "w") as file:
            for name, values in axes.items():
                file.createDimension(name, len(values))
                file.createVariable(name, "f8", (name,))[:] = values
                file.variables[name].units = along
            heights = file.createVariable("h", z.dtype, tuple(axes))
            heights[:] = z
            for name, value in attributes.items():
                setattr(heights, name, value)
        return
    with h5py.File(path, "w") as file:
        heights = file.create_dataset("h", data=z)
        heights.attrs.update(attributes)
        for axis, (name, values) in enumerate(axes.items()):
            file[name] = values
            file[name].attrs["units"] = along
            file[name].make_scale(name)
            heights.dims[axis].attach_scale(file[name])
