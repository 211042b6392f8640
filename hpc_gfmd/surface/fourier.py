"""Surfaces given by the coefficients of their Fourier series.

z(r) = sum of c_k exp(2 pi i (k_x x/L_x + k_y y/L_y)), where c_-k is the conjugate of c_k.
"""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..parallel.guard import on_rank_0
from ..scene import has_unit
from ..util.errors import SceneError, is_mistake, one_line
from ..util.quantities import factor
from .modes import Modes

PARTNERS = 1e-9  # relative difference of c_-k and the conjugate of c_k that is rounding
FORMS = (
    "whole k_x, k_y and c of each mode (text: columns k_x, k_y, real and imaginary part; .npz and"
    " HDF5: indices, coefficients), or one complex array numpy.fft.fft2(z)/z.size"
)


@dataclass(frozen=True)
class Coefficients:
    """Coefficients of one of each pair k, -k (k_y > 0, or k_y = 0 and k_x > 0), sorted by k_y, in
    units of the largest, `unit`; without the mean.
    """

    k_x: np.ndarray
    k_y: np.ndarray
    c: np.ndarray
    unit: float

    def add(
        self, block: np.ndarray, keep: Any, factor: Any, j0: int, columns: int, n_y: int
    ) -> None:
        """Add these modes to columns of a spectrum, see `modes.AddModes`."""
        block *= keep
        begin, end = np.searchsorted(self.k_y, (j0, j0 + columns))
        k_x = self.k_x[begin:end]
        k_y = self.k_y[begin:end]
        c = (factor * self.c[begin:end]).astype(block.dtype)
        np.add.at(block, (k_y - j0, k_x), c)
        in_pairs = (k_y == 0) | (2 * k_y == n_y)  # c_-k is in the same column
        np.add.at(block, (k_y[in_pairs] - j0, -k_x[in_pairs]), c[in_pairs].conj())

    def checksum(self) -> str:
        """Return a checksum of all coefficients."""
        whole = hashlib.blake2b(repr(self.unit).encode(), digest_size=16)
        for numbers in (self.k_x, self.k_y, self.c):
            whole.update(numbers.tobytes())
        return whole.hexdigest()


def fourier_modes(spec: Any, comm: Any) -> Modes:
    """Return all modes of a [surface] of kind "fourier" on every rank. Collective."""
    coefficients = on_rank_0(comm, "reading the coefficients", lambda: _read(spec))
    for axis, n, k in zip("xy", spec.n, (coefficients.k_x, coefficients.k_y)):
        largest = int(np.abs(k).max())
        if 2 * largest > n:
            raise SceneError(
                f"surface.path: found {largest} periods along {axis} in {spec.path}, allowed: up to"
                f" {n // 2} on n = {n} points"
            )
    named = has_unit(spec.physical_sizes)
    if named != bool(spec.unit):
        raise SceneError(
            f"surface.unit: found {spec.unit or 'none'} and physical_sizes"
            f" {'with' if named else 'without'} units, allowed: both, or none"
        )
    size = factor(spec.unit) if spec.unit else 1.0

    def add(block: np.ndarray, keep: Any, factor: Any, j0: int, columns: int) -> None:
        coefficients.add(block, keep, factor, j0, columns, spec.n[1])

    return Modes(
        add,
        unit=None if spec.is_scaled else coefficients.unit * size,
        checksum=coefficients.checksum(),
        prepared=lambda roughness: (f"{len(coefficients.c)} waves",),
    )


def _read(spec: Any) -> Coefficients:
    path = spec.path
    try:
        indices, c = _arrays(path)
    except SceneError:
        raise
    except Exception as error:
        if is_mistake(error) and not isinstance(error, TypeError):  # of an array without numbers
            raise
        reason = one_line(str(error))
        raise SceneError(f"surface.path: cannot read {path}: {reason}, allowed: {FORMS}") from None
    if indices is None:
        indices, c = _of_transform(c, path)
    if c.ndim != 1 or indices.shape != (len(c), 2) or not np.isfinite(c).all():
        raise SceneError(
            f"surface.path: found indices of shape {indices.shape} and coefficients of shape"
            f" {c.shape} in {path}, allowed: {FORMS}, all finite"
        )
    whole = np.rint(indices).astype(np.int64)
    if not np.array_equal(whole, indices):
        raise SceneError(f"surface.path: found broken mode numbers in {path}, allowed: whole ones")
    return _one_of_each_pair(whole, c, path)


def _arrays(path: str) -> tuple[np.ndarray | None, np.ndarray]:
    """Return mode numbers (m, 2) and coefficients (m,), or None and a transform (n_x, n_y)."""
    if not Path(path).is_file():
        raise SceneError(f"surface.path: found no file {path}, allowed: {FORMS}")
    if h5py.is_hdf5(path):
        with h5py.File(path) as file:
            arrays = {name: file[name][()] for name in ("indices", "coefficients") if name in file}
    elif Path(path).suffix == ".npz":
        with np.load(path) as file:
            arrays = dict(file)
    elif Path(path).suffix == ".npy":
        arrays = {"coefficients": np.load(path)}
    else:
        text = Path(path).read_text(encoding="utf-8-sig").replace(",", " ").replace(";", " ")
        rows = np.loadtxt(text.splitlines(), ndmin=2)
        if rows.shape[1] != 4:
            raise SceneError(
                f"surface.path: found {rows.shape[1]} columns in {path}, allowed: four, k_x, k_y,"
                " real and imaginary part"
            )
        arrays = {"indices": rows[:, :2], "coefficients": rows[:, 2] + 1j * rows[:, 3]}
    if "coefficients" not in arrays:
        raise SceneError(f"surface.path: found no coefficients in {path}, allowed: {FORMS}")
    return arrays.get("indices"), np.asarray(arrays["coefficients"], complex)


def _of_transform(transform: np.ndarray, path: str) -> tuple[np.ndarray, np.ndarray]:
    """Return modes and coefficients of a transform over N; a Nyquist mode becomes two halves."""
    if transform.ndim != 2 or not transform.size:
        raise SceneError(f"surface.path: found shape {transform.shape} in {path}, allowed: {FORMS}")
    mirrored = np.roll(transform[::-1, ::-1], (1, 1), (0, 1)).conj()
    if not np.allclose(transform, mirrored, PARTNERS, PARTNERS * np.abs(transform).max()):
        raise SceneError(
            f"surface.path: found an array in {path} that is no transform of real heights, allowed:"
            f" {FORMS}"
        )
    for axis, n in enumerate(transform.shape):
        if n % 2 == 0:
            half = np.take(transform, [n // 2], axis) / 2
            positive, negative = np.split(transform, [n // 2], axis)
            negative = np.delete(negative, 0, axis)
            transform = np.concatenate([positive, half, half, negative], axis)
    numbers = [np.fft.ifftshift(np.arange(m) - m // 2) for m in transform.shape]  # now odd
    indices = np.stack(np.meshgrid(*numbers, indexing="ij"), axis=-1).reshape(-1, 2)
    c = transform.ravel()
    return indices[c != 0], c[c != 0]


def _one_of_each_pair(indices: np.ndarray, c: np.ndarray, path: str) -> Coefficients:
    """Return coefficients of listed modes; SceneError for modes listed twice, c_-k that is not the
    conjugate of c_k, and zeros alone.
    """
    k_x, k_y = indices.T
    mirrored = (k_y < 0) | ((k_y == 0) & (k_x < 0))
    sign = np.where(mirrored, -1, 1)
    k_x = sign * k_x
    k_y = sign * k_y
    c = np.where(mirrored, c.conj(), c)
    order = np.lexsort((mirrored, k_x, k_y))
    k_x, k_y, c, mirrored = (values[order] for values in (k_x, k_y, c, mirrored))
    again = (np.diff(k_x) == 0) & (np.diff(k_y) == 0)
    twice = again & (np.diff(mirrored.astype(int)) == 0)
    differ = again & (np.abs(np.diff(c)) > PARTNERS * np.abs(c).max(initial=0.0))
    for wrong, reason in ((twice, "twice"), (differ, "and a mirror that is not conjugate")):
        if wrong.any():
            place = int(np.argmax(wrong))
            raise SceneError(
                f"surface.path: found mode ({k_x[place]}, {k_y[place]}) {reason} in {path},"
                " allowed: each once, c_-k the conjugate of c_k or left out"
            )
    kept = np.append(True, ~again) & ((k_x != 0) | (k_y != 0)) & (c != 0)
    if not kept.any():
        raise SceneError(f"surface.path: found no waves in {path}, allowed: at least one")
    unit = float(np.abs(c[kept]).max())
    return Coefficients(k_x[kept], k_y[kept], c[kept] / unit, unit)
