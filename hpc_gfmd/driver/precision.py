"""Where single precision is enough, and where the certificate has to be in double: what runs follow
and plans read."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import DTypeLike

from ..operators.problem import ROUNDING
from ..parallel.comm import SerialComm
from ..surface import build_surface
from ..surface.number_range import single_solves
from ..theory.persson import g_rms_lam_s_over_h_rms

if TYPE_CHECKING:
    from ..certificate.criterion import StoppingCriterion
    from ..scene import Scene, SolverTable

COARSE = 512  # points along an axis that tell heights and slopes


@dataclass(frozen=True)
class PrecisionCalibration:
    """Where single precision is too little.

    Measured on the true errors of the campaign: what is too small for single precision ends
    "stagnated" in it and is solved again in double, so these numbers cost or save time only.

    Attributes
    ----------
    accuracy : float
        The finest that is tried in single precision: below, points too close to tell spoil the
        area.
    few_points : float
        Points on the wrong side that single precision may have.
    noise : float
        Rounding errors of the transforms, over what counts, beyond which the certificate is in
        double precision.
    """

    accuracy: float = 2e-4
    few_points: float = 6
    noise: float = 0.2


CALIBRATION = PrecisionCalibration()


def first_precision(settings: SolverTable) -> np.dtype:
    """Return the precision that a sweep begins with; settings: the table [solver] of a scene."""
    if settings.precision != "auto":
        return np.dtype({"single": np.float32, "double": np.float64}[settings.precision])
    loose = settings.accuracy is not None and settings.accuracy >= CALIBRATION.accuracy
    return np.dtype(np.float32 if loose else np.float64)


def few_points(N: int, p_star: float, accuracy: float | None) -> bool:
    """Return whether too few points will touch for the area to reach the accuracy in single
    precision, which may get a few points wrong.

    Parameters
    ----------
    N : int
        Points of the surface.
    p_star : float
        Mean pressure over E* g_rms. At 0 and below, with an attraction, any number may touch.
    accuracy : float or None
        Requested; None if a residual is, which gives False.

    Returns
    -------
    bool
    """
    if p_star <= 0:
        return True
    expected = N * min(1.0, 2 * p_star)  # a_r is about 2 p*
    return accuracy is not None and CALIBRATION.few_points / expected > accuracy


def too_soft(accuracy: float | None, h_rms: float, hardness: float | None) -> bool:
    """Return whether the heights are stored in single precision too coarsely for this hardness.

    Their rounding errors are an error of the pressure, which is nowhere more than the hardness.

    Parameters
    ----------
    accuracy : float or None
        Requested; None if a residual is, which gives False.
    h_rms : float
        rms height over g_rms times the grid spacing.
    hardness : float or None
        Over E* g_rms.

    Returns
    -------
    bool
    """
    if accuracy is None or hardness is None:
        return False
    return rounding_in_single(h_rms) > accuracy * hardness


def rounding_in_single(h_rms: float) -> float:
    """Return the rms error of the pressure, over E* g_rms, from storing heights in single
    precision; h_rms: over g_rms times the grid spacing."""
    return ROUNDING * float(np.finfo(np.float32).eps) * h_rms


def too_little(settings: SolverTable, N: int, p_star: float) -> bool:
    """Return whether single precision is too little for a load.

    Parameters
    ----------
    settings : scene.SolverTable
        The table [solver] of a scene.
    N : int
        Points of the surface.
    p_star : float
        Mean pressure over E* g_rms.

    Returns
    -------
    bool
    """
    return few_points(N, p_star, settings.accuracy) or not single_solves(p_star, N)


def precisions(
    scene: Scene, n: tuple[int, int], unknown: DTypeLike | None = None
) -> list[np.dtype | None]:
    """Return the precision of each load, as far as it is known beforehand.

    It is the first one, unless few points turn out to touch, or rounding errors to count. Once a
    load is in double precision all others are.

    Parameters
    ----------
    scene : Scene
        What is to be solved.
    n : pair of int
        Points of its surface along x and y.
    unknown : dtype, optional
        What is returned where that is not known.

    Returns
    -------
    list of dtype or None
    """
    settings = scene.solver
    precision = first_precision(settings)
    precisions_of_loads: list[np.dtype | None] = []
    g_rms, h_rms = known_heights(scene, n)
    rounding = rounding_in_single(h_rms or np.inf)
    hardness = scene.material.hardness
    if hardness is not None and g_rms and h_rms:
        is_soft = too_soft(settings.accuracy, h_rms, hardness / (scene.material.E_star * g_rms))
    else:
        is_soft = False
    for p_star in known_p_stars(scene, g_rms):
        if settings.precision == "auto" and precision == np.float32:
            if is_soft or (p_star is not None and too_little(settings, math.prod(n), p_star)):
                precision = np.dtype(np.float64)
            elif p_star is None or rounding > pressure_that_counts(settings, p_star):
                if unknown is None:
                    precisions_of_loads.append(None)
                    continue
                precision = np.dtype(unknown)
        precisions_of_loads.append(precision)
    return precisions_of_loads


def least_precision(scene: Scene, N: int) -> np.dtype:
    """Return the precision that a scene needs at least, as far as its keys alone show.

    Parameters
    ----------
    scene : Scene
        What is to be solved.
    N : int
        Points of the surface.

    Returns
    -------
    dtype
        float64 if it is asked for, or if too few points will touch; else the first precision.
    """
    settings = scene.solver
    if settings.precision == "auto":
        for p_star in known_p_stars(scene, getattr(scene.surface, "g_rms", None)):
            if p_star is not None and few_points(N, p_star, settings.accuracy):
                return np.dtype(np.float64)
    return first_precision(settings)


def known_p_stars(scene: Scene, g_rms: float | None) -> list[float | None]:
    """Return p* of each load, as far as it is known beforehand.

    Parameters
    ----------
    scene : Scene
        What is to be solved.
    g_rms : float or None
        rms slope of its surface, where that is known.

    Returns
    -------
    list of float or None
        Half of a prescribed area, which is about p* where that is small.
    """
    name, values = scene.load.prescribed
    if name == "p_star":
        return list(values)
    if name == "a_r":
        return [value / 2 for value in values]
    if scene.load.is_searched or not g_rms:
        return [None] * len(values)
    unit = scene.material.E_star * g_rms
    area = math.prod(scene.surface.physical_sizes or ())
    return [p / unit for p in scene.load.p0(unit, 1.0, area)]


def known_heights(scene: Scene, n: tuple[int, int]) -> tuple[float | None, float | None]:
    """Return slope and height of a surface, as far as its table or a coarse grid tells them.

    Parameters
    ----------
    scene : Scene
        With the surface.
    n : pair of int
        Its points along x and y.

    Returns
    -------
    g_rms, h_rms : float or None
        rms slope, and rms height over g_rms times the grid spacing; None of a map and on a form.
    """
    surface = scene.surface
    if surface.kind == "file" or (surface.kind == "self-affine" and surface.radius):
        return None, None
    if surface.kind != "self-affine":
        coarse = surface.model_copy(update={"n": tuple(min(k, COARSE) for k in surface.n or ())})
        made = build_surface(coarse, SerialComm(), np.float64)
        a = math.sqrt(math.prod(surface.physical_sizes) / math.prod(n))
        return made.g_rms, made.h_rms / (made.g_rms * a) if made.g_rms else None
    slope = g_rms_lam_s_over_h_rms(surface.hurst, 1 / surface.lam_l_over_lam_s)
    return surface.g_rms, surface.lam_s_over_a / slope


def pressure_that_counts(target: StoppingCriterion | SolverTable, p_star: float) -> float:
    """Return the rms error of the pressure at all open points that counts as much as what is asked
    for.

    Parameters
    ----------
    target : StoppingCriterion or scene.SolverTable
        The residual, or else the accuracy, that is asked for.
    p_star : float
        Mean pressure over E* g_rms.

    Returns
    -------
    float
        Over E* g_rms.
    """
    if target.residual:
        return target.residual * p_star
    return (target.accuracy or 0.0) * max(p_star, 0.0) ** 0.5
