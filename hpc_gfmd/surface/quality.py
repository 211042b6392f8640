"""What the statistics of a map say about it, and whether opposite edges meet; only the edges, a few
rows, are looked at before every solve.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..scene.surface import CHOICES_TEXT
from ..util.errors import SceneError, SurfaceWarning
from ..util.quantities import prefixed
from .topography import Topography


@dataclass(frozen=True)
class Doubt:
    """Thresholds above which a height map triggers a note (chosen by hand)."""

    tilt: float = 0.5  # share of the variance of the heights that is tilt
    slight_tilt: float = 0.05  # likewise, for a hint
    # Mean square slope between neighbours over that between second neighbours: near 1 if the grid
    # resolves the spectrum.
    unresolved: float = 1.2
    filled: float = 0.1  # share of the points that had no height
    jump: float = 3.0  # difference between opposite edges over that between neighbours
    kink: float = 8.0  # change of slope at the edge over that inside
    # Distance of a height from the median of its neighbours over the difference of neighbours.
    outlying: float = 10.0
    faded: float = 0.1  # relative change of h_rms or g_rms by a window
    curved: float = 3.0  # sag of a form over the rms of the rest
    # opposite edges that differ by less than this share of the heights are equal
    rounding: float = 1e-12


DOUBT = Doubt()
GROUPS = 16  # places along x where three neighbouring rows are looked at
LATTICE = 200  # points along an axis at which medians are taken, at most about twice as many
FORM_POINTS = 512  # along an axis at which a form is fitted, at most about twice as many
LAG = 16  # points over which the slope of a tilt is taken, at most


@dataclass(frozen=True)
class Edges:
    """How opposite edges of a map meet, along x and y, compared with its inside."""

    # difference between last and first point over that between neighbours
    jumps: tuple[float, float]
    kinks: tuple[float, float]  # change of slope at the edge over that inside

    @property
    def meet(self) -> tuple[bool, bool]:
        """Whether opposite edges meet without a jump or a kink, along x and y."""
        x, y = (
            jump <= DOUBT.jump and kink <= DOUBT.kink for jump, kink in zip(self.jumps, self.kinks)
        )
        return x, y

    def require_meeting(self, key: str) -> None:
        """Raise SceneError, which asks for the boundary by its key, unless all edges meet."""
        for axis, jump, kink, meet in zip("xy", self.jumps, self.kinks, self.meet):
            if meet:
                continue
            how = (
                f"differ by {jump:.3g} times what neighbouring points differ by"
                if jump > DOUBT.jump
                else f"meet in a kink, {kink:.3g} times as sharp as inside"
            )
            raise SceneError(
                f"{key}: not given, and opposite edges along {axis} {how}, allowed:"
                f" {CHOICES_TEXT}; one for each axis if they differ"
            )

    def notes(self, meet: Sequence[bool]) -> list[SurfaceWarning]:
        """Return a note for each axis along which edges that meet have a jump or a kink."""
        texts = []
        for axis, jump, kink, edges_meet in zip("xy", self.jumps, self.kinks, meet):
            if edges_meet and jump > DOUBT.jump:
                texts.append(
                    f"opposite edges along {axis} differ by {jump:.3g} times what neighbouring"
                    " points differ by: the jump is pressed, too"
                )
            elif edges_meet and kink > DOUBT.kink:
                texts.append(
                    f"opposite edges along {axis} meet in a kink: the slope changes there"
                    f' {kink:.3g} times as much as inside (boundary = "free" for a single body,'
                    " such as a lens)"
                )
        return list(map(SurfaceWarning, texts))


def notes_on(topography: Topography, spec: Any, look: bool) -> list[SurfaceWarning]:
    """Return notes on edges, filling and, if `look`, quality; SceneError without a boundary."""
    edges = edges_of(topography)
    has_window = spec.window != "none"
    if not (has_window or spec.boundary is not None or topography.periodic):
        edges.require_meeting("surface.boundary")
    repeats = [not (free or mirror) for free, mirror in zip(spec.free, spec.mirrored)]
    notes = [] if has_window else edges.notes(repeats)
    if look:
        notes += quality_of(topography.heights(), topography.sizes).notes()
        axes = [axis for axis in (0, 1) if not (spec.free[axis] or edges.meet[axis])]
        if axes and not has_window:  # curved where it neither ends nor repeats
            notes += form_notes(topography.heights(), topography.sizes, topography.unit, axes)
    share = topography.filled / np.prod(topography.n)
    if share > DOUBT.filled:
        text = f"{100 * share:.0f} % of the heights are filled, not measured"
        notes.append(SurfaceWarning(text))
    return notes


@np.errstate(invalid="ignore")  # infinite heights are refused where all are read
def edges_of(topography: Topography) -> Edges:
    """Return how the edges of a map without holes meet, by at most 3 GROUPS rows."""
    n = topography.n
    height = min(3, n[0])
    starts = sorted({round(k * (n[0] - height) / (GROUPS - 1)) for k in range(GROUPS)})
    groups = np.array([topography.rows(start, start + height) for start in starts])
    columns = groups[:, :, :: max(n[1] // LATTICE, 1)]
    ends = columns[-1, -2 % height], columns[-1, -1], columns[0, 0], columns[0, 1 % height]
    jump_x, kink_x = _jump_and_kink(columns.swapaxes(0, 1), np.array(ends))
    rows = np.concatenate([groups[:, 0], groups[-1, -1:]]).T
    jump_y, kink_y = _jump_and_kink(rows, rows[[-2 % n[1], -1, 0, 1 % n[1]]])
    return Edges((jump_x, jump_y), (kink_x, kink_y))


def _jump_and_kink(inside: np.ndarray, ends: np.ndarray) -> tuple[float, float]:
    """Return jump and kink along the first axis; ends: the last two points and the first two."""
    steps = inside[1:] - inside[:-1]
    steps_of_ends = ends[1:] - ends[:-1]
    step, bend, jump, kink = (
        _median(_sizes(differences))
        for differences in (
            steps,
            steps[1:] - steps[:-1],
            steps_of_ends[1],
            steps_of_ends[1:] - steps_of_ends[:-1],
        )
    )
    rounding = DOUBT.rounding * np.abs(ends).max()
    jumps = jump > rounding and step > 0
    kinks = kink > rounding and bend > rounding
    return jump / step if jumps else 0.0, kink / bend if kinks else 0.0


@dataclass(frozen=True)
class MapQuality:
    """Statistics of a map; points are compared by medians, robust against outliers."""

    typical: float  # median difference between neighbours, the larger one of both axes
    # share of the variance that a plane with the median slope removes, so not that of a step
    tilt: float
    unresolved: float  # measure of unresolved roughness, see Doubt; the larger one of both axes
    h_rms: float
    g_rms: float  # from differences between neighbours

    def notes(self) -> list[SurfaceWarning]:
        """Return notes on tilt and an unresolved spectrum."""
        texts = []
        if self.tilt > DOUBT.tilt:
            texts.append(
                f'{per_cent(self.tilt)} % of the variance of the heights is tilt (detrend = "tilt"'
                " removes it)"
            )
        if self.unresolved > DOUBT.unresolved:
            texts.append(
                "the spectrum is not resolved: it has power at the shortest waves of the grid, so"
                " that more points would change g_rms and the area"
            )
        return list(map(SurfaceWarning, texts))


def quality_of(z: np.ndarray, sizes: tuple[float, ...]) -> MapQuality:
    """Return the statistics of heights (n_x, n_y) without holes on an area of these sizes."""
    mean = z.mean()
    variance = z.var(mean=mean)
    taken_by_plane = 0.0
    squares = 0.0  # of slopes
    steps = []
    ratios = []
    for axis, (n, size) in enumerate(zip(z.shape, sizes)):
        lag = min(LAG, max(n // 8, 1))
        step, second, far = _differences(np.moveaxis(z, axis, 0), lag)
        x = np.arange(n) - (n - 1) / 2
        profile = z.mean(axis=1 - axis) - mean
        slope = far / lag
        taken_by_plane += slope * (2 * x @ profile / n - slope * x.var())
        between = np.diff(z, axis=axis).ravel()
        squares += between @ between / max(between.size, 1) * (n / size) ** 2
        del between
        steps.append(step)
        ratios.append((2 * step / second) ** 2 if second > 0 else 0.0)
    return MapQuality(
        typical=max(steps),
        tilt=max(float(taken_by_plane / variance), 0.0) if variance > 0 else 0.0,
        unresolved=max(ratios),
        h_rms=float(np.sqrt(variance)),
        g_rms=float(np.sqrt(squares)),
    )


def _differences(z: np.ndarray, lag: int) -> tuple[float, float, float]:
    """Return medians along the first axis of |differences| to the next and second next point,
    without zeros, and of signed ones to the point `lag` further; 0 where there are none.
    """
    every_row, every_column = (max(n // LATTICE, 1) for n in z.shape)
    columns = z[:, ::every_column]

    def to_point(distance: int) -> np.ndarray:
        return (columns[distance:] - columns[: len(z) - distance])[::every_row]

    step, second = (_median(_sizes(to_point(k))) if k < len(z) else 0.0 for k in (1, 2))
    return step, second, _median(to_point(lag)) if lag < len(z) else 0.0


def _sizes(differences: np.ndarray) -> np.ndarray:
    """Return the magnitudes of those that are not 0: rounded heights often differ by exactly 0."""
    sizes = np.abs(differences)
    return sizes if sizes.all() else sizes[sizes != 0]


def _median(values: np.ndarray) -> float:
    if not values.size:
        return 0.0
    above = values.size // 2
    ordered = np.partition(values, above, axis=None)  # a fifth of the time of np.median
    below = ordered[above] if values.size % 2 else ordered[:above].max()
    return float((below + ordered[above]) / 2)


def per_cent(share: float) -> str:
    """Return a share in per cent; 100 is all, and not 99.9."""
    return f"{100 * share:.0f}" if share < 0.99 or share >= 1 else f"{min(100 * share, 99.9):.1f}"


def form_notes(
    z: np.ndarray, sizes: tuple[float, ...], unit: str, axes: Sequence[int]
) -> list[SurfaceWarning]:
    """Return a note on a map that is curved along these axes: the sag, between middle and edges, of
    the best paraboloid without a mixed term.
    """
    every_row, every_column = (max(n // FORM_POINTS, 1) for n in z.shape)
    z = z[::every_row, ::every_column]
    x, y = (np.linspace(-1, 1, n) for n in z.shape)
    terms = [np.ones(z.shape), *np.meshgrid(x, y, indexing="ij")]
    terms += [terms[1] ** 2, terms[2] ** 2]
    design = np.stack([term.ravel() for term in terms], axis=1)
    factors, *_ = np.linalg.lstsq(design, (z - z.mean()).ravel())
    rest = np.std(z.ravel() - design @ factors)
    sags = [-float(factors[3 + axis]) for axis in (0, 1)]  # > 0: the middle is high
    curved = [axis for axis in axes if abs(sags[axis]) > DOUBT.curved * rest]
    if not curved:
        return []
    bent = " and ".join(
        f"along {'xy'[axis]} by {_length_text(abs(sags[axis]), unit)} (radius"
        f" {_length_text(sizes[axis] ** 2 / (8 * abs(sags[axis])), unit)})"
        for axis in curved
    )
    return [
        SurfaceWarning(
            f"the map is curved, {bent}, more than {DOUBT.curved:g} times the rms of the rest: a"
            ' ball, lens or cylinder ends where the map ends, boundary = "free"; detrend ='
            ' "curvature" with radius puts the roughness on an ideal form'
        )
    ]


def _length_text(length: float, unit: str) -> str:
    scale, name = prefixed([length], unit)
    return f"{length / scale:.3g} {name}".strip()


def window_notes(
    before: MapQuality, after: MapQuality, kept: float, name: str
) -> list[SurfaceWarning]:
    """Return a note on a window that changes h_rms or g_rms; kept: area share where it is > 1/2."""

    def change(old: float, new: float) -> float:
        return abs(new / old - 1) if old else 0.0

    if max(change(before.h_rms, after.h_rms), change(before.g_rms, after.g_rms)) < DOUBT.faded:
        return []
    text = (
        f"the window {name} takes h_rms from {before.h_rms:.3g} to {after.h_rms:.3g} and g_rms from"
        f" {before.g_rms:.3g} to {after.g_rms:.3g}; {100 * kept:.0f} % of the area keep more than"
        " half of their heights and bear the load: area and gap are not those of the map"
    )
    return [SurfaceWarning(text)]


def outliers(z: np.ndarray, typical: float) -> int:
    """Count points farther from the median of eight neighbours than DOUBT.outlying times the
    typical difference; 0 for fewer than three rows or columns.
    """
    if min(z.shape) < 3:
        return 0
    return int(np.count_nonzero(np.abs(z - _around(z)) > DOUBT.outlying * typical))


def without_outliers(z: np.ndarray) -> tuple[np.ndarray, int]:
    """Return heights with each of `outliers` at the median of its neighbours, and their number."""
    if min(z.shape) < 3:
        return z, 0
    typical = 0.0
    for axis in (0, 1):
        steps = np.diff(z, axis=axis)
        median = np.nanmedian(np.abs(steps, out=steps), overwrite_input=True)
        typical = max(typical, float(median))
        del steps
    around = _around(z)
    distances = z - around
    stray = np.abs(distances, out=distances) > DOUBT.outlying * typical
    del distances
    return np.where(stray, around, z), int(np.count_nonzero(stray))


def _around(z: np.ndarray) -> np.ndarray:
    """Return the median of the eight neighbours of each point, of those that have a height."""
    from scipy.ndimage import binary_dilation, median_filter

    beside = np.ones((3, 3))
    beside[1, 1] = 0
    around = median_filter(z, footprint=beside, mode="mirror")
    i, j = np.nonzero(binary_dilation(np.isnan(z), beside))  # where nan would spoil the order
    bordered = np.pad(z, 1, "reflect")
    places = np.argwhere(beside)
    neighbours = np.array([bordered[i + di, j + dj] for di, dj in places])
    has_height = np.isfinite(neighbours).any(axis=0)
    around[i, j] = np.nan
    around[i[has_height], j[has_height]] = np.nanmedian(neighbours[:, has_height], axis=0)
    return around
