"""The preparation of a measured height map that the scene asks for.

The steps, in this order: crop, detrend (by the points that were measured), fill, flip, mirror or
window, refine, downsample, and the form under the map. Each of two scans is filled before they are
added, see two_scans.py.

All steps but refine and downsample apply to rows as they are read, so that no rank ever holds the
whole map.
"""

from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np

from ..parallel.guard import collective_errors, on_rank_0
from ..util.errors import SceneError
from ..util.quantities import format_quantity
from .fill import filled
from .form import form_notes
from .quality import DOUBT, Edges, MapQuality, edges_of, quality_of, window_note
from .resample import resampled
from .slabs import own_slabs
from .topography import Topography
from .two_scans import combined, interpolated, name_of, spacings_text

POWERS = {
    "mean": [(0, 0)],
    "tilt": [(0, 0), (1, 0), (0, 1)],
    "curvature": [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)],
}  # of x and y


def prepared_size(topography: Topography, spec: Any) -> tuple[tuple[int, int], tuple[float, ...]]:
    """Return the size of what `prepare` will make of a Topography, without reading heights.

    Parameters
    ----------
    topography : Topography
    spec : scene.File

    Returns
    -------
    n : (n_x, n_y)
    sizes : (L_x, L_y)

    Raises
    ------
    SceneError
        If the cropped part is not within the map, or downsample does not divide its points.
    """
    topography = _cropped(topography, spec) if spec.crop else topography
    topography = mirrored(topography, spec.mirrored)
    n_x, n_y = (k * spec.refine for k in topography.n)
    if n_x % spec.downsample or n_y % spec.downsample:
        raise SceneError(
            f"surface.downsample: found {spec.downsample}, allowed: a divisor of {n_x} and of"
            f" {n_y} points"
        )
    return (n_x // spec.downsample, n_y // spec.downsample), topography.sizes


def prepare(topography: Topography, spec: Any, comm: Any, look: bool = False) -> Topography:
    """Prepare a height map as the scene asks for; reads the heights several times. Collective.

    Parameters
    ----------
    topography : Topography
        Not changed.
    spec : scene.File
    comm : Comm
    look : bool
        Whether to look at the quality of the map, too, not only at its edges.

    Returns
    -------
    Topography
        With complete heights; its `prepared` lists the steps and its `notes` remarks on the map.
        After a change of the number of points each rank can read its own rows only.

    Raises
    ------
    SceneError
        On all ranks. The message lists everything that the scene still has to say (units, sizes,
        fill, boundary).
    """
    lacks = list(topography.lacks.values())
    if topography.bodies:
        topography = _of_filled_scans(topography, spec, comm, lacks)
    if lacks:  # only to see what else is
        spec = spec.model_copy(update={"crop": None})
    size, _ = prepared_size(topography, spec)
    if spec.crop:
        topography = _cropped(topography, spec)
    has_window = spec.window != "none"
    detrend = "mean" if has_window and spec.detrend == "none" else spec.detrend
    if detrend != "none":
        topography = _detrended(topography, detrend, comm)
    topography = _filled(topography, spec, comm, lacks)
    try:
        notes = notes_on(topography, spec, comm, look)
        topography = replace(topography, notes=(*topography.notes, *notes))
    except SceneError as error:
        lacks.append(str(error))
    if lacks:
        raise SceneError("; ".join(lacks))
    if spec.flip:
        upright = topography.rows
        topography = topography.after("upside down", rows=lambda start, stop: -upright(start, stop))
    topography = mirrored(topography, spec.mirrored)
    if has_window:
        before = map_quality(topography, comm)
        topography = _windowed(topography, spec.window)
        note = window_note(
            before, map_quality(topography, comm), _kept(topography, spec.window), spec.window
        )
        topography = replace(topography, notes=(*topography.notes, *note))
    if size != topography.n:
        topography = resampled(topography, size, spec.free, comm)
    if spec.radius:
        radii = tuple(topography.length("radius", R) for R in spec.radii)
        texts = ", ".join(dict.fromkeys(map(format_quantity, spec.radii)))
        topography = topography.on_form(radii).after(f"on a form of radius {texts}")
    return topography


def map_edges(topography: Topography, comm: Any) -> Edges:
    """Return how the edges of a map meet. Collective: rank 0 reads some rows."""
    return on_rank_0(comm, "reading the surface", lambda: edges_of(topography.rows, topography.n))


def map_quality(topography: Topography, comm: Any) -> MapQuality:
    """Return the statistics of a map without holes. Collective: rank 0 reads all of it."""

    def measure() -> MapQuality:
        return quality_of(topography.rows(0, topography.n[0]), topography.sizes)

    return on_rank_0(comm, "reading the surface", measure)


def map_form(topography: Topography, comm: Any, edges: Edges, free: tuple[bool, bool]) -> list[str]:
    """Return a note on a map that is curved along an axis where it neither ends nor repeats.

    Collective: rank 0 reads all of it.
    """
    axes = [axis for axis in (0, 1) if not (free[axis] or edges.meet[axis])]

    def measure() -> list[str]:
        heights = topography.rows(0, topography.n[0])
        return form_notes(heights, topography.sizes, topography.unit, axes)

    return on_rank_0(comm, "reading the surface", measure) if axes else []


def notes_on(topography: Topography, spec: Any, comm: Any, look: bool) -> list[str]:
    """Return notes on the edges of a map, what is filled and, if `look`, its quality. Collective.

    Raises SceneError if neither scene nor file gives the boundary and opposite edges do not meet.
    """
    edges = map_edges(topography, comm)
    has_window = spec.window != "none"
    is_told = has_window or spec.boundary is not None or topography.periodic
    if not is_told and (question := edges.question()):
        raise SceneError(f"surface.{question}")
    repeats = [not (free or mirror) for free, mirror in zip(spec.free, spec.mirrored)]
    notes = [] if has_window else edges.notes(repeats)
    if look:
        notes += map_quality(topography, comm).notes()
        if not has_window:
            notes += map_form(topography, comm, edges, spec.free)
    share = topography.filled / np.prod(topography.n)
    if share > DOUBT.filled:
        notes.append(f"{100 * share:.0f} % of the heights are filled, not measured")
    return notes


def _filled(topography: Topography, spec: Any, comm: Any, lacks: list[str]) -> Topography:
    """Fill the holes as spec.fill says. Collective.

    If that is refused the reason is appended to the list `lacks`, and holes are filled
    harmonically.
    """
    try:
        return filled(topography, spec.fill, comm)
    except SceneError as error:
        lacks.append(str(error))
        return filled(topography, "harmonic", comm)


def _of_filled_scans(topography: Topography, spec: Any, comm: Any, lacks: list[str]) -> Topography:
    """Fill the holes of the two scans in topography.bodies and return their sum. Collective.

    The sum has a note on each interpolated scan that does not resolve its own roughness. Appends to
    the list `lacks` as `_filled` does. If a scan lacks sizes or units there is no sum, and the
    first scan is returned (`combined`). Raises SceneError if the scans do not overlap or only one
    has a unit.
    """
    lower, upper = (_filled(scan, spec, comm, lacks) for scan in topography.bodies)
    total = combined((lower, upper), spec)
    if total.lacks:
        return total
    notes = [
        f"{name_of(scan)} does not resolve its own roughness: it says nothing of waves shorter than"
        f" {spacings_text(scan, 2)}, and between its points those up to twice as long are damped"
        for scan in interpolated((lower, upper), spec)
        if map_quality(scan, comm).unresolved > DOUBT.unresolved
    ]
    return replace(total, notes=(*total.notes, *notes))


def _cropped(topography: Topography, spec: Any) -> Topography:
    """Return the part of the map within spec.crop, its limits rounded to grid points.

    It counts as periodic only if the whole map is kept. Raises SceneError if it is not within the
    map.
    """
    ends = []
    for axis in (0, 1):
        step = topography.sizes[axis] / topography.n[axis]
        begin, end = (
            round(topography.length("crop", spec.crop[k]) / step) for k in (axis, axis + 2)
        )
        if not 0 <= begin < end <= topography.n[axis]:
            L_x, L_y = (
                f"{size / topography.plain:.6g} {topography.plain_unit}".strip()
                for size in topography.sizes
            )
            raise SceneError(
                f"surface.crop: found points {begin} to {end} of {topography.n[axis]} along"
                f" {'xy'[axis]}, allowed: [x0, y0, x1, y1] with 0 <= x0 < x1 <= {L_x} and 0 <= y0 <"
                f' y1 <= {L_y}, plain in this unit or as "5 um"'
            )
        ends.append((begin, end))
    (x0, x1), (y0, y1) = ends
    n = x1 - x0, y1 - y0
    sizes = tuple(size * k / m for size, k, m in zip(topography.sizes, n, topography.n))
    return topography.after(
        f"cropped to {n[0]} x {n[1]} points",
        n=n,
        sizes=sizes,
        rows=lambda start, stop: topography.rows(start + x0, stop + x0)[:, y0:y1],
        periodic=topography.periodic if n == topography.n else None,
    )


def _detrended(topography: Topography, trend: str, comm: Any) -> Topography:
    """Subtract the polynomial that fits the measured heights best. Collective; reads all heights.

    trend: "mean", "tilt" (plane) or "curvature" (second degree). After the last two it is open
    whether the map is periodic, even if its file says so.
    """
    powers = POWERS[trend]
    x, y = (2 * np.arange(n) / max(n - 1, 1) - 1 for n in topography.n)

    def terms(start: int, stop: int) -> list[np.ndarray]:
        return [x[start:stop, None] ** i * y[None] ** j for i, j in powers]

    sums = []
    with collective_errors(comm, "reading the surface"):
        for start, stop in own_slabs(topography, comm):
            z = topography.rows(start, stop)
            is_measured = np.isfinite(z)
            values = [term[is_measured] for term in (*terms(start, stop), z)]
            sums.append([[a @ b for b in values] for a in values[:-1]])
    total = np.sum([*chain(*comm.allgather(sums))], axis=0)  # in one order on any ranks
    factors = np.linalg.lstsq(total[:, :-1], total[:, -1])[0]

    def rows(start: int, stop: int) -> np.ndarray:
        return topography.rows(start, stop) - sum(
            factor * term for factor, term in zip(factors, terms(start, stop))
        )

    periodic = topography.periodic if trend == "mean" else None
    return topography.after(f"{trend} removed", rows=rows, periodic=periodic)


def mirrored(topography: Topography, along: tuple[bool, bool]) -> Topography:
    """Return the map with its mirror images: twice as long along the chosen axes."""
    if not any(along):
        return topography
    n_x, n_y = topography.n
    copies = [2 if axis else 1 for axis in along]

    def rows_of_both(start: int, stop: int) -> np.ndarray:
        straight = topography.rows(min(start, n_x), min(stop, n_x))
        turned = topography.rows(2 * n_x - max(stop, n_x), 2 * n_x - max(start, n_x))[::-1]
        return np.concatenate([straight, turned])

    along_x = rows_of_both if along[0] else topography.rows
    beside = (0, n_y) if along[1] else (0, 0)

    return topography.after(
        "mirrored" if all(along) else f"mirrored along {'x' if along[0] else 'y'}",
        n=tuple(k * copy for k, copy in zip(topography.n, copies)),
        sizes=tuple(size * copy for size, copy in zip(topography.sizes, copies)),
        rows=lambda start, stop: np.pad(along_x(start, stop), ((0, 0), beside), "symmetric"),
        periodic=True if all(along) else topography.periodic,
    )


def _windowed(topography: Topography, name: str) -> Topography:
    """Return the map times a window that falls to 0 at the edges, which makes it periodic.

    The mean of the heights must be 0. name: a window of scipy.signal.windows, the same along x and
    y.
    """
    w_x, w_y = _windows(topography, name)
    return topography.after(
        f"window {name}",
        rows=lambda start, stop: topography.rows(start, stop) * w_x[start:stop, None] * w_y,
        periodic=True,
    )


def _windows(topography: Topography, name: str) -> tuple[np.ndarray, ...]:
    """Return the window along x, shape (n_x,), and along y, shape (n_y,), both from 0 to 1.

    name: as for `_windowed`.
    """
    from scipy.signal.windows import get_window

    return tuple(get_window(name, n) for n in topography.n)


def _kept(topography: Topography, name: str) -> float:
    """Return the share of the area in which the product of both windows is at least 1/2.

    name: as for `_windowed`.
    """
    w_x, w_y = _windows(topography, name)
    counts = np.searchsorted(np.sort(w_y), 0.5 / np.maximum(w_x, 1e-300), side="right")
    return float(np.mean(w_y.size - counts) / w_y.size)
