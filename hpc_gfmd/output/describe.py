"""Coordinates, numbers and units in a result file for xarray, netCDF and ParaView."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .numbers import About, Attributes, axes, dataset_attributes, numbers

# An attribute of each group with all its texts, as JSON of fixed length. HDF5 keeps texts of any
# length, which other programs expect, where it has no checksums and where a flipped bit may crash
# it: we read them from nowhere else.
RECORD = "record"
SIGNS = (
    "lengths count away from the rigid surface: gap = displacement + initial gap >= 0, initial gap"
    " = -heights; pressures push"
)


def describe(file: Any, head: dict, surface: dict, steps: Mapping[str, dict], about: About) -> None:
    """Add to a laid-out file what other programs need: attributes, arrays over the loads, axes,
    units, links and VTKHDF; attributes alone without surface["n"]. One rank calls it.
    """
    set_attributes(file, {"/": head, "surface": surface, **steps})
    if "n" not in surface:
        return  # before the surface is made
    scales = coordinates(file, surface, numbers([*steps.values()]), about)
    groups = [file[name] for name in steps]
    for group in (file["surface"], *groups):
        for name in _fields(group):
            describe_dataset(group[name], surface, about, scales[1:])
            if group != file["surface"]:
                group[name].attrs["coordinates"] = "p"
        if _fields(group):
            group["x"], group["y"] = scales[1:]  # hard links
    for group, p in zip(groups, file["load"]):
        group["p"] = p
        describe_dataset(group["p"], surface, about)
        if "heights" in file["surface"]:
            group["heights"] = file["surface/heights"]
    if groups and min(surface["n"]) > 1:
        _views(file, groups, scales, surface, about)


def coordinates(
    group: Any, surface: Attributes, of_loads: Mapping[str, np.ndarray], about: About
) -> list:
    """Write load, x and y, which are returned, and numbers of the loads into a group."""
    unknown = np.full(len(next(iter(of_loads.values()), ())), np.nan)
    scales = {"load": of_loads.get("p", unknown), **axes(surface)}
    for name, values in scales.items():
        group.create_dataset(name, data=values).make_scale(name)
        describe_dataset(group[name], surface, about)
    for name, values in of_loads.items():
        stored = {"U": object, "b": np.int8}.get(values.dtype.kind, values.dtype)
        group[name] = values.astype(stored)
        describe_dataset(group[name], surface, about, [group["load"]])
        if values.dtype == bool:
            group[name].attrs["dtype"] = "bool"  # as xarray stores and reads it
    return [group[name] for name in scales]


def describe_dataset(
    dataset: Any, surface: Attributes, about: About, scales: Sequence = ()
) -> None:
    """Set `units` and `long_name` of a dataset, by its name, and attach dimension scales."""
    dataset.attrs.update(dataset_attributes(dataset.name.rpartition("/")[2], surface, about))
    for axis, scale in zip(dataset.dims, scales):
        axis.attach_scale(scale)


def _views(file: Any, steps: Sequence, scales: Sequence, surface: Attributes, about: About) -> None:
    """Add a group VTKHDF (ImageData) with views, not copies, of the fields of all steps. Times are
    the mean pressures if they rise, else 0, 1, 2, ...; Direction swaps VTK's first axis, our y,
    back.
    """
    import h5py

    names = sorted(set.intersection(*(set(_fields(step)) for step in steps)))
    if not names:
        return
    n_x, n_y = surface["n"]
    size_x, size_y = surface["physical_sizes"]
    vtk = file.create_group("VTKHDF")
    vtk.attrs.update(
        Type=np.bytes_("ImageData"),
        Version=[2, 0],
        WholeExtent=[0, n_y - 1, 0, n_x - 1, 0, 0],
        Origin=[0.0, 0.0, 0.0],
        Spacing=[size_y / n_y, size_x / n_x, 1.0],
        Direction=[0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0],
    )
    points = vtk.create_group("PointData")
    if len(steps) == 1:
        for name in names:
            points[name] = steps[0][name]  # a hard link
        return
    loads = file["load"][:]
    rising = np.all(np.diff(loads) > 0)  # as times in ParaView have to
    vtk["Steps/Values"] = loads if rising else np.arange(float(len(loads)))
    vtk["Steps"].attrs["NSteps"] = len(loads)
    for name in names:
        sources = [step[name] for step in steps]
        layout = h5py.VirtualLayout(
            (len(steps), n_x, n_y), np.result_type(*(source.dtype for source in sources))
        )
        for k, source in enumerate(sources):
            layout[k] = h5py.VirtualSource(".", source.name, source.shape, source.dtype)
        describe_dataset(points.create_virtual_dataset(name, layout), surface, about, scales)
        vtk[f"Steps/PointDataOffsets/{name}"] = np.arange(len(loads))
    for dataset in (vtk["Steps/Values"], *vtk["Steps/PointDataOffsets"].values()):
        dataset.dims[0].attach_scale(scales[0])


def _fields(group: Any) -> list[str]:
    return [name for name, item in group.items() if getattr(item, "ndim", 0) == 2]


def set_attributes(file: Any, groups: Mapping[str, dict]) -> None:
    """Write attributes of groups, dicts as JSON, None not at all; RECORD names them."""
    for name, attributes in groups.items():
        stored = {
            key: json.dumps(value) if isinstance(value, dict) else value
            for key, value in attributes.items()
            if value is not None
        }
        texts = {
            key: value if np.asarray(value).dtype.kind == "U" else None
            for key, value in stored.items()
        }
        file.require_group(name).attrs.update(stored | {RECORD: np.bytes_(json.dumps(texts))})
