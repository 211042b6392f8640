"""Export of a result: its numbers as a table (pandas, CSV), its fields for Gwyddion."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..util.atomic import atomic_write
from ..util.errors import GfmdError, SceneError, reason
from .numbers import About, dataset_attributes, numbers, unit_of
from .result import Result

HEIGHTS = "heights"  # the same for all loads


def export(result: Result, kind: str, path: str | os.PathLike, about: About) -> Path:
    """Write a result in one of FORMATS; nothing is left if that fails."""
    path = Path(path)
    itself = result.path and result.path.exists() and path.exists() and path.samefile(result.path)
    if itself or not path.parent.is_dir() or (path.exists() and not path.is_file()):
        raise SceneError(
            f"-o: cannot write {path}: give a file in an existing folder, not the result itself"
        )
    if not result.steps:
        raise SceneError(f"{result.path}: no finished load step yet, nothing to export")
    try:
        with atomic_write(path) as tmp:
            FORMATS[kind](result, tmp, about)
    except OSError as error:
        raise GfmdError(f"writing {path}: {reason(error)}") from error
    return path


def frame(result: Result, about: About) -> Any:
    """Return a pandas table of numbers and texts, a row for each load, with attrs["units"]."""
    from pandas import DataFrame, Index

    table = DataFrame(numbers(result.steps), Index(result.indices, name="step"))
    table.attrs["units"] = {name: unit_of(name, result.surface, about) for name in table}
    return table


def to_csv(result: Result, path: Path, about: About) -> None:
    """Write a table of the numbers, with headings such as "gap_mean [m]"."""
    table = frame(result, about)
    headings = [
        name if unit in ("", "1") else f"{name} [{unit}]"
        for name, unit in table.attrs["units"].items()
    ]
    table.to_csv(path, header=headings, na_rep="nan")


def to_gwy(result: Result, path: Path, about: About) -> None:
    """Write a Gwyddion file with a channel for each load and common field, in m and Pa."""
    from gwyfile.objects import GwyContainer, GwyDataField, GwySIUnit

    surface = result.surface
    lengths = dict(zip(("xreal", "yreal"), map(float, surface["physical_sizes"])))

    def unit_of_field(name: str) -> Any:
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


FORMATS = {"csv": to_csv, "gwy": to_gwy}
INSTEAD = {  # of formats that have no writer here
    "vtkhdf": "ParaView with VTK 9.7 or later opens the result file itself; earlier versions open"
    " hpc_gfmd.load(FILE)[0].to_xarray().squeeze().transpose('y', 'x').to_netcdf('load.nc')",
    "netcdf": "xarray opens the result file itself, and hpc_gfmd.load(FILE).to_xarray()"
    ".to_netcdf('all.nc') writes netCDF",
    "npz": "numbers and fields of hpc_gfmd.load(FILE) are arrays, which np.savez writes",
    "x3p": "SurfaceTopography.Topography(solution.gap, solution.sizes, unit='m').to_x3p('gap.x3p')"
    " writes it",
}
SUFFIXES = {*FORMATS, *INSTEAD, "h5", "hdf5", "nc"}  # of files in known formats


def common_fields(result: Result) -> list[str]:
    """Return the names of the fields that all loads of a result, at least one, have."""
    return [name for name in result.fields[0] if all(name in fields for fields in result.fields)]


def _channels(result: Result) -> Iterator[tuple[int, str]]:
    """Yield (position of the load, name) of all `common_fields` of all loads, heights only once."""
    for k in range(len(result.steps)):
        yield from ((k, name) for name in common_fields(result) if k == 0 or name != HEIGHTS)
