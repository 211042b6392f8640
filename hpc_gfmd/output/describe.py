"""What makes a result file open in other programs: coordinates and units (xarray, netCDF), and the group that ParaView reads."""

import numpy as np

SIGNS = "lengths count away from the wall: gap = displacement + initial gap >= 0, initial gap = -heights; pressures push"
FIELDS = {  # what it is measured in, long_name
    "pressure": ("pressure", "contact pressure, 0 where the gap is open"),
    "gap": ("length", "gap between the deformed surface and the wall, displacement + initial gap"),
    "displacement": ("length", "displacement of the elastic surface away from the wall"),
    "heights": ("length", "heights of the rigid wall, peaks up, measured from the highest; initial gap = -heights"),
    "x": ("length", "position along the first axis"),
    "y": ("length", "position along the second axis"),
    "p": ("pressure", "mean pressure"),
    "load": ("pressure", "mean pressure of the load steps"),
}


def describe(file) -> None:
    """Add to a file that has all its groups and fields: root/x, y, load; steps/NNNN/x, y, p where there are fields; /VTKHDF."""
    surface, steps = file["surface"], {int(name): group for name, group in file.get("steps", {}).items()}
    if "n" not in surface.attrs:
        return  # before the surface is made
    heights, fields = surface.get("heights"), {}
    for group in [file, surface, *steps.values()]:
        fields[group.name] = [name for name, item in group.items() if getattr(item, "ndim", 0) == 2]
        if fields[group.name] or group == file:
            axes = _axes(group, surface)
            for name in fields[group.name]:
                _attach(group[name], axes)
    loads = np.array([steps[index].attrs.get("p", np.nan) for index in sorted(steps)])
    _dataset(file, "load", loads, surface).make_scale("load")
    for index in sorted(steps):
        group = steps[index]
        for name in fields[group.name]:
            if "p" not in group:
                _dataset(group, "p", group.attrs.get("p", np.nan), surface)
            _name(group[name], name, surface)
            group[name].attrs["coordinates"] = "p"
        if heights is not None:
            group["heights"] = heights
    if heights is not None:
        _name(heights, "heights", surface)
    shown = [*(fields[steps[min(steps)].name] if steps else ()), *(["heights"] if heights is not None else ())]
    if shown and steps and min(surface.attrs["n"]) > 1:
        _paraview(file, [steps[index] for index in sorted(steps)], shown, loads, surface.attrs)


def _axes(group, surface):
    """The scales x and y of a group."""
    scales = []
    for name, n, size in zip("xy", surface.attrs["n"], surface.attrs["physical_sizes"], strict=True):
        scales.append(_dataset(group, name, np.arange(n) * (size / n), surface))
        scales[-1].make_scale(name)
    return scales


def _dataset(group, name, values, surface):
    dataset = group.create_dataset(name, data=values)
    _name(dataset, name, surface)
    return dataset


def _name(dataset, name, surface):
    kind, long_name = FIELDS.get(name, ("", name))
    unit = {"length": surface.attrs.get("unit", "unit of physical_sizes"),
            "pressure": surface.attrs.get("pressure_unit", "unit of E_star")}
    dataset.attrs.update(units=unit.get(kind, "1"), long_name=long_name)


def _attach(dataset, scales):
    for axis, scale in zip(dataset.dims, scales, strict=True):
        axis.attach_scale(scale)


def _paraview(file, steps, names, loads, surface) -> None:
    """VTKHDF's ImageData, its arrays views of ours. VTK's first axis is the last of an array, our y: Direction turns it back."""
    import h5py

    (n_x, n_y), (size_x, size_y) = surface["n"], surface["physical_sizes"]
    vtk = file.create_group("VTKHDF")
    vtk.attrs.create("Type", b"ImageData", dtype=h5py.string_dtype("ascii", len(b"ImageData")))
    vtk.attrs.update(Version=[2, 0], WholeExtent=[0, n_y - 1, 0, n_x - 1, 0, 0], Origin=[0.0, 0.0, 0.0],
                     Spacing=[size_y / n_y, size_x / n_x, 1.0], Direction=[0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0])
    rising = np.all(np.diff(loads) > 0)  # as times in ParaView have to
    times = vtk.create_group("Steps")
    times.attrs["NSteps"] = len(steps)
    _attach(times.create_dataset("Values", data=loads if rising else np.arange(float(len(steps)))), [file["load"]])
    for name in names:
        layout = h5py.VirtualLayout((len(steps), n_x, n_y), max((step[name].dtype for step in steps), key=lambda kind: kind.itemsize))
        for k, step in enumerate(steps):
            layout[k] = h5py.VirtualSource(".", step[name].name, (n_x, n_y), step[name].dtype)
        _attach(vtk.require_group("PointData").create_virtual_dataset(name, layout), [file["load"], file["x"], file["y"]])
        _attach(times.require_group("PointDataOffsets").create_dataset(name, data=np.arange(len(steps))), [file["load"]])
