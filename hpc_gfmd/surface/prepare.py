"""The preparation of a measured map that the scene asks for.

Order: crop, spikes, detrend (by measured points), fill, flip, mirror or window, refine, downsample,
form; two scans are filled before they are added. One process prepares the whole map; a map in a
file that needs no step is never read whole.
"""

from dataclasses import replace
from math import prod
from typing import Any

import numpy as np

from ..util.errors import SceneError, SurfaceWarning
from ..util.quantities import format_quantity
from .fill import copies_of_filling, filled
from .heights import ROWS, StoredRows
from .quality import DOUBT, notes_on, quality_of, window_notes, without_outliers
from .topography import Topography
from .two_scans import combined, interpolated, name_of, spacings_text

# Copies of a map that a step holds at once, however many points are missing; see fill.py, too.
COPIES = {"spikes": 3.2, "detrend": 2.3, "flip": 2.1, "window": 3.2}
ADDED = 3.0  # likewise of the sum of two scans, beside these
PIECE = 2.4  # of the rows that are read or mirrored at a time
TRANSFORMED = 4.0  # of the lines that are transformed at a time
LINES = 64  # transformed at a time
IDLE = ("none", "keep", False)
POWERS = {
    "mean": [(0, 0)],
    "tilt": [(0, 0), (1, 0), (0, 1)],
    "curvature": [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)],
}  # of x and y


def prepared_size(topography: Topography, spec: Any) -> tuple[tuple[int, int], tuple[float, ...]]:
    """Return points and sizes of what `prepare` will make, without reading heights."""
    topography = _cropped(topography, spec) if spec.crop else topography
    topography = topography.mirrored(spec.mirrored)
    n_x, n_y = (k * spec.refine for k in topography.n)
    if n_x % spec.downsample or n_y % spec.downsample:
        raise SceneError(
            f"surface.downsample: found {spec.downsample}, allowed: a divisor of {n_x} and of"
            f" {n_y} points"
        )
    return (n_x // spec.downsample, n_y // spec.downsample), topography.sizes


def bytes_of_preparing(topography: Topography, spec: Any) -> float:
    """Return how many bytes reading and preparing a map take at most, on the process that does; a
    map that is to be filled is read by rows.
    """
    cropped = _cropped(topography, spec) if spec.crop else topography
    part = prod(cropped.n)
    copies = max((COPIES[key] for key in COPIES if getattr(spec, key) not in IDLE), default=1.0)
    mirrored = part * 2 ** sum(spec.mirrored)
    before_mirroring = part if mirrored > part else 0
    step = spec.downsample / spec.refine
    width = topography.n[1] * (1 + spec.mirrored[1])
    piece = PIECE * ROWS * width
    numbers = [copies * part]
    if spec.fill not in IDLE:
        maps = topography.bodies or (cropped,)
        beside = [(copies_of_filling(a_map) - 1) * prod(a_map.n) for a_map in maps]
        numbers.append(max(beside) + sum(prod(a_map.n) for a_map in maps))
    if mirrored > part:
        numbers.append(before_mirroring + mirrored + piece)
    if step != 1:
        lines = TRANSFORMED * LINES * width / min(step, 1)
        numbers.append(before_mirroring + mirrored + (step + 1) * mirrored / step**2 + lines)
    if topography.bodies:
        reading = sum(prod(scan.n) for scan in topography.bodies) + ADDED * part
    else:
        reading = part + piece
    return max(topography.reading, topography.stored + 8 * reading, 8 * max(numbers))


def asks_for_preparation(spec: Any) -> bool:
    """Whether a [surface] asks for a step for which a map is read whole, unlike a form."""
    return (
        bool(spec.bodies or spec.crop or spec.flip)
        or any(spec.mirrored)
        or (spec.detrend, spec.fill, spec.window) != ("none", "none", "none")
        or spec.spikes != "keep"
        or (spec.refine, spec.downsample) != (1, 1)
    )


def prepare(topography: Topography, spec: Any, look: bool = False) -> Topography:
    """Prepare a map as the scene asks for, on one process, with notes on its quality if `look`."""
    if topography.bodies:
        topography = _of_filled_scans(topography, spec)
    size, _ = prepared_size(topography, spec)
    if spec.crop:
        topography = _cropped(topography, spec)
    topography = replace(topography, rows=StoredRows(topography.heights()))
    if spec.spikes == "median":
        z, number = without_outliers(topography.heights())
        topography = topography.of_heights(z, f"{number} spikes replaced by medians")
    has_window = spec.window != "none"
    detrend = "mean" if has_window and spec.detrend == "none" else spec.detrend
    if detrend != "none":
        topography = _detrended(topography, detrend)
    topography = filled(topography, spec.fill)
    notes = notes_on(topography, spec, look)
    topography = replace(topography, notes=(*topography.notes, *notes))
    if spec.flip:
        topography = topography.of_heights(-topography.heights(), "upside down")
    topography = topography.mirrored(spec.mirrored)
    if has_window:
        topography = _windowed(topography, spec.window)
    if size != topography.n:
        z = _resampled(topography.heights(), size, spec.free)
        topography = topography.of_heights(z, f"resampled to {size[0]} x {size[1]} points")
    return on_radius(topography, spec)


def complete(topography: Topography) -> Topography:
    """Return a map whose `rows` raise SceneError where a height is missing."""

    def rows(start: int, stop: int) -> np.ndarray:
        z = topography.rows(start, stop)
        i, j = np.nonzero(np.isnan(z))
        if len(i):
            raise SceneError(
                f"surface.path: found nan at ({start + i[0]}, {j[0]}) in {topography.path},"
                f" {len(i)} points without a height in rows {start} to {stop - 1}, allowed: finite"
                ' heights, or fill = "harmonic" where some are known'
            )
        return z

    return replace(topography, rows=rows)


def on_radius(topography: Topography, spec: Any) -> Topography:
    """Return the map on the form of radius spec.radius; as it is without one."""
    if not spec.radius:
        return topography
    radii = tuple(topography.length("radius", R) for R in spec.radii)
    texts = ", ".join(dict.fromkeys(map(format_quantity, spec.radii)))
    return topography.on_form(radii).after(f"on a form of radius {texts}")


def _of_filled_scans(topography: Topography, spec: Any) -> Topography:
    """Fill the scans in topography.bodies and add them, with notes on unresolved roughness."""
    scans = filled(topography.bodies[0], spec.fill), filled(topography.bodies[1], spec.fill)
    total = combined(scans, spec)
    notes = [
        SurfaceWarning(
            f"{name_of(scan)} does not resolve its own roughness: it says nothing of waves shorter"
            f" than {spacings_text(scan, 2)}, and between its points those up to twice as long are"
            " damped"
        )
        for scan in interpolated(scans, spec)
        if quality_of(scan.heights(), scan.sizes).unresolved > DOUBT.unresolved
    ]
    z = total.rows(0, total.n[0])  # not by pieces: each would interpolate the scans
    return replace(total, rows=StoredRows(z), bodies=(), notes=(*total.notes, *notes))


def _cropped(topography: Topography, spec: Any) -> Topography:
    """Return the map within spec.crop, rounded to grid points; periodic only if all is kept."""
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


def _detrended(topography: Topography, trend: str) -> Topography:
    """Subtract the best "mean", "tilt" or "curvature"; after the latter two the period is open."""
    z = topography.heights()
    is_measured = np.isfinite(z)
    if not is_measured.any():
        return topography
    mean = np.mean(z, where=is_measured)
    x, y = (np.vander(np.linspace(-1, 1, n) if n > 1 else [-1.0], 5) for n in z.shape)
    x, y = x[:, ::-1], y[:, ::-1]  # column i: x^i
    moments = x.T @ is_measured.astype(np.float64) @ y
    deviations = z - mean
    deviations[~is_measured] = 0.0
    moments_of_heights = x.T @ deviations @ y
    powers = POWERS[trend]
    gram = [[moments[i + k, j + m] for k, m in powers] for i, j in powers]
    factors = np.zeros((5, 5))
    fit = np.linalg.lstsq(gram, [moments_of_heights[power] for power in powers])[0]
    factors[tuple(np.transpose(powers))] = fit
    trend_removed = np.matmul(x @ factors, y.T, out=deviations)
    trend_removed += mean
    np.subtract(z, trend_removed, out=trend_removed)
    periodic = topography.periodic if trend == "mean" else None
    return topography.of_heights(trend_removed, f"{trend} removed", periodic=periodic)


def _windowed(topography: Topography, name: str) -> Topography:
    """Return the map, of mean 0, times a window that makes it periodic, and a note on that."""
    from scipy.signal.windows import get_window

    w_x, w_y = (get_window(name, n) for n in topography.n)
    z = topography.heights() * w_x[:, None]
    z *= w_y
    windowed = topography.of_heights(z, f"window {name}", periodic=True)
    counts = np.searchsorted(np.sort(w_y), 0.5 / np.maximum(w_x, 1e-300), side="right")
    kept = float(np.mean(w_y.size - counts) / w_y.size)  # where the window is at least 1/2
    before, after = (quality_of(a_map.heights(), a_map.sizes) for a_map in (topography, windowed))
    notes = window_notes(before, after, kept, name)
    return replace(windowed, notes=(*windowed.notes, *notes))


def _resampled(z: np.ndarray, n: tuple[int, int], free: tuple[bool, bool]) -> np.ndarray:
    """Return heights resampled to n points along x and y by Fourier series, of cosines along free
    axes, which have no jump at the edge; with fewer points the shortest waves are lost.
    """
    along_y = np.empty((z.shape[0], n[1]))
    _transform_lines(z, along_y, free[1])
    along_both = np.empty(n)
    _transform_lines(along_y.T, along_both.T, free[0])
    return along_both


def _transform_lines(lines: np.ndarray, out: np.ndarray, is_free: bool) -> None:
    """Resample lines to those of `out`, by cosines if their ends are free."""
    from scipy.fft import dct, idct
    from scipy.signal import resample

    n = out.shape[1]
    for i in range(0, len(lines), LINES):
        piece = lines[i : i + LINES]
        out[i : i + LINES] = (
            idct(dct(piece, norm="forward"), n=n, norm="forward")
            if is_free
            else resample(piece, n, axis=1)
        )
