"""Heights as they are read: whether they are numbers to compute with, and a checksum that tells one
height map from another."""

import hashlib
import operator
from typing import Any

import numpy as np

from ..scene.table import LARGEST  # heights that differ by less than its inverse are refused, too
from ..util.errors import SceneError


def checked(
    z: np.ndarray, start: int, where: str, of: str = "", missing: bool = False
) -> np.ndarray:
    """The heights z (float64, rows from `start`) where all are finite, and so are squares of them;
    missing: some may be nan.

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


class Checksum:
    """BLAKE2 of all heights, row by row: the same for any number of ranks and any pieces in which
    the rows are read.

    Synthetic surfaces have none: the scene says all about them, and a billion points are made
    faster than they are summed.
    """

    def __init__(self) -> None:
        self._rows: list[bytes] = []

    def add(self, z: np.ndarray) -> None:
        """The next rows of this rank, float64."""
        self._rows += [
            hashlib.blake2b(np.ascontiguousarray(row, "<f8").data, digest_size=16).digest()
            for row in z
        ]

    def of_all(
        self, comm: Any, n: tuple[int, ...], sizes: tuple[float, ...], unit: str = ""
    ) -> str:
        """Of the rows of all ranks in their order, with the shape, the physical sizes and their
        unit. Collective."""
        said = repr((tuple(map(int, n)), tuple(map(float, sizes)), unit))
        whole = hashlib.blake2b(said.encode(), digest_size=16)
        whole.update(comm.reduce(b"".join(self._rows), operator.add) or b"")
        return comm.bcast(whole.hexdigest())
