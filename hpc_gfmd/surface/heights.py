"""Heights as they are read: whether they are numbers to compute with, and a checksum that tells one
height map from another."""

import hashlib
import operator
from typing import Any

import numpy as np

from ..scene.table import LARGEST  # heights that differ by less than its inverse are refused, too
from ..util.errors import SceneError, one_line

A_MAP = "a real array with two axes, not empty"


def require_map(array: Any, where: str, of: str = "") -> None:
    """Require a non-empty array of real numbers with two axes; only shape and dtype are checked.

    Parameters
    ----------
    array : ndarray, or anything sliced like one
    where : str
        Key at the start of the message.
    of : str
        Appended to what was found, such as " in map.txt".

    Raises
    ------
    SceneError
    """
    shape = tuple(array.shape)
    dtype = array.dtype
    if len(shape) != 2 or 0 in shape or dtype.kind not in "fiu":
        raise SceneError(
            f"{where}: found shape {shape} of {one_line(str(dtype), 80)}{of}, allowed: {A_MAP}"
        )


def checked(
    z: np.ndarray, start: int, where: str, of: str = "", missing: bool = False
) -> np.ndarray:
    """Return heights if they, and their squares, are finite. What instruments write for points that
    they could not measure is often nan or the largest number.

    Parameters
    ----------
    z : ndarray
        float64.
    start : int
        Number of its first row.
    where : str
        Key at the start of the message.
    of : str
        Appended to what was found, such as " in map.txt".
    missing : bool
        Some may be nan.

    Returns
    -------
    ndarray
        z itself.

    Raises
    ------
    SceneError
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
    """Compute BLAKE2 of heights, row by row, the same for any number of ranks. Collective.

    Synthetic surfaces have none: the scene says all about them, and a billion points are made
    faster than they are summed.

    Parameters
    ----------
    grid : Grid
    z : ndarray
        This rank's slab, float64.
    n : (int, int)
    sizes : (float, float)
    unit : str
        Of the sizes.

    Returns
    -------
    str
    """

    def of_rows(i0: int, i1: int) -> bytes:
        rows = (np.ascontiguousarray(row, "<f8").data for row in z[i0:i1])
        return b"".join(hashlib.blake2b(row, digest_size=16).digest() for row in rows)

    shape = repr((tuple(map(int, n)), tuple(map(float, sizes)), unit))
    whole = hashlib.blake2b(shape.encode(), digest_size=16)
    whole.update(grid.comm.reduce(b"".join(grid.by_rows(of_rows)), operator.add) or b"")
    return str(grid.comm.bcast(whole.hexdigest()))
