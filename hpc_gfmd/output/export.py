"""Export of a result to ParaView (VTKHDF), netCDF-4, NumPy arrays, a CSV table, Gwyddion, and X3P.

Fields are read a piece at a time if the format can be written so.
"""

import os
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..parallel.h5 import lay_out
from ..util.atomic import atomic_write
from ..util.errors import GfmdError, SceneError, reason
from ..util.libraries import surface_topography
from .describe import coordinates, describe_dataset
from .numbers import About, axes, dataset_attributes, numbers, unit_of
from .result import Result

HEIGHTS = "heights"  # the same for all loads


def export(result: Result, kind: str, path: str | os.PathLike | None, about: About) -> Path:
    """Write a result for another program. If that fails, no file is left.

    Parameters
    ----------
    result : Result
        In a file or in memory.
    kind : str
        One of FORMATS.
    path : path or None
        The file to write, which is replaced if it exists. None: the path of the result with the
        extension of the format, or contact.EXTENSION in the working folder for a result in memory.
    about : mapping
        {name: (meaning, unit)} of the numbers.

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    SceneError
        If `path` is the result itself, is not a file or has no folder, if the result has no
        finished load, or if the format cannot hold the result.
    GfmdError
        If the numbers of the result are damaged or writing fails.
    """
    write, extension = FORMATS[kind]
    path = Path(path or Path(result.path or "contact.h5").with_suffix(extension))
    itself = result.path and result.path.exists() and path.exists() and path.samefile(result.path)
    if itself or not path.parent.is_dir() or (path.exists() and not path.is_file()):
        raise SceneError(
            f"-o: found {path}, allowed: a file in a folder that exists, not the result itself"
        )
    if not result.steps:
        raise SceneError(f"{result.path}: no finished load step yet, nothing to export")
    try:
        with atomic_write(path) as tmp:
            write(result, tmp, about)
    except (OSError, ValueError) as error:
        raise GfmdError(f"writing {path}: {reason(error)}") from error
    return path


def to_vtkhdf(result: Result, path: Path, about: About) -> None:
    """Write the fields that all loads have as ImageData for ParaView.

    Arrays are (load, y, x), the order of VTK, so that all versions from 9.3 show every number in
    its place; a single load has (y, x). In result files they are (x, y), which versions below 9.7
    swap.

    Parameters
    ----------
    result : Result
        With at least one load.
    path : Path
        The file to write.
    about : mapping
        {name: (meaning, unit)} of the numbers.

    Raises
    ------
    SceneError
        If the loads have no field in common, or the grid has one point along an axis.
    """
    import h5py

    surface = result.surface
    n_x, n_y = surface["n"]
    fields = common_fields(result)
    if min(n_x, n_y) < 2:
        raise SceneError(
            f"vtkhdf: found {n_x} x {n_y} points, allowed: at least two along each axis"
        )
    if not fields:
        raise SceneError(
            "vtkhdf: found no field that all loads have, allowed: a result with output.fields"
        )
    size_x, size_y = surface["physical_sizes"]
    # HDF5 cannot create a file by the name of a descriptor, which atomic_write gives
    with open(path, "w+b") as stream, h5py.File(stream, "w") as file:
        image = file.create_group("VTKHDF")
        image.attrs.update(
            Type=np.bytes_("ImageData"),
            Version=[2, 0],
            WholeExtent=[0, n_x - 1, 0, n_y - 1, 0, 0],
            Origin=[0.0, 0.0, 0.0],
            Spacing=[size_x / n_x, size_y / n_y, 1.0],
            Direction=np.eye(3).ravel(),
        )
        loads = np.array([step["p"] for step in result.steps])
        for name, (_, dtype) in fields.items():
            stored_loads = len(loads) if name != HEIGHTS else 1
            leading = (stored_loads,) if len(loads) > 1 else ()  # one load: no axis for it
            values = image.create_dataset(f"PointData/{name}", (*leading, n_y, n_x), dtype)
            values.attrs.update(dataset_attributes(name, surface, about))
            for place, rows in _pieces(result, name):
                load = place[0] if len(place) == 2 else 0
                values[(*(load for _ in leading), slice(None), place[-1])] = rows.T
            if len(loads) > 1:
                is_constant = name == HEIGHTS
                offsets = np.zeros(len(loads), int) if is_constant else np.arange(len(loads))
                image[f"Steps/PointDataOffsets/{name}"] = offsets
        if len(loads) > 1:
            is_rising = np.all(np.diff(loads) > 0)  # as times in ParaView have to
            image["Steps/Values"] = loads if is_rising else np.arange(float(len(loads)))
            image["Steps"].attrs["NSteps"] = len(loads)


def to_netcdf(result: Result, path: Path, about: About) -> None:
    """Write netCDF-4 with a variable for each number and for each field that all loads have.

    Numbers have the dimension load, fields (load, x, y), and heights, which are the same for all
    loads, (x, y). Variables have the attributes `units` and `long_name`; single numbers and texts
    of the head of the result become attributes of the file.

    Parameters
    ----------
    result : Result
        With at least one load.
    path : Path
        The file to write.
    about : mapping
        {name: (meaning, unit)} of the numbers.

    Raises
    ------
    OSError
        If the file cannot be written.
    GfmdError
        If stored fields of the result are damaged.
    """
    import h5py

    surface = result.surface
    fields = common_fields(result)

    def described(file: Any) -> None:
        """Add attributes, scales and numbers to the open file."""
        file.attrs.update(result.facts)
        scales = coordinates(file, surface, numbers(result.steps), about)
        for name in fields:
            describe_dataset(file[name], surface, about, scales[name == HEIGHTS :])

    lay_out(path, fields, described)
    with open(path, "r+b") as stream, h5py.File(stream, "r+") as file:
        for name in fields:
            for place, rows in _pieces(result, name):
                file[name][place] = rows


def to_npz(result: Result, path: Path, about: About) -> None:
    """Write a .npz archive with numbers over the loads, coordinates and fields.

    Its arrays are the numbers (load), x, y, heights (x, y), and the other fields (load, x, y).
    Fields that some load lacks are left out.

    Parameters
    ----------
    result, path
        As for `to_netcdf`.
    about : mapping
        Not used: the format has no place for units and meanings.
    """
    with zipfile.ZipFile(path, "w") as archive:
        for name, values in (axes(result.surface) | numbers(result.steps)).items():
            with archive.open(f"{name}.npy", "w") as file:
                np.lib.format.write_array(file, values)
        for name, (shape, dtype) in common_fields(result).items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                header = {"descr": dtype.str, "fortran_order": False, "shape": shape}
                np.lib.format.write_array_header_2_0(file, header)
                for _, rows in _pieces(result, name):
                    file.write(np.ascontiguousarray(rows, dtype).tobytes())


def frame(result: Result, about: About) -> Any:
    """Return a pandas table with a row for each load step and a column for each number.

    Parameters
    ----------
    result : Result
        In a file or in memory.
    about : mapping
        {name: (meaning, unit)} of the numbers.

    Returns
    -------
    pandas.DataFrame
        The index "step" holds the numbers of the loads, from 0; `attrs["units"]` holds
        {column: unit}. Texts, such as the status, are columns, too.
    """
    from pandas import DataFrame, Index

    table = DataFrame(numbers(result.steps), Index(result.indices, name="step"))
    table.attrs["units"] = {name: unit_of(name, result.surface, about) for name in table}
    return table


def to_csv(result: Result, path: Path, about: About) -> None:
    """Write a CSV table with one line per load step and no fields.

    Headings are such as "gap_mean [m]", without brackets if the unit is 1 or unknown.

    Parameters
    ----------
    result, path, about
        As for `to_netcdf`.
    """
    table = frame(result, about)
    headings = [
        name if unit in ("", "1") else f"{name} [{unit}]"
        for name, unit in table.attrs["units"].items()
    ]
    table.to_csv(path, header=headings, na_rep="nan")


def to_gwy(result: Result, path: Path, about: About) -> None:
    """Write a Gwyddion file with one channel for each load and each field that all loads have.

    Heights, which are the same for all loads, are one channel. Only m and Pa are written as units.

    Parameters
    ----------
    result : Result
        With at least one load.
    path : Path
        The file to write.
    about : mapping
        Not used: the format has no place for meanings.
    """
    from gwyfile.objects import GwyContainer, GwyDataField, GwySIUnit

    surface = result.surface
    lengths = dict(zip(("xreal", "yreal"), map(float, surface["physical_sizes"])))

    def unit_of_field(name: str) -> Any:
        """Return the unit of a field as a GwySIUnit, without name unless it is m or Pa."""
        unit = dataset_attributes(name, surface, {})["units"]
        return GwySIUnit(unitstr=unit if unit in ("m", "Pa") else "")

    content = GwyContainer()
    for number, (k, name) in enumerate(_channels(result)):
        values = np.asarray(result.fields[k][name].read(), float)
        content[f"/{number}/data/title"] = f"{name}, load {result.indices[k]}"
        content[f"/{number}/data"] = GwyDataField(
            values.T.copy(),  # rows along x
            si_unit_xy=unit_of_field("x"),
            si_unit_z=unit_of_field(name),
            **lengths,
        )
    content.tofile(os.fspath(path))


def to_x3p(result: Result, path: Path, about: About) -> None:
    """Write a result with a single channel, as `to_gwy` counts them, as X3P.

    The channel is the only field of a single load, or the heights of any number of loads. It must
    be a length in metres.

    Parameters
    ----------
    result, path, about
        As for `to_gwy`.

    Raises
    ------
    SceneError
        If there is not exactly one channel, or it is no length in metres.
    """
    channels = list(_channels(result))
    surface = result.surface
    names = [name for _, name in channels]
    lengths = {*names} <= {"gap", "displacement", "plastic", HEIGHTS}
    if len(channels) != 1 or not lengths or surface.get("unit") != "m":
        raise SceneError(
            f"x3p: found {', '.join(names) or 'no field'} of"
            f" {len(result.steps)} loads in unit {surface.get('unit', '')!r}, allowed: one field"
            " that is a length, of one load, where lengths have units (x3p holds metres)"
        )
    ((k, name),) = channels
    values = result.fields[k][name].read()
    sizes = tuple(surface["physical_sizes"])
    with open(path, "wb") as file:
        heights = np.asarray(values, dtype=float)
        surface_topography().Topography(heights, sizes, unit="m").to_x3p(file)


FORMATS = {  # and the extension of each
    "vtkhdf": (to_vtkhdf, ".vtkhdf"),
    "netcdf": (to_netcdf, ".nc"),
    "npz": (to_npz, ".npz"),
    "csv": (to_csv, ".csv"),
    "gwy": (to_gwy, ".gwy"),
    "x3p": (to_x3p, ".x3p"),
}


def common_fields(result: Result) -> dict[str, tuple[tuple[int, ...], np.dtype]]:
    """Return {name: (shape, dtype)} of the fields that all loads of a result have.

    The result needs at least one load. The shape is (loads, n_x, n_y), and (n_x, n_y) for heights,
    which are the same for all loads. The dtype is one that holds the numbers of every load.
    """
    names = [name for name in result.fields[0] if all(name in fields for fields in result.fields)]
    shape = len(result.steps), *result.surface["n"]
    types = {name: [fields[name].dtype for fields in result.fields] for name in names}
    return {name: (shape[name == HEIGHTS :], np.result_type(*types[name])) for name in names}


def _channels(result: Result) -> Iterator[tuple[int, str]]:
    """Yield (position of the load, name) of all `common_fields` of all loads, heights only once."""
    for k in range(len(result.steps)):
        yield from ((k, name) for name in common_fields(result) if k == 0 or name != HEIGHTS)


def _pieces(result: Result, name: str) -> Iterator[tuple[tuple, np.ndarray]]:
    """Yield (index, rows) for the pieces of a field, load by load, and in each load in order.

    index is the place of the rows in an array over all loads: (load, rows as a slice), or (rows as
    a slice,) for heights. The rows are only a piece in memory at a time. Raises GfmdError if stored
    numbers are damaged.
    """
    for k, fields in enumerate(result.fields[: 1 if name == HEIGHTS else None]):
        for start, rows in fields[name].pieces():
            yield (k, slice(start, start + len(rows)))[name == HEIGHTS :], rows
