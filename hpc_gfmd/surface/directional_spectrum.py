"""Power spectra C(q_x, q_y) of anisotropic surfaces, in arrays of a file."""

from dataclasses import dataclass
from pathlib import Path
from typing import Self

import h5py
import numpy as np

from ..util.errors import SceneError, is_mistake, one_line
from .statistics import Roughness

NAMES = ("q_x", "q_y", "C")


@dataclass(frozen=True, eq=False)
class DirectionalSpectrum:
    """A power spectrum between whose rows and columns C is linear; beyond them it is 0."""

    q_x: np.ndarray  # wave numbers along x, rising, of both signs
    q_y: np.ndarray  # wave numbers along y, rising, 0 or more: C(-q) = C(q)
    C: np.ndarray  # (len(q_x), len(q_y)), L_x L_y <|h_q|^2>
    unit: str = ""  # "m", or "" without a unit

    def in_metres(self, size: float) -> Self:
        """Return a copy in m; size: of the unit of length of the numbers, in m."""
        return type(self)(self.q_x / size, self.q_y / size, self.C * size**4, "m")

    def roughness(self) -> Roughness:
        """Return h_rms, g_rms and curvature, by the trapezoidal rule on the rows and columns."""
        q2 = self.q_x[:, None] ** 2 + self.q_y**2
        moments = [
            np.trapezoid(np.trapezoid(self.C * q2**power, self.q_y), self.q_x) / (2 * np.pi**2)
            for power in (0, 1, 2)
        ]
        h_rms, g_rms, laplacian = np.sqrt(moments).tolist()
        return Roughness(h_rms, g_rms, laplacian / 2)


def is_directional(path: str) -> bool:
    """Whether a file is one of arrays, and not a text."""
    return Path(path).suffix == ".npz" or (Path(path).is_file() and h5py.is_hdf5(path))


def read_directional(path: str) -> DirectionalSpectrum:
    """Read the arrays q_x, q_y, C of a .npz or HDF5 file, or raise SceneError."""
    try:
        with np.load(path) if Path(path).suffix == ".npz" else h5py.File(path) as file:
            arrays = [np.asarray(file[name][()], float) for name in NAMES]
    except Exception as error:
        if is_mistake(error) and not isinstance(error, TypeError):  # of an array without numbers
            raise
        reason = one_line(str(error) or type(error).__name__)
        raise SceneError(
            f"surface.path: cannot read {path}: {reason}, allowed: arrays {', '.join(NAMES)}"
        ) from None
    q_x, q_y, C = arrays
    if q_x.ndim != 1 or q_y.ndim != 1 or min(len(q_x), len(q_y)) < 2:
        raise SceneError(
            f"surface.path: found q_x of shape {q_x.shape} and q_y of shape {q_y.shape} in {path},"
            " allowed: at least two numbers each"
        )
    if C.shape != (len(q_x), len(q_y)):
        raise SceneError(
            f"surface.path: found C of shape {C.shape} in {path}, allowed: {len(q_x)} x"
            f" {len(q_y)}, as q_x and q_y have"
        )
    for name, q in zip(NAMES, (q_x, q_y)):
        if not (np.isfinite(q).all() and (np.diff(q) > 0).all()):
            raise SceneError(f"surface.path: found {name} that do not rise in {path}")
    if q_y[0] < 0:
        raise SceneError(
            f"surface.path: found q_y = {q_y[0]:.6g} in {path}, allowed: the half q_y >= 0, since"
            " C(-q) = C(q)"
        )
    wrong = ~(np.isfinite(C) & (C >= 0))
    if wrong.any() or not C.any():
        value = C[wrong][0] if wrong.any() else 0.0
        raise SceneError(
            f"surface.path: found C = {value:.6g} in {path}, allowed: positive numbers, and 0 where"
            " there are no waves"
        )
    return DirectionalSpectrum(q_x, q_y, C)
