"""What the scene asks to be done to a measured height map before it is pressed, in this order:

crop, detrend (by the points that were measured), fill, flip, mirror or window, refine, downsample,
and the form under it.

All but refine and downsample are done to rows as they are read, so that the map never is in one
place. All functions are collective.
"""

from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np

from ..parallel.guard import collective_errors
from ..util.errors import SceneError
from ..util.quantities import format_quantity
from .fill import filled
from .quality import notes_on
from .resample import resampled
from .slabs import own_slabs
from .topography import Topography

POWERS = {
    "mean": [(0, 0)],
    "tilt": [(0, 0), (1, 0), (0, 1)],
    "curvature": [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)],
}  # of x and y


def prepared_size(found: Topography, spec: Any) -> tuple[tuple[int, int], tuple[float, ...]]:
    """Return (n_x, n_y) and (L_x, L_y) of what `prepare` makes of a Topography, without reading it.
    Raises SceneError."""
    found = _cropped(found, spec) if spec.crop else found
    found = _mirrored(found) if spec.mirror else found
    n_x, n_y = (k * spec.refine for k in found.n)
    if n_x % spec.downsample or n_y % spec.downsample:
        raise SceneError(
            f"surface.downsample: found {spec.downsample}, allowed: a divisor of {n_x} and of"
            f" {n_y} points"
        )
    return (n_x // spec.downsample, n_y // spec.downsample), found.sizes


def prepare(found: Topography, spec: Any, comm: Any) -> Topography:
    """Return the Topography as the scene wants it, with what has been `done` to it and its `notes`.

    Raises one SceneError on all ranks for everything that the scene still has to say.
    """
    lacks = list(found.lacks.values())
    if lacks:  # only to see what else is
        spec = spec.model_copy(update={"crop": None})
    size, _ = prepared_size(found, spec)
    if spec.crop:
        found = _cropped(found, spec)
    detrend = "mean" if spec.window != "none" and spec.detrend == "none" else spec.detrend
    if detrend != "none":
        found = _detrended(found, detrend, comm)
    try:
        found = filled(found, spec.fill, comm)
    except SceneError as error:
        lacks.append(str(error))
        found = filled(found, "harmonic", comm)
    try:
        found = replace(found, notes=notes_on(found, spec, comm))
    except SceneError as error:
        lacks.append(str(error))
    if lacks:
        raise SceneError("; ".join(lacks))
    if spec.flip:
        upright = found.rows
        found = found.after("upside down", rows=lambda start, stop: -upright(start, stop))
    if spec.mirror:
        found = _mirrored(found)
    if spec.window != "none":
        found = _windowed(found, spec.window)
    if size != found.n:
        found = resampled(found, size, spec.free, comm)
    if spec.radius:
        radii = tuple(found.length("radius", R) for R in spec.radii)
        given = ", ".join(dict.fromkeys(map(format_quantity, spec.radii)))
        found = found.on_form(radii).after(f"on a form of radius {given}")
    return found


def _cropped(found: Topography, spec: Any) -> Topography:
    ends = []
    for axis in (0, 1):
        step = found.sizes[axis] / found.n[axis]
        first, last = (round(found.length("crop", spec.crop[k]) / step) for k in (axis, axis + 2))
        if not 0 <= first < last <= found.n[axis]:
            L_x, L_y = (
                f"{size / found.plain:.6g} {found.plain_unit}".strip() for size in found.sizes
            )
            raise SceneError(
                f"surface.crop: found points {first} to {last} of {found.n[axis]} along"
                f" {'xy'[axis]}, allowed: [x0, y0, x1, y1] with 0 <= x0 < x1 <= {L_x} and 0 <= y0 <"
                f' y1 <= {L_y}, plain in this unit or as "5 um"'
            )
        ends.append((first, last))
    (x0, x1), (y0, y1) = ends
    n = x1 - x0, y1 - y0
    sizes = tuple(size * k / m for size, k, m in zip(found.sizes, n, found.n))
    return found.after(
        f"cropped to {n[0]} x {n[1]} points",
        n=n,
        sizes=sizes,
        rows=lambda start, stop: found.rows(start + x0, stop + x0)[:, y0:y1],
        periodic=found.periodic if n == found.n else None,
    )


def _detrended(found: Topography, what: str, comm: Any) -> Topography:
    """Subtract the polynomial that fits the measured points best."""
    powers = POWERS[what]
    x, y = (2 * np.arange(n) / max(n - 1, 1) - 1 for n in found.n)

    def terms(start: int, stop: int) -> list[np.ndarray]:
        return [x[start:stop, None] ** i * y[None] ** j for i, j in powers]

    own = []
    with collective_errors(comm, "reading the surface"):
        for start, stop in own_slabs(found, comm):
            z = found.rows(start, stop)
            there = np.isfinite(z)
            values = [term[there] for term in (*terms(start, stop), z)]
            own.append([[a @ b for b in values] for a in values[:-1]])
    total = np.sum([*chain(*comm.allgather(own))], axis=0)  # in one order on any ranks
    factors = np.linalg.lstsq(total[:, :-1], total[:, -1])[0]

    def rows(start: int, stop: int) -> np.ndarray:
        return found.rows(start, stop) - sum(
            factor * term for factor, term in zip(factors, terms(start, stop))
        )

    periodic = found.periodic if what == "mean" else None
    return found.after(f"{what} removed", rows=rows, periodic=periodic)


def _mirrored(found: Topography) -> Topography:
    """Append the mirror images, so that the map is twice as long along both axes, and periodic."""
    n = found.n[0]

    def rows(start: int, stop: int) -> np.ndarray:
        straight = found.rows(min(start, n), min(stop, n))
        turned = found.rows(2 * n - max(stop, n), 2 * n - max(start, n))[::-1]
        return np.pad(np.concatenate([straight, turned]), ((0, 0), (0, found.n[1])), "symmetric")

    return found.after(
        "mirrored",
        n=tuple(2 * k for k in found.n),
        sizes=tuple(2 * size for size in found.sizes),
        rows=rows,
        periodic=True,
    )


def _windowed(found: Topography, name: str) -> Topography:
    """Fade the heights out to their mean, 0, at the edges; what is in the middle stays."""
    from scipy.signal.windows import get_window

    w_x, w_y = (get_window(name, n) for n in found.n)
    return found.after(
        f"window {name}",
        rows=lambda start, stop: found.rows(start, stop) * w_x[start:stop, None] * w_y,
        periodic=True,
    )
