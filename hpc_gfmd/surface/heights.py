"""Heights as they are read: whether they are numbers to compute with, and a checksum that tells one
height map from another."""

import hashlib
import operator
from typing import Any

import numpy as np

from ..scene.table import LARGEST  # heights that differ by less than its inverse are refused, too
from ..util.errors import SceneError, one_line

A_MAP = "a real array with two axes, not empty"


def require_map(found: Any, where: str, of: str = "") -> None:
    """Raise SceneError, which begins with `where` and names the file, `of`, if an array cannot be a
    height map."""
    shape, dtype = tuple(found.shape), found.dtype
    if len(shape) != 2 or 0 in shape or dtype.kind not in "fiu":
        raise SceneError(
            f"{where}: found shape {shape} of {one_line(str(dtype), 80)}{of}, allowed: {A_MAP}"
        )


def checked(
    z: np.ndarray, start: int, where: str, of: str = "", missing: bool = False
) -> np.ndarray:
    """Return the heights z (float64, rows from `start`) if all are finite, and so are squares of
    them; missing: some may be nan.

    Raises SceneError for others, which begins with `where` and names the file, `of`: what
    instruments write for points that they could not measure is often nan or the largest number.
    """
    wrong = ~(np.abs(z) <= LARGEST)
    if missing:
        wrong &= ~np.isnan(z)
    if wrong.any():
        i, j = np.argwhere(wrong)[0]
        fill = '; hpc_gfmd.prepare_surface(heights, fill="harmonic") fills nan' * bool(
            np.isnan(z[i, j])
        )
        raise SceneError(
            f"{where}: found {z[i, j]:g} at ({start + i}, {j}){of}, allowed: finite heights, "
            f"{-LARGEST:g} to {LARGEST:g}{fill}"
        )
    return z


def checksum(
    grid: Any, z: np.ndarray, n: tuple[int, ...], sizes: tuple[float, ...], unit: str = ""
) -> str:
    """Compute BLAKE2 of the heights of all ranks, row by row, with the shape, the physical sizes
    and their unit: the same for any number of ranks. z: this rank's slab of the grid, float64.
    Collective.

    Synthetic surfaces have none: the scene says all about them, and a billion points are made
    faster than they are summed.
    """

    def of_rows(i0: int, i1: int) -> bytes:
        rows = (np.ascontiguousarray(row, "<f8").data for row in z[i0:i1])
        return b"".join(hashlib.blake2b(row, digest_size=16).digest() for row in rows)

    shape = repr((tuple(map(int, n)), tuple(map(float, sizes)), unit))
    whole = hashlib.blake2b(shape.encode(), digest_size=16)
    whole.update(grid.comm.reduce(b"".join(grid.by_rows(of_rows)), operator.add) or b"")
    return str(grid.comm.bcast(whole.hexdigest()))
