"""Heights as text: bare matrices, and what instruments write with a header or as points (x, y,
z)."""

from pathlib import Path

import numpy as np

from . import instruments
from .metadata import Metadata

POINTS = 3  # columns: with no more than these it is a list of points


def read(path: str | Path, channel: str) -> tuple[np.ndarray, Metadata]:
    """(heights (n_x, n_y), Metadata).

    A bare matrix is the array that numpy.savetxt wrote: the first index, the line, is x. With a
    header that tells sizes or units it is an instrument's: each line is a scan along x.
    """
    with open(path, encoding="utf-8-sig", errors="replace") as file:
        first = next((line for line in file if line.strip()), "")
    delimiter = next((mark for mark in ",;" if mark in first), None)
    if _columns(first, delimiter) > POINTS:
        return np.loadtxt(path, delimiter=delimiter, ndmin=2, encoding="utf-8-sig"), Metadata()
    try:
        heights, said = instruments.read(path, channel)
        if said.sizes or said.unit or _columns(first, delimiter):
            return heights, said
    except Exception:
        if _columns(first, delimiter):
            raise
    return np.loadtxt(
        path, delimiter=delimiter, ndmin=2, encoding="utf-8-sig"
    ), Metadata()  # a mere comment, and then a matrix


def _columns(line: str, delimiter: str | None) -> int:
    """How many numbers a line holds; 0 for a header."""
    try:
        return len([float(number) for number in line.split(delimiter)])
    except ValueError:
        return 0
