"""What makes a result file open in other programs: coordinates and units (xarray, netCDF), and the
group that ParaView reads."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

Attributes = Mapping[str, Any]

SIGNS = (
    "lengths count away from the rigid surface: gap = displacement + initial gap >= 0, initial gap"
    " = -heights; pressures push"
)
# attribute of the surface; or else
LENGTH, PRESSURE = ("unit", "unit of physical_sizes"), ("pressure_unit", "unit of E_star")
FIELDS = {  # what it is measured in, long_name
    "pressure": (PRESSURE, "contact pressure, 0 where the gap is open"),
    "gap": (
        LENGTH,
        "gap between the deformed surface and the rigid one, displacement + initial gap",
    ),
    "displacement": (LENGTH, "displacement of the elastic surface away from the rigid surface"),
    "plastic": (LENGTH, "depth of the dents where the pressure is the hardness"),
    "heights": (
        LENGTH,
        "heights of the rigid surface, peaks up, measured from the highest; initial gap = -heights",
    ),
    "x": (LENGTH, "position along the first axis"),
    "y": (LENGTH, "position along the second axis"),
    "p": (PRESSURE, "mean pressure"),
    "loads": (PRESSURE, "mean pressure of the load steps"),
}


def describe(file: Any) -> None:
    """Add to a file that has all its groups and fields: x, y, loads; steps/NNNN/x, y, p beside
    fields; VTKHDF, views of the fields."""
    surface, steps = (
        file["surface"],
        [file["steps"][name] for name in sorted(file.get("steps", ()), key=int)],
    )
    about = surface.attrs
    if "n" not in about:
        return  # before the surface is made
    scales = coordinates(file, about, [step.attrs.get("p", np.nan) for step in steps])
    for group in (surface, *steps):
        for name in _fields(group):
            name_it(group[name], about, scales[1:])
            if group != surface:
                group[name].attrs["coordinates"] = "p"
        if _fields(group):
            group["x"], group["y"] = scales[1:]  # hard links
    for step, p in zip(steps, file["loads"]):
        step["p"] = p
        name_it(step["p"], about)
        if "heights" in surface:
            step["heights"] = surface["heights"]
    if steps and min(about["n"]) > 1:
        _views(file, steps, scales, about)


def coordinates(group: Any, surface: Attributes, loads: ArrayLike) -> list:
    """The dimension scales loads, x and y of a group."""
    values = {"loads": np.array(loads)}
    values |= {
        name: np.arange(n) * (size / n)
        for name, n, size in zip("xy", surface["n"], surface["physical_sizes"], strict=True)
    }
    for name, numbers in values.items():
        group.create_dataset(name, data=numbers).make_scale(name)
        name_it(group[name], surface)
    return [group[name] for name in values]


def name_it(dataset: Any, surface: Attributes, scales: Sequence = ()) -> None:
    """Units, long_name and axes of a dataset; surface: attributes."""
    name = dataset.name.rpartition("/")[2]
    unit, long_name = FIELDS.get(name, (("", "1"), name))
    dataset.attrs.update(units=surface.get(*unit), long_name=long_name)
    for axis, scale in zip(dataset.dims, scales):
        axis.attach_scale(scale)


def image(
    file: Any,
    surface: Attributes,
    loads: np.ndarray,
    names: Iterable[str],
    create: Callable[[Any, str], Any],
) -> Any:
    """VTKHDF's ImageData with arrays of these names, made by create(group, name): (loads, x, y), or
    (x, y) of one load.

    VTK's first axis is the last one of an array, our y; Direction turns it back, so that x is x.
    """
    (n_x, n_y), (size_x, size_y) = surface["n"], surface["physical_sizes"]
    vtk = file.create_group("VTKHDF")
    vtk.attrs.update(
        Type=np.bytes_("ImageData"),
        Version=[2, 0],
        WholeExtent=[0, n_y - 1, 0, n_x - 1, 0, 0],
        Origin=[0.0, 0.0, 0.0],
        Spacing=[size_y / n_y, size_x / n_x, 1.0],
        Direction=[0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0],
    )
    for name in names:
        create(vtk.require_group("PointData"), name)
    if len(loads) > 1:
        rising = np.all(np.diff(loads) > 0)  # as times in ParaView have to
        vtk["Steps/Values"] = np.array(loads) if rising else np.arange(float(len(loads)))
        vtk["Steps"].attrs["NSteps"] = len(loads)
        for name in names:
            vtk[f"Steps/PointDataOffsets/{name}"] = np.arange(len(loads)) % len(
                vtk["PointData"][name]
            )
    return vtk


def _views(file: Any, steps: Sequence, scales: Sequence, surface: Attributes) -> None:
    import h5py

    def view(group: Any, name: str) -> None:
        sources = [step[name] for step in steps]
        if len(steps) == 1:
            group[name] = sources[0]  # a hard link
            return
        layout = h5py.VirtualLayout(
            (len(steps), *surface["n"]), np.result_type(*(one.dtype for one in sources))
        )
        for k, one in enumerate(sources):
            layout[k] = h5py.VirtualSource(".", one.name, one.shape, one.dtype)
        name_it(group.create_virtual_dataset(name, layout), surface, scales)

    if names := sorted(set.intersection(*(set(_fields(step)) for step in steps))):
        vtk = image(file, surface, file["loads"][:], names, view)
        if times := vtk.get("Steps"):
            for dataset in (times["Values"], *times["PointDataOffsets"].values()):
                dataset.dims[0].attach_scale(scales[0])


def _fields(group: Any) -> list[str]:
    return [name for name, item in group.items() if getattr(item, "ndim", 0) == 2]
