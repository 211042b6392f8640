"""A result for other programs: ParaView (VTKHDF), netCDF-4, NumPy arrays, a table, Gwyddion, and
X3P. Fields are read a piece at a time where the format lets them be written so."""

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
from .describe import coordinates, name_it
from .numbers import About, axes, numbers, said_of, unit_of
from .result import Result

HEIGHTS = "heights"  # the same for all loads


def export(result: Result, kind: str, path: str | os.PathLike | None, about: About) -> Path:
    """Write a result for another program; the whole file is there, or nothing.

    Parameters
    ----------
    result : Result
    kind : str
        One of FORMATS.
    path : path or None
        Where to; None: beside the file of the result.
    about : mapping
        Meaning and unit of the numbers.

    Returns
    -------
    Path
        That was written.

    Raises
    ------
    SceneError
        If it cannot go there or into this format.
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
    """Write the fields as ImageData for ParaView.

    Arrays are (load, y, x), the order of VTK, so that all versions from 9.3 put every number at its
    place. In result files they are (x, y), which versions below 9.7 exchange.

    Parameters
    ----------
    result : Result
        A result with fields.
    path : Path
        The file to be written.
    about : mapping
        Meaning and unit of the numbers.
    """
    import h5py

    surface = result.surface
    n_x, n_y = surface["n"]
    fields = common_fields(result)
    if not fields or min(n_x, n_y) < 2:
        raise SceneError(
            f"{result.path}: ParaView shows fields on two axes, allowed: a result with"
            " output.fields"
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
            values.attrs.update(said_of(name, surface, about))
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
    """Write dimensions load, x, y; every number of the load steps and every field as a variable
    with its unit and meaning.

    Parameters
    ----------
    result, path, about
        As for `to_vtkhdf`; fields are not needed.
    """
    import h5py

    surface = result.surface
    fields = common_fields(result)

    def described(file: Any) -> None:
        file.attrs.update(result.facts)
        scales = coordinates(file, surface, numbers(result.steps), about)
        for name in fields:
            name_it(file[name], surface, about, scales[name == HEIGHTS :])

    lay_out(path, fields, described)
    with open(path, "r+b") as stream, h5py.File(stream, "r+") as file:
        for name in fields:
            for place, rows in _pieces(result, name):
                file[name][place] = rows


def to_npz(result: Result, path: Path, about: About) -> None:
    """Write arrays over the load steps by their names, x, y, heights (x, y) and the other fields
    (load, x, y).

    Parameters
    ----------
    result, path, about
        As for `to_netcdf`.
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
    """Return a pandas table: a row for each load step, a column for each number.

    Parameters
    ----------
    result : Result
    about : mapping
        Meaning and unit of the numbers.

    Returns
    -------
    pandas.DataFrame
        `attrs["units"]` holds the unit of each column.
    """
    from pandas import DataFrame, Index

    table = DataFrame(numbers(result.steps), Index(result.indices, name="step"))
    table.attrs["units"] = {name: unit_of(name, result.surface, about) for name in table}
    return table


def to_csv(result: Result, path: Path, about: About) -> None:
    """Write one line per load step, no fields; headings such as "gap_mean [m]" where a unit is
    known.

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
    """Write a channel of Gwyddion for each field of each load.

    Parameters
    ----------
    result : Result
        A result with fields.
    path : Path
        The file to be written.
    about : dict
        Meaning and unit of all numbers, which this format does not need.
    """
    from gwyfile.objects import GwyContainer, GwyDataField, GwySIUnit

    surface = result.surface
    lengths = dict(zip(("xreal", "yreal"), map(float, surface["physical_sizes"])))

    def unit_of_field(name: str) -> Any:
        unit = said_of(name, surface, {})["units"]
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
    """Write one field of one load, a length, by SurfaceTopography.

    Parameters
    ----------
    result, path, about
        As for `to_gwy`.
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
    """Return the fields that all steps have: the shape over them, heights once, and the widest type
    of each."""
    names = [name for name in result.fields[0] if all(name in fields for fields in result.fields)]
    shape = len(result.steps), *result.surface["n"]
    types = {name: [fields[name].dtype for fields in result.fields] for name in names}
    return {name: (shape[name == HEIGHTS :], np.result_type(*types[name])) for name in names}


def _channels(result: Result) -> Iterator[tuple[int, str]]:
    """Yield (step, field) of all of them, heights once."""
    for k in range(len(result.steps)):
        yield from ((k, name) for name in common_fields(result) if k == 0 or name != HEIGHTS)


def _pieces(result: Result, name: str) -> Iterator[tuple[tuple, np.ndarray]]:
    """Yield (place in an array over the loads, rows) of a field, a piece of memory at a time.
    Raises GfmdError where it is damaged."""
    for k, fields in enumerate(result.fields[: 1 if name == HEIGHTS else None]):
        for start, rows in fields[name].pieces():
            yield (k, slice(start, start + len(rows)))[name == HEIGHTS :], rows
