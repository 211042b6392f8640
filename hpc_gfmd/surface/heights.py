"""Heights as arrays and by rows: conversion, checks, and a checksum that tells maps apart."""

import hashlib
import operator
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from os import PathLike
from typing import Any

import numpy as np

from ..scene.table import LARGEST  # heights that differ by less than its inverse are refused, too
from ..util.errors import SceneError, one_line
from .metadata import is_y_first

A_MAP = "a real array with two axes, not empty"
EXACT = 2**53  # float64 holds all integers up to this one
ROWS = 64  # of heights that are read at a time
Rows = Callable[[int, int], np.ndarray]  # (start, stop) -> heights, float64 (stop - start, n_y)


@dataclass(frozen=True)
class StoredRows:
    """The rows of heights `z` in memory, of which the first is row `begin` of the map."""

    z: np.ndarray
    begin: int = 0

    def __call__(self, start: int, stop: int) -> np.ndarray:
        """Return rows start <= i < stop, a view if they are in double precision."""
        return np.asarray(self.z[start - self.begin : stop - self.begin], np.float64)


def collected(rows: Rows, start: int, stop: int, width: int) -> np.ndarray:
    """Return rows start <= i < stop of `width` heights, read a few at a time; those in memory in
    double precision as they are, which must not be changed.
    """
    if isinstance(rows, StoredRows) and rows.z.dtype == np.float64:
        return rows(start, stop)
    z = np.empty((stop - start, width))
    for i in range(start, stop, ROWS):
        z[i - start : i - start + ROWS] = rows(i, min(i + ROWS, stop))
    return z


def require_map(array: Any, where: str, of: str = "") -> None:
    """Raise SceneError unless an array is real, with two axes and not empty; reads no values.
    where: key before the message; of: text after the finding.
    """
    shape = tuple(array.shape)
    dtype = array.dtype
    if len(shape) != 2 or 0 in shape or dtype.kind not in "fiu":
        profile = ", a profile" if len(shape) == 1 else ""
        raise SceneError(
            f"{where}: found shape {shape} of {one_line(str(dtype), 80)}{of}{profile}, allowed:"
            f" {A_MAP}"
        )


def array_of(heights: Any, is_complete: bool = False) -> np.ndarray:
    """Convert heights to an array (masked, if they are; plain and without masked points, but
    perhaps nan, if `is_complete`) and check that they are a map, without reading values; an array
    of xarray whose first axis is y is refused.
    """
    if isinstance(heights, str | PathLike):
        path = repr(str(heights))
        raise SceneError(
            f"heights: found {path}, allowed: an array, or hpc_gfmd.read_surface({path})"
        )
    names = [str(name) for name in getattr(heights, "dims", ())]
    if len(names) == 2 and is_y_first([(name, {}) for name in names]):
        raise SceneError(
            f"heights: found axes {names[0]}, {names[1]}, allowed: x, y, as of"
            f' heights.transpose("{names[1]}", "{names[0]}")'
        )
    try:
        heights = np.asanyarray(heights)
    except (TypeError, ValueError) as error:
        raise SceneError(f"heights: found {one_line(str(error))}, allowed: {A_MAP}") from None
    require_map(heights, "heights")
    heights = _from_lowest(heights)
    if not is_complete:
        return heights
    if np.ma.is_masked(heights):
        raise SceneError(
            f"heights: found {np.ma.count_masked(heights)} masked points, allowed: a complete map,"
            ' as of hpc_gfmd.prepare_surface(heights, fill="harmonic")'
        )
    return np.asarray(heights)


def _from_lowest(heights: np.ndarray) -> np.ndarray:
    """Return heights; integers that float64 does not hold are counted from the lowest of them."""
    if heights.dtype.kind not in "iu" or heights.dtype.itemsize < 8:
        return heights
    lowest = heights.min()
    if lowest is np.ma.masked or max(abs(int(lowest)), abs(int(heights.max()))) <= EXACT:
        return heights
    # unsigned arithmetic is modulo 2^64: the differences are right even if int64 does not hold them
    return heights.astype(np.uint64) - np.uint64(int(lowest) % 2**64)


def require_finite(
    z: np.ndarray, start: int, where: str, of: str = "", missing: bool = False
) -> None:
    """Raise SceneError for heights that are infinite, beyond +-LARGEST (which instruments write for
    missing points), or nan unless `missing`. start: index of the first row; where, of: as above.
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


def sums_of_rows(z: np.ndarray) -> bytes:
    """Return a number for each row of heights, for `checksum`: the sum of its numbers times odd
    random ones modulo 2^64.
    """
    bits = z.view(np.uint64)
    bits = bits ^ (bits >> np.uint64(32))  # round heights have no lower bits
    bits *= _odd_factors(z.shape[1])
    return bits.sum(axis=1, dtype=np.uint64).astype("<u8").tobytes()


def checksum(
    comm: Any, sums: bytes, n: tuple[int, ...], sizes: tuple[float, ...], unit: str = ""
) -> str:
    """Return a checksum of heights, points, sizes and unit: BLAKE2 of `sums_of_rows` of this rank's
    rows, so the same for any number of ranks. Collective.
    """
    shape = repr((tuple(map(int, n)), tuple(map(float, sizes)), unit))
    whole = hashlib.blake2b(shape.encode(), digest_size=16)
    whole.update(comm.reduce(sums, operator.add) or b"")
    return str(comm.bcast(whole.hexdigest()))


@lru_cache(maxsize=2)
def _odd_factors(count: int) -> np.ndarray:
    """Return odd random numbers, the same in every process; they must not be changed."""
    return np.random.PCG64(0).random_raw(count) | np.uint64(1)
