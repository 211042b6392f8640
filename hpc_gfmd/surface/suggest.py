"""What a scene has to say of a height map beside its path, found by reading it."""

from collections.abc import Callable
from contextlib import suppress
from math import ceil

from ..parallel.comm import SerialComm
from ..scene import File
from ..scene.template import Suggestion
from ..util.quantities import factor, prefixed
from . import instruments
from .arrays import unreliable
from .prepare import prepare
from .quality import DOUBT, MapQuality, outliers, quality_of
from .topography import Topography, open_topography

NEEDED = "TO BE GIVEN, the file does not say it"


def suggestion(make: Callable[[dict], File], given: dict) -> Suggestion:
    """Read the map of make({}) and suggest what a scene says of it; make(values): scene.File with
    these values; given: what the user has said already.

    Raises SceneError for a file that cannot be read.
    """
    found, opened = Suggestion(dict(given)), open_topography(make(given))
    found.unit = opened.unit
    said = opened.said
    about = f"{opened.n[0]} x {opened.n[1]} points"
    if said.sizes is not None:
        unit = said.sizes_unit or said.unit
        found.said["physical_sizes"] = _readable(said.sizes, unit) if unit else list(said.sizes)
        if unit:
            found.said["crop"] = ["0 m", "0 m", *found.said["physical_sizes"]]
        about += f", {found.said['physical_sizes'][0]} x {found.said['physical_sizes'][1]}"
    if said.unit is not None:
        found.said["unit"] = said.unit
    found.about.append(f"{about}, heights in {said.unit or 'a unit that the file does not name'}")
    found.missing = list(opened.lacks)
    found.why = dict.fromkeys(found.said.keys() - {"crop"}, "as the file says") | dict.fromkeys(
        found.missing, NEEDED
    )
    _by_heights(found, make, given, said.periodic)
    _by_instrument(found, opened, make(given))
    return found


def _by_instrument(found: Suggestion, opened: Topography, spec: File) -> None:
    """Suggest where to cut off waves that the instrument made, as far as it says."""
    with suppress(Exception):  # of a file that SurfaceTopography does not read
        topography, _ = instruments.opened(str(spec.path), spec.dataset)
        cutoff, why = unreliable(topography) or (0.0, "")
        factors = (ceil(cutoff * n / (2 * L)) for n, L in zip(opened.n, opened.sizes))
        least = max(factors)
        cut = [k for k in range(least, opened.n[0]) if not any(n % k for n in opened.n)]
        if least > 1 and cut:
            found.about.append(f"{why}; surface.downsample = {cut[0]} removes them")
            found.said["downsample"], found.why["downsample"] = cut[0], why


def _readable(sizes: tuple[float, ...], unit: str) -> list[str]:
    """Write lengths as ["10 um", "8 um"]."""
    lengths = [size * factor(unit) for size in sizes]
    scale, name = prefixed(lengths, "m")
    return [f"{length / scale:.10g} {name}" for length in lengths]


def _by_heights(
    found: Suggestion, make: Callable[[dict], File], given: dict, periodic: bool | None
) -> None:
    """Suggest what the heights themselves show."""
    values, why = found.values, found.why
    plain: dict[str, object] = {
        "boundary": "periodic",
        "radius": None,
        "refine": 1,
        "downsample": 1,
        "fill": "harmonic",
    }
    if found.missing:
        plain |= {"physical_sizes": (1.0, 1.0), "crop": None}

    def looked_at() -> tuple[Topography, MapQuality]:
        spec = make(values | plain)
        heights = prepare(open_topography(spec), spec, SerialComm())
        return heights, quality_of(heights, SerialComm())

    heights, quality = looked_at()
    found.about.append(f"{heights.filled or 'no'} points without a height")
    if heights.filled and "fill" not in given:
        values["fill"], why["fill"] = "harmonic", f"{heights.filled} points have no height"
    said = f"{100 * quality.tilt:.0f} % of the variance of the heights is tilt"
    found.about.append(said)
    out = outliers(heights, quality.typical)
    if quality.tilt > DOUBT.tilt and "detrend" not in given:
        values["detrend"], why["detrend"] = "tilt", said
        heights, quality = looked_at()
    edges = f"opposite edges differ by {max(quality.jumps):.2g} times what neighbours differ by"
    found.about.append(edges)
    if out:
        found.about.append(
            f"{out} points stand out of their neighbours by more than {DOUBT.outlying:g} times what"
            " neighbours differ by: dust or spikes? They are pressed as they are"
        )
    ends = max(quality.jumps) > DOUBT.jump and not periodic
    if ends and {"boundary", "mirror", "window"}.isdisjoint(given):
        values["boundary"], why["boundary"] = "free", f"{edges}; mirror = true is another way"
