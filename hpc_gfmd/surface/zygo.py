"""Zygo's text of pixels and heights; its header has the number of points and their distance."""

from collections.abc import Iterator
from io import TextIOWrapper
from itertools import takewhile
from typing import Any

import numpy as np

from .contents import Contents
from .coordinates import points_on_grid
from .metadata import Map, Metadata

END = "#"  # the line after the header, and after the points
POINTS_LINE = 3  # origin and points along x and y
PITCH_LINE = 7
PITCH = 6  # place of the distance of the points in its line, in m; 0 if it is not known


def read(contents: Contents, spec: Any) -> Map:
    """Read heights in um, nan where the file says "No Data"; spec: a scene.File.

    Raises ValueError if the points are not those that the header announces.
    """
    with contents.open() as stream, TextIOWrapper(stream, "cp1252", errors="replace") as lines:
        header = [line.split() for line in _until_end(lines)]
        table = np.loadtxt(
            (line.replace("No Data", "nan") for line in _until_end(lines)), comments=None, ndmin=2
        )
    try:
        n_x, n_y = map(int, header[POINTS_LINE][2:4])
        pitch = float(header[PITCH_LINE][PITCH])
    except (IndexError, ValueError):
        raise ValueError(
            f"its header has no points in line {POINTS_LINE + 1} or no distance of them in line"
            f" {PITCH_LINE + 1}"
        ) from None
    if table.shape != (n_x * n_y, 3):
        raise ValueError(
            f"found {table.shape[0]} lines of {table.shape[1]} numbers, allowed: {n_x} x {n_y}"
            " lines of x, y and z, as its header says"
        )
    heights, _ = points_on_grid(*table.T)
    return heights, Metadata(
        sizes=(n_x * pitch, n_y * pitch) if pitch else None,
        sizes_unit="m" if pitch else "px",
        unit=spec.unit or "um",
        direction="along the column x",
        remarks=() if spec.unit else ("heights are taken in um, Zygo's unit in such a text",),
    )


def _until_end(lines: Iterator[str]) -> Iterator[str]:
    """Yield lines up to the next one that is END alone."""
    return takewhile(lambda line: line.strip() != END, lines)
