"""What a scene has to say of a height map beside its path, found by reading it."""

from collections.abc import Callable
from dataclasses import dataclass, field

from ..parallel.comm import SerialComm
from ..scene import File
from ..util.quantities import factor, prefixed
from .files import HeightMap
from .prepare import prepare
from .quality import JUMP, TILT, MapQuality
from .topography import Topography, open_topography

NEEDED = "TO BE GIVEN, the file does not say it"


@dataclass
class Suggestion:
    """Of keys of [surface]. values: those to be set; said: what the file itself says; why: reasons
    for both; missing: what only a person knows; about: the map in a line."""

    values: dict
    said: dict = field(default_factory=dict)
    why: dict = field(default_factory=dict)
    missing: list = field(default_factory=list)
    about: str = ""


def suggestion(make: Callable[[dict], File], given: dict) -> Suggestion:
    """For the map of make({}); make(values): scene.File with these values; given: what the user has
    said already.

    Raises SceneError for a file that cannot be read.
    """
    found, plain = Suggestion(dict(given)), HeightMap(make(given))
    said = plain.metadata
    found.about = f"{plain.shape[0]} x {plain.shape[1]} points"
    if said.sizes is not None:
        unit = said.sizes_unit or said.unit
        found.said["physical_sizes"] = _readable(said.sizes, unit) if unit else list(said.sizes)
        found.about += f", {found.said['physical_sizes'][0]} x {found.said['physical_sizes'][1]}"
    if said.unit is not None:
        found.said["unit"] = said.unit
    wanted = (
        ["unit"]
        if said.sizes is not None
        else ["physical_sizes", "unit"]
        if said.unit is None
        else ["physical_sizes"]
    )
    found.missing = (
        []
        if "physical_sizes" in given
        else [key for key in wanted if key not in found.said | given]
    )
    found.why = dict.fromkeys(found.said, "as the file says") | dict.fromkeys(found.missing, NEEDED)
    if not found.missing:
        _by_heights(found, make, given, said.periodic)
    return found


def _readable(sizes: tuple[float, ...], unit: str) -> list[str]:
    """Lengths as ["10 um", "8 um"]."""
    lengths = [size * factor(unit) for size in sizes]
    scale, name = prefixed(lengths, "m")
    return [f"{length / scale:.10g} {name}" for length in lengths]


def _by_heights(
    found: Suggestion, make: Callable[[dict], File], given: dict, periodic: bool | None
) -> None:
    """What the heights themselves show."""
    values, why = found.values, found.why

    def prepared(**more: object) -> Topography:
        spec = make(values | more)
        return prepare(open_topography(spec), spec, SerialComm())[0]

    missing = prepared(boundary="periodic", fill="harmonic").filled
    if missing and "fill" not in given:
        values["fill"], why["fill"] = "harmonic", f"{missing} points have no height"
    tilt = MapQuality(prepared(boundary="periodic"), SerialComm()).tilt
    if tilt > TILT and "detrend" not in given:
        values["detrend"], why["detrend"] = (
            "tilt",
            f"{100 * tilt:.0f} % of the variance of the heights is that of a plane",
        )
    jump = max(
        MapQuality(prepared(boundary="periodic", refine=1, downsample=1), SerialComm()).jumps
    )
    if jump > JUMP and not periodic and not {"boundary", "mirror", "window"} & set(given):
        edges = f"opposite edges differ by {jump:.2g} times what neighbours differ by"
        if {"refine", "downsample"} & set(given):
            values["mirror"], why["mirror"] = (
                True,
                f"{edges}; a free boundary has no refine or downsample",
            )
        else:
            values["boundary"], why["boundary"] = "free", f"{edges}; mirror = true is another way"
