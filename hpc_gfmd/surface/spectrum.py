"""Random roughness with the spectrum of a table or of power laws."""

import hashlib
from functools import partial
from typing import Any

import numpy as np

from ..kernels.random_waves import random_waves
from ..parallel.guard import on_rank_0
from ..scene import has_unit
from ..util.errors import SceneError
from ..util.quantities import factor, prefixed
from .modes import Modes
from .spectra import Spectrum, of_isotropic_surface
from .spectrum_table import read_spectrum_table
from .statistics import Roughness


def spectrum_modes(spec: Any, comm: Any) -> Modes:
    """Return the modes of a scene's [surface] of kind "spectrum". Collective.

    Raises SceneError on all ranks if the spectrum cannot be read, or does not fit to the grid.
    """
    table = on_rank_0(comm, "reading the spectrum", lambda: isotropic_spectrum(spec))
    L_x, L_y = spec.physical_sizes
    k = table.q * L_x / (2 * np.pi)  # periods along x
    try:
        per_length = f" 1/{table.unit}" if table.unit else ""
        q_end = f"q up to {table.q[-1]:.6g}{per_length}, "
        spec.require_resolved(float(k[-1]), spec.n, spec.aspect, q_end)
    except ValueError as error:
        raise SceneError(f"surface: {error}; surface.shortest leaves waves out") from None
    amplitudes = np.sqrt(1.5 * table.C / (L_x * L_y))  # of uniform numbers, whose variance is 1/3
    unit = amplitudes.max()
    law = (
        np.uint64(spec.seed),
        spec.random == "phases",
        spec.aspect,
        spec.stretch,
        (k[0], k[-1]),
        k[:-1],
        k[:-1],
        amplitudes[:-1] / unit,
        table.exponents / 2,
    )
    is_scaled = spec.h_rms is not None or spec.g_rms is not None
    return Modes(
        partial(random_waves, n_y=spec.n[1], law=law),
        unit=None if is_scaled else float(unit),
        checksum=None if spec.path is None else _checksum(table),
        prepared=partial(_compared, spec, table),
    )


def isotropic_spectrum(spec: Any) -> Spectrum:
    """Return the spectrum of a scene's [surface], without the waves that are left out.

    Raises SceneError if it cannot be read, or has a unit and the sizes have none, or the reverse.
    """
    if spec.wavelengths is not None:
        q = 2 * np.pi / np.array(spec.wavelengths, float)
        falls = np.cumsum((2 + 2 * np.array(spec.hurst)) * np.diff(np.log(q)))
        return _cut(Spectrum(q, np.exp(-np.append(0.0, falls))), spec)
    if spec.path is None:
        q, C = (np.array(column, float) for column in (spec.q, spec.C))
        dimension, unit, where = spec.dimension, spec.unit, "surface.q"
    else:
        q, C, dimension, unit = read_spectrum_table(spec.path, spec.unit, spec.dimension)
        where = "surface.path"
    named = has_unit(spec.physical_sizes)
    if named != bool(unit):
        has, allowed = (
            (f"q in 1/{unit} and plain physical_sizes", "both with units, or none")
            if unit
            else ("no unit of q and C", 'one in the head of the table, or surface.unit = "um"')
        )
        raise SceneError(f"{where}: found {has}, allowed: {allowed}")
    size = factor(unit) if unit else 1.0
    table = Spectrum(q / size, C * size ** (2 + dimension), "m" if unit else "")
    table = _cut(table, spec)
    return table if dimension == 2 else of_isotropic_surface(table)


def _cut(table: Spectrum, spec: Any) -> Spectrum:
    """Return a spectrum without waves longer than spec.longest or shorter than spec.shortest."""
    if spec.longest is None and spec.shortest is None:
        return table
    lowest = 0.0 if spec.longest is None else 2 * np.pi / spec.longest
    highest = np.inf if spec.shortest is None else 2 * np.pi / spec.shortest
    return table.between(lowest, highest)


def _checksum(table: Spectrum) -> str:
    """Return a checksum of the numbers of a table."""
    return hashlib.blake2b(np.stack([table.q, table.C]).tobytes(), digest_size=16).hexdigest()


def _compared(spec: Any, table: Spectrum, made: Roughness) -> tuple[str, ...]:
    """Return a line with the roughness of the spectrum beside that of the surface.

    Where the surface is scaled to an h_rms or g_rms, so is the spectrum.
    """
    of_table = _stretched(table.roughness(), spec.peklenik)
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
    along, across = 1 / peklenik, peklenik  # factors of q^2
    return Roughness(
        isotropic.h_rms,
        isotropic.g_rms * ((along + across) / 2) ** 0.5,
        isotropic.curvature * ((3 * along**2 + 2 + 3 * across**2) / 8) ** 0.5,
    )
