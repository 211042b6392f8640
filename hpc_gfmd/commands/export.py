"""`hpc-gfmd export`: a result for ParaView (VTKHDF), as netCDF-4, as NumPy arrays, and the numbers
of its load steps as a table."""

import csv
import os
import zipfile
from argparse import ArgumentParser, Namespace
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..contact import all_numbers, unit_of
from ..output.describe import coordinates, image, name_it
from ..output.read import Result, read_result
from ..parallel.guard import one_line
from ..util.atomic import atomic_write
from ..util.errors import GfmdError, SceneError
from ..util.quantities import in_units

HEIGHTS = "heights"  # the same for all loads


def add_parser(subparsers: Any) -> ArgumentParser:
    parser = subparsers.add_parser(
        "export",
        help="a result for other programs",
        description=(
            "Write a result for ParaView (vtkhdf), as netCDF-4, as NumPy arrays (npz), or its"
            " numbers as a table (csv). ParaView and xarray also open the result itself."
        ),
    )
    parser.add_argument("file", metavar="OUT.h5", help="result file")
    parser.add_argument("--to", required=True, choices=FORMATS, help="what to write")
    parser.add_argument("-o", "--output", metavar="FILE", help="where (default: beside the result)")
    return parser


def main(args: Namespace) -> int:
    """Write it and print its name; raises SceneError if the result cannot be read or the file
    cannot go there."""
    result = read_result(args.file)
    print(export(result, args.to, args.output))
    for note in result.notes:
        print(f"note: {note}")
    if result.folder is not None:
        print(f"! the run is {result.status}: only its finished load steps are exported")
    return 0


def export(result: Result, kind: str, path: str | os.PathLike | None = None) -> Path:
    """Write the result of a file as one of FORMATS; path: where (default: beside it). Returns the
    path; all of it is there, or nothing.

    Raises SceneError if it cannot go there, GfmdError if the numbers of the result are damaged or
    writing fails.
    """
    assert result.path is not None
    path = Path(path or result.path.with_suffix(f".{EXTENSIONS[kind]}"))
    itself = path.exists() and result.path.exists() and path.samefile(result.path)
    if itself or not path.parent.is_dir() or (path.exists() and not path.is_file()):
        raise SceneError(
            f"-o: found {path}, allowed: a file in a folder that exists, not the result itself"
        )
    if not result.steps:
        raise SceneError(f"{result.path}: no finished load step yet, nothing to export")
    try:
        with atomic_write(path) as tmp:
            FORMATS[kind](result, tmp)
    except (OSError, ValueError) as error:
        raise GfmdError(f"writing {path}: {one_line(error)}") from error
    return path


def to_vtkhdf(result: Result, path: Path) -> None:
    """The VTKHDF group of the result file with numbers of its own."""
    import h5py

    if not _fields(result) or min(result.surface["n"]) < 2:
        raise SceneError(
            f"{result.path}: ParaView shows fields on two axes, allowed: a result with"
            " output.fields"
        )
    fields, loads = _fields(result), len(result.steps)

    def shape(name: str) -> tuple[int, ...]:  # of a single load without a first axis, as its views
        return (1 if name == HEIGHTS else loads, *result.surface["n"])[loads == 1 :]

    with open(path, "w+b") as stream, h5py.File(stream, "w") as file:
        image(
            file,
            result.surface,
            _numbers(result)["p"],
            fields,
            lambda group, name: _fill(
                group.create_dataset(name, shape(name), fields[name]), result, name
            ),
        )


def to_netcdf(result: Result, path: Path) -> None:
    """Dimensions loads, x, y; every number of the load steps and every field as a variable with its
    unit and meaning."""
    import h5py

    with open(path, "w+b") as stream, h5py.File(stream, "w") as file:
        file.attrs.update(
            {
                name: value
                for name, value in result.head.items()
                if isinstance(value, str | int | float)
            }
        )
        numbers = _numbers(result)
        scales = coordinates(file, result.surface, numbers["p"])
        for name, values in numbers.items():
            file[name] = values.astype(object) if values.dtype.kind == "U" else values
            name_it(file[name], result.surface, scales)
            meaning, unit = all_numbers().get(name, (name, ""))
            file[name].attrs.update(units=in_units(unit, result.surface) or unit, long_name=meaning)
        for name, dtype in _fields(result).items():
            file.create_dataset(name, _shape(result, name), dtype)
            name_it(file[name], result.surface, scales[name == HEIGHTS :])
            _fill(file[name], result, name)


def to_npz(result: Result, path: Path) -> None:
    """Arrays over the load steps by their names, x, y, heights (x, y) and the other fields (loads,
    x, y); read a piece at a time."""
    axes = {
        name: np.arange(n) * (size / n)
        for name, n, size in zip("xy", result.surface["n"], result.surface["physical_sizes"])
    }
    with zipfile.ZipFile(path, "w") as archive:
        for name, values in (axes | _numbers(result)).items():
            with archive.open(f"{name}.npy", "w") as file:
                np.lib.format.write_array(file, values)
        for name, dtype in _fields(result).items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                header = {"descr": dtype.str, "fortran_order": False, "shape": _shape(result, name)}
                np.lib.format.write_array_header_2_0(file, header)
                for _, _, rows in _pieces(result, name):
                    file.write(np.ascontiguousarray(rows, dtype).tobytes())


def to_csv(result: Result, path: Path) -> None:
    """One line per load step, no fields; headings such as "gap_mean [m]" where a unit is known."""
    units = {name: unit_of(name, result.surface) for name in _numbers(result)}
    numbers = {"step": np.array(result.indices)} | {
        f"{name} [{units[name]}]" if units[name] not in ("", "1") else name: values
        for name, values in _numbers(result).items()
    }
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(numbers)
        writer.writerows(zip(*(values.tolist() for values in numbers.values())))


FORMATS = {"vtkhdf": to_vtkhdf, "netcdf": to_netcdf, "npz": to_npz, "csv": to_csv}
EXTENSIONS = {"vtkhdf": "vtkhdf", "netcdf": "nc", "npz": "npz", "csv": "csv"}


def _numbers(result: Result) -> dict[str, np.ndarray]:
    """Everything that steps say in one number or text, over the steps; nan or "" where one does not
    say it. What has no name that the program gives stays out: it may be a path."""
    found = {}
    for name in dict.fromkeys(
        name
        for step in result.steps
        for name, value in step.items()
        if name.isidentifier() and not isinstance(value, list)
    ):
        values = [step.get(name) for step in result.steps]
        missing = "" if any(isinstance(value, str) for value in values) else np.nan
        found[name] = np.array([missing if value is None else value for value in values])
    return found


def _fields(result: Result) -> dict[str, np.dtype]:
    """Fields that all steps have, and the widest type of each."""
    names = [name for name in result.fields[0] if all(name in fields for fields in result.fields)]
    return {
        name: np.result_type(*(fields[name].dtype for fields in result.fields)) for name in names
    }


def _shape(result: Result, name: str) -> tuple[int, ...]:
    return (len(result.steps), *result.surface["n"])[name == HEIGHTS :]


def _pieces(result: Result, name: str) -> Iterator[tuple[int, int, np.ndarray]]:
    """(step, first row, rows) of a field, a piece of memory at a time, heights once; raises
    GfmdError where it is damaged."""
    for k, fields in enumerate(result.fields[: 1 if name == HEIGHTS else None]):
        for start, rows in fields[name].pieces():
            yield k, start, rows


def _fill(dataset: Any, result: Result, name: str) -> None:
    for k, start, rows in _pieces(result, name):
        at = slice(start, start + len(rows))
        dataset[at if dataset.ndim == 2 else (k, at)] = rows
