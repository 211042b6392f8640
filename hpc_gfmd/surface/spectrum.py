"""Random roughness: self-affine, or with the spectrum of a table or of power laws."""

import hashlib
from functools import partial
from typing import Any

import numpy as np

from ..kernels.random_waves import random_waves
from ..parallel.guard import on_rank_0
from ..scene import has_unit
from ..util.errors import SceneError
from ..util.quantities import factor, prefixed
from .directional_spectrum import DirectionalSpectrum, is_directional, read_directional
from .modes import Modes
from .spectra import Spectrum, in_metres, of_isotropic_surface
from .spectrum_table import read_spectrum_table
from .statistics import Roughness

NO_TABLE = (np.empty(0), np.empty(0), np.empty((0, 0)))
NO_LAWS = (0.0, 0.0, *[np.empty(0)] * 4)


def self_affine_modes(spec: Any, comm: Any) -> Modes:
    """Return the modes of a scene's [surface] of kind "self-affine"."""
    low = spec.L_over_lam_l
    rolloff = low * spec.lam_l_over_lam_r
    exponent = 1.0 + spec.hurst
    laws = (
        low,
        low * spec.lam_l_over_lam_s,
        np.array([0.0, rolloff]),
        np.ones(2),
        np.array([rolloff**-exponent, 1.0]),
        np.array([0.0, exponent]),
    )
    law = (np.uint64(spec.seed), False, spec.aspect, spec.stretch, laws, NO_TABLE)
    return Modes(partial(random_waves, n_y=spec.n[1], law=law))


def spectrum_modes(spec: Any, comm: Any) -> Modes:
    """Return the modes of a [surface] of kind "spectrum". Collective."""
    spectrum = on_rank_0(comm, "reading the spectrum", lambda: _read(spec))
    of_uniform = 1.5 / np.prod(spec.physical_sizes)  # uniform numbers have the variance 1/3
    scale = spec.physical_sizes[0] / (2 * np.pi)  # from q to periods along x
    unit = float(np.sqrt(of_uniform * spectrum.C.max()))
    laws: tuple = NO_LAWS
    table = NO_TABLE
    if isinstance(spectrum, DirectionalSpectrum):
        x_rows = spectrum.q_x * scale
        y_rows = spectrum.q_y * scale
        _require_rows_resolved(spec, x_rows, y_rows)
        table = (x_rows, y_rows, of_uniform * spectrum.C / unit**2)
    else:
        k = spectrum.q * scale
        _require_resolved(spec, float(k[-1]), spectrum)
        amplitudes = np.sqrt(of_uniform * spectrum.C[:-1]) / unit
        laws = (k[0], k[-1], k[:-1], k[:-1], amplitudes, spectrum.exponents / 2)
    law = (np.uint64(spec.seed), spec.random == "phases", spec.aspect, spec.stretch, laws, table)
    return Modes(
        partial(random_waves, n_y=spec.n[1], law=law),
        unit=None if spec.is_scaled else unit,
        checksum=None if spec.path is None else _checksum(spectrum),
        prepared=partial(_compared, spec, _stretched(spectrum.roughness(), spec.peklenik)),
    )


def _require_resolved(spec: Any, k: float, spectrum: Spectrum) -> None:
    """Raise SceneError if the grid does not resolve all waves, up to k periods along x."""
    per_length = f" 1/{spectrum.unit}" if spectrum.unit else ""
    q_end = f"q up to {spectrum.q[-1]:.6g}{per_length}, "
    try:
        spec.require_resolved(k, spec.n, spec.aspect, q_end)
    except ValueError as error:
        raise SceneError(f"surface: {error}; surface.shortest leaves waves out") from None


def _require_rows_resolved(spec: Any, x_rows: np.ndarray, y_rows: np.ndarray) -> None:
    """Raise SceneError if the grid does not resolve all waves of a table, in periods along x."""
    ends = (np.abs(x_rows[[0, -1]]).max(), y_rows[-1] * spec.aspect)
    for axis, periods, n in zip("xy", ends, spec.n):
        if n > 1 and int(periods * (1 + 1e-12)) > n // 2:
            raise SceneError(
                f"surface.path: found waves with {periods:.6g} periods along {axis} on {n} points"
                f" in {spec.path}, allowed: at most {n // 2}, two points a period"
            )


def _read(spec: Any) -> Spectrum | DirectionalSpectrum:
    if spec.path is None or not is_directional(spec.path):
        return isotropic_spectrum(spec)
    for name, usual in (("dimension", None), ("longest", None), ("shortest", None)):
        if getattr(spec, name) != usual:
            raise SceneError(
                f"surface.{name}: found with C(q_x, q_y), allowed: with C of isotropic surfaces"
            )
    if spec.peklenik != 1:
        raise SceneError("surface.peklenik: found with C(q_x, q_y), allowed: 1")
    spectrum = read_directional(spec.path)
    _require_units(spec, spec.unit or "", "surface.path")
    return spectrum.in_metres(factor(spec.unit)) if spec.unit else spectrum


def isotropic_spectrum(spec: Any) -> Spectrum:
    """Return the spectrum of a [surface], without the waves that are left out."""
    if spec.wavelengths is not None:
        q = 2 * np.pi / np.array(spec.wavelengths, float)
        falls = np.cumsum((2 + 2 * np.array(spec.hurst)) * np.diff(np.log(q)))
        return _cut(Spectrum(q, np.exp(-np.append(0.0, falls))), spec)
    if spec.path is None:
        q, C = (np.array(column, float) for column in (spec.q, spec.C))
        dimension = spec.dimension
        unit = spec.unit
        where = "surface.q"
    else:
        q, C, dimension, unit = read_spectrum_table(spec.path, spec.unit, spec.dimension)
        where = "surface.path"
    _require_units(spec, unit, where)
    table = _cut(in_metres(q, C, dimension, unit), spec)
    return table if dimension == 2 else of_isotropic_surface(table)


def _require_units(spec: Any, unit: str, where: str) -> None:
    """Raise SceneError if a table has a unit and the sizes have none, or the reverse."""
    if has_unit(spec.physical_sizes) == bool(unit):
        return
    has, allowed = (
        (f"q in 1/{unit} and plain physical_sizes", "both with units, or none")
        if unit
        else ("no unit of q and C", 'one in the head of the table, or surface.unit = "um"')
    )
    raise SceneError(f"{where}: found {has}, allowed: {allowed}")


def _cut(table: Spectrum, spec: Any) -> Spectrum:
    """Return a spectrum without waves longer than spec.longest or shorter than spec.shortest."""
    if spec.longest is None and spec.shortest is None:
        return table
    lowest = 0.0 if spec.longest is None else 2 * np.pi / spec.longest
    highest = np.inf if spec.shortest is None else 2 * np.pi / spec.shortest
    return table.between(lowest, highest)


def _checksum(spectrum: Spectrum | DirectionalSpectrum) -> str:
    whole = hashlib.blake2b(digest_size=16)
    for values in vars(spectrum).values():
        if isinstance(values, np.ndarray):
            whole.update(values.tobytes())
    return whole.hexdigest()


def _compared(spec: Any, of_table: Roughness, made: Roughness) -> tuple[str, ...]:
    """Return a line with the roughness of the spectrum beside that of the surface."""
    scale = 1.0
    if spec.h_rms is not None:
        scale = made.h_rms / of_table.h_rms
    elif spec.g_rms is not None:
        scale = made.g_rms / of_table.g_rms
    of_table = of_table.in_units(scale, 1.0)
    unit = "m" if has_unit(spec.physical_sizes) else ""
    size, name = prefixed([of_table.h_rms, made.h_rms], unit)
    per_length = f" 1/{name}" if name else ""
    return (
        f"h_rms, g_rms and curvature of the spectrum {of_table.h_rms / size:.4g} {name}".rstrip()
        + f", {of_table.g_rms:.4g}, {of_table.curvature * size:.4g}{per_length}"
        + f"; of the surface {made.h_rms / size:.4g} {name}".rstrip()
        + f", {made.g_rms:.4g}, {made.curvature * size:.4g}{per_length}",
    )


def _stretched(isotropic: Roughness, peklenik: float) -> Roughness:
    """Return the roughness of a surface whose isotropic one is stretched by a Peklenik number."""
    along = 1 / peklenik  # factors of q^2
    across = peklenik
    return Roughness(
        isotropic.h_rms,
        isotropic.g_rms * ((along + across) / 2) ** 0.5,
        isotropic.curvature * ((3 * along**2 + 2 + 3 * across**2) / 8) ** 0.5,
    )
