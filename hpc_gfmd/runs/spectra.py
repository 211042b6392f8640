"""From a surface to its power spectrum, by SurfaceTopography."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, Literal

import numpy as np

from ..surface.metadata import is_topography
from ..surface.spectra import Spectrum, of_isotropic_surface
from ..util.errors import SceneError, is_mistake, one_line
from ..util.libraries import surface_topography
from .prepared import PreparedSurface
from .surfaces import prepare_surface

ROUNDING = 1e-9  # relative, of a power
EMPTY = 1e-24  # share of the largest C below which a bin holds rounding errors alone
AGREE = 0.03  # relative difference of two h_rms up to which nothing is said


def spectrum_of(
    surface: Any,
    *,
    of: Literal["area", "profiles"] = "area",
    window: str | None = None,
    detrend: str = "height",
    per_decade: int = 10,
    reliable: bool = True,
    **keys: Any,
) -> Spectrum:
    """Return the power spectrum of a surface, averaged over directions and over bins of q.

    Parameters
    ----------
    surface
        A PreparedSurface; an array, with physical_sizes and unit as keys; a Topography of
        SurfaceTopography, whose tip or resolution tells which waves are reliable; or one of its
        containers, of maps and line scans of one surface, as `read_container` and
        `read_published_container` (of contact.engineering, by DOI) return them.
    of
        "area": of the map, for isotropic surfaces. "profiles": the mean of its profiles along x,
        from which that of the isotropic surface follows; always so for containers. A spectrum of
        profiles falls: bins that rise are pooled with their neighbours, and a note says how much
        that changes.
    window
        Of scipy.signal, such as "hann"; default: none for a periodic surface, else "hann".
    detrend
        Of SurfaceTopography, for a surface that is not periodic: "height" (the plane of least
        squares), "center", "curvature".
    per_decade
        Bins in a decade of q.
    reliable
        Whether waves that the tip or the resolution of the instrument does not show are left out.
    **keys
        Those of `prepare_surface`, for an array.

    Returns
    -------
    Spectrum
        `write` makes a table of it that make_surface("spectrum", path=...) reads, `extended` goes
        on to shorter waves.

    Raises
    ------
    SceneError
        If there are less than two bins.
    """
    if of not in ("area", "profiles"):
        raise SceneError(f'of: found {of!r}, allowed: "area", "profiles"')
    if hasattr(surface, "power_spectrum"):
        return _of_container(surface, per_decade, reliable, window)
    topography, unit = _topography(surface, keys)

    def level() -> Any:
        return topography if topography.is_periodic else topography.detrend(detrend)

    def bins() -> Any:
        if of == "area":
            function = level().power_spectrum_from_area
        else:
            function = level().power_spectrum_from_profile
        return function(window=window, reliable=reliable, nb_points_per_decade=per_decade)

    spectrum = _spectrum(bins, unit)
    if of == "profiles":
        return _of_surface(spectrum)
    return _beside(float(np.std(level().heights())), spectrum)


def _beside(h_rms: float, spectrum: Spectrum) -> Spectrum:
    """Return a spectrum with a note if its h_rms is not that of the heights that it is of."""
    of_rows = spectrum.roughness().h_rms
    if abs(of_rows / h_rms - 1) <= AGREE:
        return spectrum
    note = (
        f"h_rms = {of_rows:.3g}, of the heights {h_rms:.3g}: rows begin and end in the middle of"
        " the outer bins, and windows weigh heights; surface.h_rms sets that of walls"
    )
    return replace(spectrum, notes=(note,))


def _of_container(container: Any, per_decade: int, reliable: bool, window: Any) -> Spectrum:
    """Return the spectrum of a container of SurfaceTopography, from the profiles of all it has."""
    keys: dict[str, Any] = {"nb_points_per_decade": per_decade, "reliable": reliable}
    if window is not None:
        keys["window"] = window
    return _of_surface(_spectrum(partial(container.power_spectrum, "m", **keys), "m"))


def _topography(surface: Any, keys: dict[str, Any]) -> tuple[Any, str]:
    """Return a surface as a Topography of SurfaceTopography, and its unit, "m" or none."""
    if is_topography(surface):
        return (surface.to_unit("m"), "m") if surface.unit else (surface, "")
    if not isinstance(surface, PreparedSurface):
        surface = prepare_surface(surface, **{"boundary": "free"} | keys)
    unit = surface.unit or None
    periodic = not any(surface.free)
    made = surface_topography().Topography(
        surface.heights, surface.sizes, unit=unit, periodic=periodic
    )
    return made, surface.unit


def _spectrum(bins: Callable[[], Any], unit: str) -> Spectrum:
    """Return the spectrum of bins (q, C, ...) of SurfaceTopography, without empty ones."""
    try:
        q, C, *_ = bins()
    except Exception as error:
        if is_mistake(error):
            raise
        raise SceneError(f"spectrum_of: {one_line(str(error) or type(error).__name__)}") from None
    q, C = (np.ma.filled(np.ma.asarray(values, dtype=float), np.nan) for values in (q, C))
    filled = np.isfinite(q) & (q > 0) & (C > EMPTY * np.nanmax(C, initial=0.0))
    if np.count_nonzero(filled) < 2:
        raise SceneError("spectrum_of: found waves in less than two bins, allowed: in more")
    return Spectrum(q[filled], C[filled], unit)


def _of_surface(profiles: Spectrum) -> Spectrum:
    """Return the spectrum of the isotropic surface with these profiles, made to fall by least
    squares of logarithms, without bins pooled at the end.
    """
    from scipy.optimize import isotonic_regression

    logarithms = isotonic_regression(np.log(profiles.C), increasing=False).x
    falls = np.flatnonzero(np.diff(logarithms) < 0)
    if not len(falls):
        raise SceneError("spectrum_of: found a spectrum of profiles that nowhere falls")
    kept = slice(falls[-1] + 2)
    C = np.exp(logarithms[kept])
    isotropic = of_isotropic_surface(Spectrum(profiles.q[kept], C, profiles.unit))
    changes = np.abs(C / profiles.C[kept] - 1)
    pooled = np.count_nonzero(changes > ROUNDING)
    if not pooled:
        return isotropic
    note = (
        f"{pooled} of {len(C)} bins of the profiles pooled, which changes them by up to"
        f" {100 * changes.max():.0f} %"
    )
    return replace(isotropic, notes=(note,))
