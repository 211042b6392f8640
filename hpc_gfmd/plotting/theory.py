"""Theories beside results: Persson's for self-affine surfaces, Hertz', Westergaard's. `surface` is
a scene's [surface]; p is a mean and x a local pressure, in the unit of the result.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isfinite, pi
from typing import Any

import numpy as np

from ..output.result import Result
from ..output.summary import is_positive
from ..scene import ArrayScene, Scene
from ..theory import persson, yielding
from ..theory.elastic import Hertz, HertzLine, Westergaard
from ..theory.slope_profile import SlopeProfile
from ..util.quantities import prefixed

PERSSON = (
    "Persson, J. Chem. Phys. 115 (2001) 3840, doi:10.1063/1.1388626",
    "Persson, Phys. Rev. Lett. 99 (2007) 125502, doi:10.1103/PhysRevLett.99.125502",
)

Spectrum = tuple[np.ndarray, np.ndarray]  # (q, C) at ascending q
ROUNDING = 1e-12  # share of the largest power below which a spectrum is rounding errors


@dataclass(frozen=True)
class Theory:
    """A theory of a surface, in the units of the result. `curves`: functions of the mean pressure
    by the numbers that they predict; density(x, p), of the local pressure x > 0, integrates to a_r;
    `height`: what heights without a unit are divided by, and its name, None for h_rms; `text`: the
    name without TeX.
    """

    name: str
    curves: dict[str, Callable]
    density: Callable | None = None
    height: tuple[float, str] | None = None
    sources: tuple[str, ...] = ()
    text: str = ""


def theory_beside(result: Result, of_maps: bool) -> Theory | None:
    """Return the theory of a result's surface, or None; of_maps: also of measured maps."""
    theory = theory_of(result.readable_scene, result.surface)
    if theory is None and of_maps:
        theory = _persson_of_map(result.scene, result.surface, _height_spectrum(result))
    return theory


def _height_spectrum(result: Result) -> Spectrum | None:
    """Return (q, C) of the heights where a load step has that distribution, else None."""
    for step in result.steps:
        if "heights_spectrum_q" in step:
            q, power = (
                np.array(step[f"heights_spectrum_{name}"], float) for name in ("q", "power")
            )
            exists = power > ROUNDING * power.max()
            return q[exists], power[exists]
    return None


def theory_of(scene: Scene | None, attributes: Any) -> Theory | None:
    """Return the theory of a surface; None for measured ones, layers and adhesion."""
    if scene is None or isinstance(scene, ArrayScene) or scene.material.thickness is not None:
        return None
    if scene.material.adhesion is not None:  # these theories have none
        return None
    surface = scene.surface
    hardness = scene.material.hardness
    E_star = float(scene.material.E_star)
    periodic = not any(surface.free)
    slope = attributes.get("g_rms")
    if surface.kind == "self-affine" and periodic and is_positive(slope):
        if hardness is not None:
            return _yielding(E_star, float(hardness), slope)
        return _persson_of_self_affine(surface, E_star * slope, attributes)
    if surface.kind == "sphere" and hardness is None and len({*surface.radii}) == 1:
        return _hertz(surface, E_star)
    if surface.kind == "sphere" and hardness is None and inf in surface.radii:
        return _hertz_line(surface, E_star)
    if surface.kind == "wave" and hardness is None and periodic:
        return _westergaard(surface, E_star)
    return None


def _areas(area: Callable, unit: float) -> dict[str, Callable]:
    """Return the curves a_r and kappa of area(p); unit: the pressure at which p* = 1."""
    return {"a_r": area, "kappa": lambda p: unit * area(p) / p}


def _persson(name: str, text: str, unit: float, h_rms: float, spectrum: Spectrum | None) -> Theory:
    """Return Persson's theory with a mean gap if there is a spectrum; unit: E* g_rms."""
    curves = _areas(lambda p: persson.contact_area(p / unit), unit)
    if spectrum is not None:
        q, power = spectrum

        def gap(p: Any) -> np.ndarray:
            profile = SlopeProfile.from_spectrum(q, power)
            unscaled = persson.mean_gap_spectrum(q, power, p, unit / profile.g_rms)
            return h_rms * unscaled / profile.h_rms

        curves["gap_mean"] = gap

    def density(x: Any, p: Any) -> np.ndarray:
        return persson.pressure_distribution(x / unit, p / unit) / unit

    return Theory(name, curves, density, sources=PERSSON, text=text)


def _persson_of_self_affine(surface: Any, unit: float, attributes: Any) -> Theory:
    """Return Persson's theory of a self-affine surface with eps_f and h_rms; unit: E* g_rms."""
    name = "Persson"
    eps_f = attributes.get("eps_f")
    spectrum = None
    if is_positive(eps_f) and eps_f < 1:
        q = np.unique([1.0, surface.lam_l_over_lam_r, 1 / eps_f])  # in units of the longest wave's
        spectrum = q, np.maximum(q, surface.lam_l_over_lam_r) ** (-2 - 2 * surface.hurst)
        name = f"Persson ($\\gamma = {persson.GAMMA:g}$)"
    text = f"Persson, gamma = {persson.GAMMA:g}"
    return _persson(name, text, unit, attributes.get("h_rms"), spectrum)


def _persson_of_map(scene: Scene, attributes: Any, spectrum: Spectrum | None) -> Theory | None:
    """Return Persson's theory of a map's own g_rms and spectrum (q, C), ascending; None for layers,
    adhesion, a hardness, free edges.
    """
    slope = attributes.get("g_rms")
    sizes = attributes.get("physical_sizes")
    points = attributes.get("n")
    if any(scene.surface.free) or not (is_positive(slope) and sizes and points):
        return None
    material = scene.material
    not_covered = (material.thickness, material.adhesion, material.hardness)
    if any(setting is not None for setting in not_covered):
        return None
    shortest = 2 * max(size / n for size, n in zip(sizes, points))
    scale, name = prefixed([max(sizes), shortest], attributes.get("unit") or "")
    waves = f"{shortest / scale:.3g} to {max(sizes) / scale:.3g} {name}".strip()
    label = f"Persson ($g_\\mathrm{{rms}}$ = {slope:.3g}, waves of {waves.replace('um', 'µm')})"
    text = f"Persson, g_rms = {slope:.3g}, waves of {waves}, gamma = {persson.GAMMA:g}"
    return _persson(label, text, float(material.E_star) * slope, attributes.get("h_rms"), spectrum)


def _yielding(E_star: float, hardness: float, slope: float) -> Theory:
    """Return Persson's theory of a surface with a hardness, without a gap curve; slope: g_rms."""

    def density(x: Any, p: Any) -> np.ndarray:
        return yielding.pressure_distribution(x, p, hardness, slope, E_star)

    @np.vectorize
    def area(p: float) -> float:
        return yielding.areas(p, hardness, slope, E_star)[0] if p < hardness else np.nan

    source = "Persson, Phys. Rev. Lett. 87 (2001) 116101, doi:10.1103/PhysRevLett.87.116101"
    curves = _areas(area, E_star * slope)
    return Theory("Persson with hardness", curves, density, sources=(source,))


def _hertz(surface: Any, E_star: float) -> Theory:
    """Return Hertz' theory of a sphere; the approach only if all edges are free."""
    radius = float(surface.radii[0])
    L_x, L_y = map(float, surface.physical_sizes)

    def contact(p: Any) -> Hertz:
        return Hertz(radius, p * L_x * L_y, E_star)

    def density(x: Any, p: Any) -> np.ndarray:
        peak = contact(p).peak_pressure
        return np.where(x <= peak, 2 * curves["a_r"](p) * x / peak**2, np.nan)

    curves: dict[str, Callable] = {"a_r": lambda p: pi * contact(p).a ** 2 / (L_x * L_y)}
    if all(surface.free):
        curves["approach"] = lambda p: contact(p).approach
    source = "Hertz, J. Reine Angew. Math. 92 (1882) 156, doi:10.1515/crll.1882.92.156"
    return Theory("Hertz", curves, density, (L_x, "L_x"), (source,))


def _hertz_line(surface: Any, E_star: float) -> Theory | None:
    """Return Hertz' theory of a cylinder that is periodic along its axis alone."""
    curved = 0 if isfinite(surface.radii[0]) else 1
    if surface.free[1 - curved] or not surface.free[curved]:
        return None
    radius = float(surface.radii[curved])
    width = float(surface.physical_sizes[curved])

    def contact(p: Any) -> HertzLine:
        return HertzLine(radius, p * width, E_star)

    def area(p: Any) -> np.ndarray:
        return 2 * contact(p).a / width

    def density(x: Any, p: Any) -> np.ndarray:
        peak = contact(p).peak_pressure
        share = np.where(x < peak, x / peak, np.nan)
        return area(p) * share / (peak * np.sqrt(1 - share**2))

    source = "Johnson, Contact Mechanics (1985), doi:10.1017/CBO9781139171731"
    return Theory("Hertz", {"a_r": area}, density, (width, "L"), (source,))


def _westergaard(surface: Any, E_star: float) -> Theory:
    """Return Westergaard's theory of a wave along one axis, else a scale of heights alone."""
    amplitude = abs(float(surface.amplitude))
    axis = 0 if surface.periods[0] else 1
    if surface.periods[1 - axis] or not amplitude:
        return Theory("", {}, height=(amplitude, "A"))
    length = float(surface.physical_sizes[axis]) / surface.periods[axis]

    def contact(p: Any) -> Westergaard:
        return Westergaard(p, amplitude, length, E_star)

    def density(x: Any, p: Any) -> np.ndarray:
        solved = contact(p)
        # p falls from the crest to the edge
        where = np.linspace(0, length / 2 * float(solved.a_r), 2001)
        pressures = solved.pressure(where)
        slope = np.abs(np.gradient(where, pressures, edge_order=1))
        return np.interp(x, pressures[::-1], 2 / length * slope[::-1], right=np.nan)

    curves = {"a_r": lambda p: contact(p).a_r, "gap_mean": lambda p: contact(p).gap_mean}
    source = "Westergaard, J. Appl. Mech. 6 (1939) A49, doi:10.1115/1.4008919"
    return Theory("Westergaard", curves, density, (amplitude, "A"), (source,))
