"""What a scene has to say of a height map besides its path, found by reading the map."""

from collections.abc import Callable
from contextlib import suppress
from math import ceil
from pathlib import Path

import numpy as np

from ..parallel.comm import SerialComm
from ..scene import File
from ..scene.surface import CHOICES_TEXT
from ..scene.template import Suggestion
from ..util.errors import ReadingWarning, SceneError, one_line
from ..util.lengths import length_factor
from ..util.quantities import prefixed
from . import instruments
from .build import build_surface
from .contents import contents_of
from .doubtful_numbers import slope_notes
from .files import open_map
from .map_units import missing_keys
from .metadata import unreliable
from .prepare import prepare
from .quality import DOUBT, Edges, MapQuality, edges_of, outliers, per_cent, quality_of
from .topography import Topography, specs_of_bodies, sum_of_bodies, topography_of
from .two_scans import name_of

NEEDED = "TO BE GIVEN, the file does not say it"
NEEDED_OF_TWO = "TO BE GIVEN, here for both or in bodies for each; a file does not say it"
SAYS_FILE = "as the file says"
SHORT = 4  # points of a wave that counts as short
MIDDLE = 1024  # points along an axis whose spectrum is looked at, in the middle of the map
AGREE = 1e-3  # relative difference of sizes that are the same


def suggestion(make: Callable[[dict], File], user_keys: dict) -> Suggestion:
    """Read a map or two scans whole, on this process, and suggest keys of [surface] beside
    user_keys. make(keys) returns a scene.File.
    """
    spec = make(user_keys)
    if spec.bodies:
        return _of_two_scans(spec, make, user_keys)
    topography, missing = _opened(spec)
    metadata = topography.metadata
    result = Suggestion(dict(user_keys), unit=topography.unit, missing=missing)
    unit = metadata.sizes_unit or user_keys.get("xy_unit") or metadata.unit or user_keys.get("unit")
    if metadata.sizes is not None and (unit is None or length_factor(unit)):
        sizes = _readable(metadata.sizes, unit) if unit else list(metadata.sizes)
        result.from_file["physical_sizes"] = sizes
        if unit:
            result.from_file["crop"] = ["0 m", "0 m", *sizes]
        in_file = metadata.sizes_unit or user_keys.get("xy_unit") or metadata.unit
        _require_agreement(metadata.sizes, in_file, topography, user_keys)
    if metadata.unit is not None:
        result.from_file["unit"] = metadata.unit
    result.about += _about(topography, missing, user_keys)
    by_file = result.from_file.keys() - user_keys.keys() - {"crop"}
    result.why = dict.fromkeys(by_file, SAYS_FILE) | dict.fromkeys(result.missing, NEEDED)
    _by_heights(result, make, user_keys, topography)
    _by_instrument(result, topography, spec)
    return result


def _opened(spec: File) -> tuple[Topography, list[str]]:
    """Return a map, with placeholders for sizes and units to be given, and the keys of these."""
    data, metadata = open_map(spec)
    missing = missing_keys(metadata, spec, spec.path)
    if missing:
        plain = {"physical_sizes": metadata.sizes or (1.0, 1.0), "xy_unit": None, "crop": None}
        spec = spec.model_copy(update=plain)
    return topography_of(data, metadata, spec), list(missing)


def _of_two_scans(spec: File, make: Callable[[dict], File], user_keys: dict) -> Suggestion:
    """Return the Suggestion for two scans, which are not added if a key is missing."""
    scans = [_opened(of_body) for of_body in specs_of_bodies(spec)]
    missing = list(dict.fromkeys(key for _, keys in scans for key in keys))
    units = {scan.unit for scan, _ in scans}
    result = Suggestion(dict(user_keys), unit=min(units), missing=missing)
    result.silent = [name_of(scan) for scan, keys in scans if keys]
    why = NEEDED_OF_TWO
    if len(result.silent) == 1:
        why = f"TO BE GIVEN in bodies, for {result.silent[0]}, which does not say it"
    result.why = dict.fromkeys(missing, why)
    for scan, keys in scans:
        result.about += [f"{name_of(scan)}: {line}" for line in _about(scan, keys, user_keys)]
    if missing:
        return result
    of_sum = Suggestion(result.values, why=result.why)
    _by_heights(of_sum, make, user_keys, sum_of_bodies([scan for scan, _ in scans], spec))
    result.open = of_sum.open
    result.about += [f"sum: {line}" for line in of_sum.about]
    return result


def _about(topography: Topography, missing: list[str], user_keys: dict) -> list[str]:
    """Return lines on what was read, and on what is missing."""
    metadata = topography.metadata
    sizes = "of sizes that the file does not say"
    if "physical_sizes" not in missing:
        scale, name = prefixed(topography.sizes, topography.unit)
        sizes = " x ".join(f"{size / scale:.10g} {name}".strip() for size in topography.sizes)
    unit = metadata.unit or user_keys.get("unit")
    n = topography.n
    lines = [
        f"{n[0]} x {n[1]} points, {sizes}, heights in"
        f" {unit or 'a unit that the file does not name'}",
        f"read as {metadata.reader}; x runs {_direction(topography)}",
    ]
    if metadata.channel:
        other_names = one_line(", ".join(metadata.other_channels))
        lines.append(
            f"channel {metadata.channel}" + (f"; others: {other_names}" if other_names else "")
        )
    lines += metadata.remarks
    return lines + _not_on_reading(topography)


def _not_on_reading(topography: Topography) -> list[str]:
    """Return the notes on a map except for those on how it was read, which `_about` says itself."""
    return [str(note) for note in topography.notes if not isinstance(note, ReadingWarning)]


def _direction(topography: Topography) -> str:
    """Return a phrase on the direction of x, and how to set it if the file does not."""
    metadata = topography.metadata
    turned = [axis for axis, falls in zip("xy", metadata.falling) if falls]
    text = metadata.direction
    if turned:
        text += f"; the coordinates along {' and '.join(turned)} fall in the file: it is turned"
    if metadata.direction_known:
        return text
    return f'{text} (surface.first_axis = "y" says that y does)'


def _require_agreement(
    sizes: tuple[float, ...], unit: str | None, topography: Topography, user_keys: dict
) -> None:
    """Raise SceneError if the user's sizes differ by more than 0.1 % from those of the file."""
    wanted = user_keys.get("physical_sizes")
    if wanted is None:
        return
    scale = length_factor(unit) if unit else 1.0
    in_file = [size * (scale or 1.0) for size in sizes]
    if bool(unit) == bool(topography.unit) and not np.allclose(in_file, topography.sizes, AGREE, 0):
        texts = _readable(sizes, unit) if unit else list(sizes)
        raise SceneError(
            f"surface.physical_sizes: found {wanted}, but {topography.path} says {texts}, allowed:"
            " no surface.physical_sizes, or the file's own (those of a scene hold, with a note)"
        )


def _by_instrument(result: Suggestion, topography: Topography, spec: File) -> None:
    """Suggest, as a comment, the smallest downsampling without waves made by the instrument."""
    with suppress(Exception):  # of a file that SurfaceTopography does not read
        contents = contents_of(Path(str(spec.path)))
        scan = instruments.topography_of_channel(contents, spec.dataset)
        cutoff, why = unreliable(scan) or (0.0, "")
        factors = (ceil(cutoff * n / (2 * L)) for n, L in zip(topography.n, topography.sizes))
        smallest_factor = max(factors)
        divisors = [
            k
            for k in range(smallest_factor, topography.n[0])
            if not any(n % k for n in topography.n)
        ]
        if smallest_factor > 1 and divisors:
            result.about.append(f"{why}; surface.downsample = {divisors[0]} removes them")
            result.from_file["downsample"] = divisors[0]
            result.why["downsample"] = why


def _readable(sizes: tuple[float, ...], unit: str) -> list[str]:
    """Write sizes that are in `unit`, a unit of length, with a readable one: ["10 um", "8 um"]."""
    lengths = [size * (length_factor(unit) or 1.0) for size in sizes]
    scale, name = prefixed(lengths, "m")
    return [f"{length / scale:.10g} {name}" for length in lengths]


def _by_heights(
    result: Suggestion, make: Callable[[dict], File], user_keys: dict, topography: Topography
) -> None:
    """Suggest by the prepared heights what the user has not set: fill, detrend if mostly tilt, and
    boundary "mirror" if edges do not meet and neither period nor window is given.
    """
    values = result.values
    filled: dict[str, object] = {"fill": "harmonic"}
    if result.missing:
        filled["crop"] = None
    plain: dict[str, object] = {"radius": None, "refine": 1, "downsample": 1}
    if "boundary" not in user_keys:
        plain["boundary"] = "periodic"

    def prepared_map() -> tuple[Topography, MapQuality, Edges]:
        heights = prepare(topography, make(values | filled | plain), look=True)
        quality = quality_of(heights.heights(), heights.sizes)
        return heights, quality, edges_of(heights)

    heights, quality, meeting = prepared_map()
    _by_missing_points(result, heights.filled, user_keys)
    stray = outliers(heights.heights(), quality.typical)
    if _by_tilt(result, quality.tilt, user_keys):
        heights, quality, meeting = prepared_map()
    edges = f"opposite edges differ by {max(meeting.jumps):.2g} times what neighbours differ by"
    result.about.append(edges)
    if stray:
        result.about.append(
            f"{stray} points stand out of their neighbours by more than {DOUBT.outlying:g} times"
            " what neighbours differ by: dust or spikes? They are pressed as they are;"
            ' spikes = "median" removes them'
        )
    result.about.append(f"done to it: {', '.join(heights.prepared) or 'nothing'}")
    is_open = not (
        all(meeting.meet) or topography.periodic or {"boundary", "window"} & user_keys.keys()
    )
    if is_open:
        _open_boundary(result)
    spec = make({"boundary": "periodic"} | values | filled)
    pressed = build_surface(spec, SerialComm(), float, opened=lambda: topography)
    scale, name = prefixed([pressed.h_rms], heights.unit)
    result.about.append(
        f"h_rms = {pressed.h_rms / scale:.4g} {name}".strip()
        + ("" if result.missing else f", g_rms = {pressed.g_rms:.4g}")
    )
    if pressed.g_rms > 0 and not result.missing:
        z = heights.heights()
        result.about += filter(None, [_bandwidth_line(z, heights.sizes, heights.unit)])
    of_edges = meeting.notes((True, True)) if is_open else []  # which do not meet as mirror images
    known_lines = [*result.about, *map(str, of_edges)]
    result.about += [note for note in _not_on_reading(heights) if note not in known_lines]
    if not result.missing:
        result.about += map(str, slope_notes(pressed.g_rms, measured=True))


def _by_missing_points(result: Suggestion, filled: int, user_keys: dict) -> None:
    """Say how many points have no height, and suggest to fill them."""
    refusal = ', which surface.fill = "none" refuses: the scene does not run'
    is_refused = filled and user_keys.get("fill") == "none"
    result.about.append(f"{filled or 'no'} points without a height{refusal * is_refused}")
    if filled and "fill" not in user_keys:
        result.values["fill"] = "harmonic"
        result.why["fill"] = f"{filled} points have no height"


def _by_tilt(result: Suggestion, share: float, user_keys: dict) -> bool:
    """Say which share of the variance of the heights is tilt; return whether to remove it, which
    is then suggested.
    """
    tilt = f"{per_cent(share)} % of the variance of the heights is tilt"
    is_set = "detrend" in user_keys
    is_left = DOUBT.slight_tilt < share <= DOUBT.tilt and not is_set
    result.about.append(f'{tilt} (surface.detrend = "tilt" removes it)' if is_left else tilt)
    if share <= DOUBT.tilt or is_set:
        return False
    result.values["detrend"] = "tilt"
    result.why["detrend"] = tilt
    return True


def _open_boundary(result: Suggestion) -> None:
    """Suggest a boundary that only the user can know, and say what the others would be."""
    result.open = ["boundary"]
    result.values["boundary"] = "mirror"
    result.why["boundary"] = f"chosen for you, one of {CHOICES_TEXT}"
    result.about += [
        'boundary = "mirror" is written: a piece of a larger surface, which goes on as mirror'
        " images of the map (four times the points)",
        'boundary = "free" would be a body that ends where the map ends (ball, lens, pin):'
        " high pressure at its edges, and nothing beyond them that bears load",
        'boundary = "periodic" would repeat the map and press the step at its edges, too',
    ]


def _bandwidth_line(z: np.ndarray, sizes: tuple[float, ...], unit: str) -> str:
    """Return a line on the share of g_rms^2 at the shortest waves and what it does to a_r, which at
    light loads goes as 1/g_rms. z: heights (n_x, n_y), periodic or not.
    """
    spacings = np.divide(sizes, z.shape)
    starts = [max(n - MIDDLE, 0) // 2 for n in z.shape]
    middle = z[tuple(slice(start, start + MIDDLE) for start in starts)]
    window = np.multiply.outer(*(np.hanning(n + 2)[1:-1] for n in middle.shape))
    power = np.abs(np.fft.fft2((middle - middle.mean()) * window)) ** 2
    q_x, q_y = (np.fft.fftfreq(n, a) for n, a in zip(middle.shape, spacings))
    squared = q_x[:, None] ** 2 + q_y**2
    slopes = squared * power
    if not slopes.any():
        return ""
    shortest = SHORT * max(spacings)
    share = float(slopes[squared > 1 / shortest**2].sum() / slopes.sum())
    scale, name = prefixed([shortest], unit)
    text = (
        f"waves shorter than {shortest / scale:.3g} {name}".strip()
        + f" ({SHORT} points) have {100 * share:.2g} % of g_rms^2"
    )
    if share < 0.01:
        return text
    return (
        f"{text}: without them a_r at light loads would be {(1 - share) ** -0.5:.2f} times as"
        " large, and it is smaller by those that the instrument does not see"
    )
