"""What theory says of a surface, where there is one: Persson's of self-affine surfaces, Hertz' of
spheres, Westergaard's of waves."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from ..output.read import Result
from ..scene import Scene
from ..theory import persson, yielding
from ..theory.elastic import Hertz, Westergaard
from ..theory.slope_profile import SlopeProfile
from ..util.errors import SceneError
from .units import Scale, good


@dataclass(frozen=True)
class Theory:
    """area(p), gap(p), approach(p): relative contact area, mean gap, approach under the mean
    pressures p; density(x, p): of the local pressure x > 0, integrates to the area; all in the
    units of the result, None where it does not say. height: what heights are measured in; sources:
    papers, with DOI."""

    name: str
    area: Callable | None
    gap: Callable | None = None
    density: Callable | None = None
    approach: Callable | None = None
    height: Scale | None = None
    sources: tuple[str, ...] = ()


def scene_of(result: Result) -> Scene | None:
    """Read its scene; None for heights of an array, and for a scene of another version."""
    try:
        return Scene.from_toml(result.scene_toml)
    except SceneError:
        return None


def theory_of(scene: Scene | None, found: Mapping[str, Any]) -> Theory | None:
    """Find the theory of a surface, of which a result says `found`; None for measured ones, layers,
    and where a theory is only of periodic or of free ones."""
    if scene is None:
        return None
    surface, E_star = scene.surface, float(scene.material.E_star)
    if scene.material.thickness is not None:
        return None
    if (hardness := scene.material.hardness) is not None:
        periodic = surface.kind == "self-affine" and not any(surface.free)
        return _yielding(E_star, float(hardness), found) if periodic else None
    if surface.kind == "sphere":
        return _hertz(surface, E_star) if len({*surface.radii}) == 1 else None
    if any(surface.free):
        return None
    known = {"self-affine": _persson, "wave": _westergaard}.get(surface.kind)
    return known and known(surface, E_star, found)


def _persson(surface: Any, E_star: float, found: Any) -> Theory | None:
    h_rms, g_rms, eps_f = (found.get(name) for name in ("h_rms", "g_rms", "eps_f"))
    if not good(g_rms):
        return None
    unit, gap = E_star * g_rms, None
    if good(eps_f) and eps_f < 1:
        q = np.unique([1.0, surface.lam_l_over_lam_r, 1 / eps_f])  # in units of the longest wave's
        spectrum = np.maximum(q, surface.lam_l_over_lam_r) ** (-2 - 2 * surface.hurst)
        profile = SlopeProfile.from_spectrum(q, spectrum)

        def gap(p: Any) -> np.ndarray:
            in_h_rms = (
                persson.mean_gap_spectrum(q, spectrum, p / unit * profile.g_rms) / profile.h_rms
            )
            return h_rms * np.ma.masked_less(in_h_rms, 1e-12)

    def density(x: Any, p: Any) -> np.ndarray:
        return persson.pressure_distribution(x / unit, p / unit) / unit

    name = "Persson" if gap is None else f"Persson ($\\gamma = {persson.GAMMA:g}$)"
    sources = (
        "Persson, J. Chem. Phys. 115 (2001) 3840, doi:10.1063/1.1388626",
        "Persson, Phys. Rev. Lett. 99 (2007) 125502, doi:10.1103/PhysRevLett.99.125502",
    )
    return Theory(name, lambda p: persson.contact_area(p / unit), gap, density, sources=sources)


def _yielding(E_star: float, hardness: float, found: Any) -> Theory | None:
    slope = found.get("g_rms")
    if not good(slope):
        return None

    def density(x: Any, p: Any) -> np.ndarray:
        return yielding.pressure_distribution(x, p, hardness, slope, E_star)

    def area(p: Any) -> np.ndarray:
        def one(p0: float) -> float:
            return yielding.areas(p0, hardness, slope, E_star)[0] if p0 < hardness else np.nan

        return np.vectorize(one)(p)

    source = "Persson, Phys. Rev. Lett. 87 (2001) 116101, doi:10.1103/PhysRevLett.87.116101"
    return Theory("Persson with hardness", area, None, density, sources=(source,))


def _hertz(surface: Any, E_star: float) -> Theory:
    radius = float(surface.radii[0])
    area = float(surface.physical_sizes[0]) * float(surface.physical_sizes[1])

    def contact(p: Any) -> Any:
        return Hertz(radius, p * area, E_star)

    def density(x: Any, p: Any) -> np.ndarray:
        hertz = contact(p)
        return np.where(
            x <= hertz.peak_pressure,
            2 * pi * hertz.a**2 * x / (hertz.peak_pressure**2 * area),
            np.nan,
        )

    return Theory(
        "Hertz",
        lambda p: pi * contact(p).a ** 2 / area,
        None,
        density,
        (lambda p: contact(p).approach) if all(surface.free) else None,
        Scale(float(surface.physical_sizes[0]), "L_x", True),
        ("Hertz, J. Reine Angew. Math. 92 (1882) 156, doi:10.1515/crll.1882.92.156",),
    )


def _westergaard(surface: Any, E_star: float, _: object) -> Theory | None:
    height = Scale(abs(float(surface.amplitude)), "A", True)
    axis = 0 if surface.periods[0] else 1
    if surface.periods[1 - axis] or not height.unit:
        return Theory("", None, height=height) if height.unit else None
    length = float(surface.physical_sizes[axis]) / surface.periods[axis]

    def contact(p: Any) -> Any:
        return Westergaard(p, height.unit, length, E_star)

    def density(x: Any, p: Any) -> np.ndarray:
        solved = contact(p)
        # p falls from the crest to the edge
        where = np.linspace(0, length / 2 * float(solved.a_r), 2001)
        pressures = solved.pressure(where)
        slope = np.abs(np.gradient(where, pressures, edge_order=1))
        return np.interp(x, pressures[::-1], 2 / length * slope[::-1], right=np.nan)

    return Theory(
        "Westergaard",
        lambda p: contact(p).a_r,
        lambda p: contact(p).gap_mean,
        density,
        height=height,
        sources=("Westergaard, J. Appl. Mech. 6 (1939) A49, doi:10.1115/1.4008919",),
    )
