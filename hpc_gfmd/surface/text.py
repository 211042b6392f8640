"""Heights as text: matrices, or points (x, y, z) of three columns, bare or with what an instrument
writes before them."""

import re
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from . import instruments
from .metadata import UNEVEN, Map, Metadata

LOOKED_AT = 200  # lines
MARKS = (None, "\t", ";", ",")  # between numbers; None: white space
MISSING = ("", "NA", "n/a", "BAD", "Bad", "bad", *(mark * k for mark in "*-" for k in range(1, 6)))


@dataclass(frozen=True)
class Layout:
    """Of a text: lines before the numbers, what is between them, their decimal mark, how many there
    are in a line, and in a line before them at most; units of x, y, z that the last line before
    them names in brackets; whether each line ends with what is between numbers."""

    skip: int
    mark: str | None
    decimal: str
    columns: int
    before: int
    units: tuple[str, ...]
    ended: bool


def read(path: str | Path, spec: Any) -> Map:
    """Read a text: (heights (n_x, n_y), nan where they are missing; Metadata); spec: scene.File.

    A bare matrix is the array that numpy.savetxt wrote: the first index, the line, is x. With a
    header that tells sizes or units it is an instrument's: each line is a scan along x.
    """
    with open(path, encoding="utf-8-sig", errors="replace") as file:
        layout = layout_of(list(islice(file, (spec.skip_lines or 0) + LOOKED_AT)), spec)
    if layout is None or layout.columns < 3:
        return instruments.read(path, spec)
    # other readers leave out units of x, y and z
    header = layout.skip and spec.skip_lines is None and len(layout.units) != 3
    if header and (found := instruments.recognised(path, spec)):
        return found
    table = _table(path, layout, spec)
    if table.shape[1] == 3:
        return _on_grid(table, layout.units)
    return table.to_numpy(), Metadata()


def layout_of(lines: list[str], spec: Any) -> Layout | None:
    """Find the layout with the most columns that lines have to their end; None: there are no
    numbers.

    Raises ValueError where some of the lines before them look like numbers, too, and where only the
    last line does not.
    """
    best = _best(lines, spec)
    if best is None and (cut := _best(lines[:-1], spec)) and cut.columns > 2 and not cut.skip:
        raise ValueError(f"line {len(lines)} is not like those before it: is the file complete?")
    if best and spec.skip_lines is None:
        if best.before > best.columns:
            raise ValueError(
                f"line {best.skip + 1} is shorter than those before it: is the file complete?"
            )
        if best.before == best.columns:
            raise ValueError(
                f"line {best.skip} is not like those before and after it; surface.missing names"
                " what stands for missing points, surface.skip_lines how long the header is"
            )
    return best


def _best(lines: list[str], spec: Any) -> Layout | None:
    decimals = (spec.decimal,) if spec.decimal else (".", ",")
    found = [
        layout
        for decimal in decimals
        for mark in MARKS
        if mark != decimal and (layout := _layout(lines, spec, mark, decimal))
    ]
    return max(found, key=lambda layout: (layout.columns, -layout.skip), default=None)


def _layout(lines: list[str], spec: Any, mark: str | None, decimal: str) -> Layout | None:
    counts = [_columns(line, mark, decimal, spec.missing) for line in lines]
    filled = [k for k, line in enumerate(lines) if line.strip() and not line.startswith("#")]
    columns = counts[filled[-1]] if filled else 0
    if not columns:
        return None
    first = max((k + 1 for k in filled if counts[k] != columns), default=filled[0])
    first = first if spec.skip_lines is None else spec.skip_lines
    units = re.findall(r"[\[(]\s*([^\W\d_]+)\s*[\])]", "".join(lines[:first][-1:]))
    ended = all(lines[k].rstrip("\r\n ").endswith(mark or "\n") for k in filled if k >= first)
    before = max(counts[:first], default=0)
    return Layout(first, mark, decimal, columns, before, tuple(units), ended)


def _columns(line: str, mark: str | None, decimal: str, missing: tuple[str, ...]) -> int:
    """Count the numbers of a line; 0 where it holds anything else, or no number and nothing of what
    the scene calls missing."""
    fields = [field.strip() for field in line.partition("#")[0].strip("\n\r").split(mark)]
    known = [field for field in fields if field in missing or field not in MISSING]
    try:
        numbers = [field in missing or float(field.replace(decimal, ".")) for field in known]
    except ValueError:
        return 0
    return len(fields) if numbers else 0


def _table(path: str | Path, layout: Layout, spec: Any) -> Any:
    from pandas import read_csv  # slow to import

    table = read_csv(
        path,
        sep=layout.mark or r"\s+",
        decimal=layout.decimal,
        skiprows=layout.skip,
        header=None,
        na_values=[*MISSING, *spec.missing],
        skipinitialspace=True,
        dtype=float,
        comment="#",
        encoding="utf-8-sig",
        encoding_errors="replace",
    )
    empty_column = layout.ended and table.iloc[:, -1].isna().all()
    return table.iloc[:, :-1] if empty_column else table


def _on_grid(points: Any, units: tuple[str, ...]) -> Map:
    """Put columns x, y, z on a grid: (heights, Metadata); points of the grid that are not among
    them have no height. Raises ValueError if they are on none."""
    if points.duplicated([0, 1]).any():
        raise ValueError("it has a point twice")
    table = points.pivot(index=0, columns=1, values=2)
    steps = [np.diff(axis) for axis in table.axes]
    if not all(step.size and np.ptp(step) <= UNEVEN * step.mean() for step in steps):
        raise ValueError("its points are not those of a regular grid")
    sizes = tuple(float(step.mean() * (step.size + 1)) for step in steps)
    sizes_unit, other, unit = units if len(units) == 3 else (None, None, None)
    if sizes_unit != other:
        raise ValueError(f"its axes are in different units, {sizes_unit} and {other}")
    return table.to_numpy(), Metadata(sizes, sizes_unit, unit)
