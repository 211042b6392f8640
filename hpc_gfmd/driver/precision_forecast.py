"""The precision of each load of a scene, predicted before anything is solved, for `plan` and the
memory that a run needs.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import DTypeLike

from ..parallel.comm import SerialComm
from ..surface import build_surface
from .memory import OF_LATER
from .precision import (
    DOUBLE,
    initial_dtype,
    is_unloaded,
    p_stars_of,
    pressure_that_counts,
    rounding_in_single,
    single_fails,
)

if TYPE_CHECKING:
    from ..scene import Scene

COARSE = 512  # points along an axis of the coarse surface that `known_heights` makes, at most


def first_of_scene(scene: Scene) -> np.dtype:
    """Return the precision of a scene's first load, which leaves its errors to later ones where
    loads change the wall.
    """
    leaves_errors = scene.remembers and len(scene.load.prescribed[1]) > 1
    return initial_dtype(scene.solver, OF_LATER if leaves_errors else 1.0)


def precisions(
    scene: Scene, n: tuple[int, int], unknown: DTypeLike | None = None
) -> list[np.dtype | None]:
    """Predict the precision of each load without solving: "auto" becomes double, for good, once
    points are few or rounding large. Unpredictable ones have `unknown`; None: go on as in single.
    """
    settings = scene.solver
    precision = first_of_scene(scene)
    precisions_of_loads: list[np.dtype | None] = []
    g_rms, h_rms = known_heights(scene, n)
    rounding = rounding_in_single(h_rms or np.inf)
    hardness = np.inf
    if g_rms and scene.material.hardness:
        hardness = scene.material.hardness / (scene.material.E_star * g_rms)
    for p_star in known_p_stars(scene, g_rms):
        unloaded = is_unloaded(p_star, scene.material.adhesion)
        if settings.precision == "auto" and precision != DOUBLE and not unloaded:
            if single_fails(settings, math.prod(n), p_star, h_rms or 0.0, hardness):
                precision = DOUBLE
            elif p_star is None or rounding > pressure_that_counts(settings, p_star):
                if unknown is None:
                    precisions_of_loads.append(None)
                    continue
                precision = np.dtype(unknown)
        precisions_of_loads.append(precision)
    return precisions_of_loads


def known_p_stars(scene: Scene, g_rms: float | None) -> list[float | None]:
    """Return p* of each load of a scene, as `p_stars_of`."""
    sizes = scene.surface.physical_sizes or ()
    return p_stars_of(scene.load, scene.material.E_star, g_rms, sizes)


def known_heights(scene: Scene, n: tuple[int, int]) -> tuple[float | None, float | None]:
    """Return rms slope, and rms height over it and the spacing, by keys or a coarse surface; None
    for maps, spectra, Fourier coefficients and rough balls; h_rms None if flat.
    """
    surface = scene.surface
    if surface.kind == "file" or surface.kind == "spectrum" or surface.kind == "fourier":
        return None, None
    if surface.kind == "self-affine" and surface.radius:
        return None, None
    if surface.kind != "self-affine":
        coarse = surface.model_copy(update={"n": tuple(min(k, COARSE) for k in surface.n or ())})
        made = build_surface(coarse, SerialComm(), np.float64)
        a = math.sqrt(math.prod(surface.physical_sizes) / math.prod(n))
        return made.g_rms, made.h_rms / (made.g_rms * a) if made.g_rms else None
    from ..theory.persson import g_rms_lam_s_over_h_rms  # SciPy takes a third of a second

    slope = g_rms_lam_s_over_h_rms(surface.hurst, 1 / surface.lam_l_over_lam_s)
    return surface.g_rms, surface.lam_s_over_a / slope
