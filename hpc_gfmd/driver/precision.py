"""When single precision suffices, and when the certificate must be in double precision.

Rounding errors of the heights, of the transforms, and of points that single precision cannot tell
apart are compared with the accuracy asked for. Before anything is solved `precisions` forecasts
the precision of each load; `plan` and the forecast of memory use it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import DTypeLike

from ..operators.problem import ROUNDING
from ..parallel.comm import SerialComm
from ..surface import build_surface
from ..surface.number_range import single_solves
from .memory import OF_LATER

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..scene import LoadTable, Scene, SolverTable

COARSE = 512  # points along an axis of the coarse surface that `known_heights` makes, at most
# Limits of single precision, measured on the true errors of the campaign. They cost or save time
# only: a load that single precision cannot solve stagnates and is solved again in double precision.
FINEST = 2e-4  # accuracy that is tried in single; below it indistinguishable heights spoil the area
FEW_POINTS = 6  # number of points that single precision may put into the wrong set
# Largest rounding error of transforms, over the pressure error that the accuracy allows, with which
# a certificate may be in single precision.
NOISE = 0.2


def first_precision(settings: SolverTable, share: float = 1.0) -> np.dtype:
    """Return the precision of a sweep's first load, for a share of the accuracy; "auto": single
    from an accuracy of 2e-4 on.
    """
    if settings.precision != "auto":
        return np.dtype({"single": np.float32, "double": np.float64}[settings.precision])
    loose = settings.accuracy is not None and share * settings.accuracy >= FINEST
    return np.dtype(np.float32 if loose else np.float64)


def first_of_scene(scene: Scene) -> np.dtype:
    """Return the precision of a scene's first load, which leaves its errors to later ones where
    loads change the wall.
    """
    leaves_errors = scene.remembers and len(scene.load.prescribed[1]) > 1
    return first_precision(scene.solver, OF_LATER if leaves_errors else 1.0)


def few_points(N: int, p_star: float, accuracy: float | None) -> bool:
    """Return whether too few points touch at p_star for the area in single precision, which may
    misplace a few; True if p_star <= 0, False without an accuracy.
    """
    if p_star <= 0:
        return True
    expected = N * min(1.0, 2 * p_star)  # a_r is about 2 p*
    return accuracy is not None and FEW_POINTS / expected > accuracy


def too_coarse(
    settings: SolverTable, N: int, p_star: float | None, h_rms: float, hardness: float
) -> bool:
    """Return whether single precision certainly does not suffice for a load: by p_star, if it is
    known, or because the heights are stored too roughly for a hardness (over E* g_rms).

    h_rms: over g_rms times the grid spacing.
    """
    accuracy = settings.accuracy
    if accuracy is not None and rounding_in_single(h_rms) > accuracy * hardness:
        return True
    if p_star is None:
        return False
    return few_points(N, p_star, accuracy) or not single_solves(p_star, N)


def rounding_in_single(h_rms: float) -> float:
    """Return the rms pressure error, over E* g_rms, of heights in single; h_rms: over g_rms a."""
    return ROUNDING * float(np.finfo(np.float32).eps) * h_rms


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
        unloaded = p_star == 0 and scene.material.adhesion is None  # nothing is solved
        if settings.precision == "auto" and precision == np.float32 and not unloaded:
            if too_coarse(settings, math.prod(n), p_star, h_rms or 0.0, hardness):
                precision = np.dtype(np.float64)
            elif p_star is None or rounding > pressure_that_counts(settings, p_star):
                if unknown is None:
                    precisions_of_loads.append(None)
                    continue
                precision = np.dtype(unknown)
        precisions_of_loads.append(precision)
    return precisions_of_loads


def least_precision(scene: Scene, N: int) -> np.dtype:
    """Return the lowest precision in which loads of a scene may run, by its keys alone."""
    settings = scene.solver
    if settings.precision == "auto":
        for p_star in known_p_stars(scene, getattr(scene.surface, "g_rms", None)):
            unloaded = p_star == 0 and scene.material.adhesion is None  # nothing is solved
            if p_star is None or unloaded:
                continue
            if few_points(N, p_star, settings.accuracy):
                return np.dtype(np.float64)
    return first_of_scene(scene)


def known_p_stars(scene: Scene, g_rms: float | None) -> list[float | None]:
    """Return p* of each load of a scene, as `p_stars_of`."""
    sizes = scene.surface.physical_sizes or ()
    return p_stars_of(scene.load, scene.material.E_star, g_rms, sizes)


def p_stars_of(
    load: LoadTable, E_star: float, g_rms: float | None, sizes: Sequence[float]
) -> list[float | None]:
    """Return p* of each load, half of a prescribed area; None for gaps, approaches, and pressures
    without `g_rms`.
    """
    name, values = load.prescribed
    if name == "p_star":
        return list(values)
    if name == "a_r":
        return [value / 2 for value in values]
    if load.is_searched or not g_rms:
        return [None] * len(values)
    unit = E_star * g_rms
    return [p / unit for p in load.p0(unit, 1.0, math.prod(sizes))]


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


def pressure_that_counts(settings: SolverTable, p_star: float) -> float:
    """Return the rms pressure error, over E* g_rms, that the accuracy allows: residual p_star or
    accuracy sqrt(p_star) (0 without one).
    """
    if settings.residual:
        return settings.residual * p_star
    return (settings.accuracy or 0.0) * max(p_star, 0.0) ** 0.5
