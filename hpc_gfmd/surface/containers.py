"""Containers of contact.engineering: one map of several measurements, by SurfaceTopography."""

import warnings
from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np

from ..scene.height_maps import ANY
from ..util.errors import SceneError, one_line
from ..util.lengths import length_factor
from ..util.libraries import surface_topography
from .contents import Contents
from .metadata import Map, Metadata, of_topography

SAME = 1e-3  # relative difference of sizes that are the same
LEFT_AS_IT_IS = (None, "center", "do-not-fill")  # filters that change nothing of the surface


def read(contents: Contents, spec: Any) -> Map:
    """Read the only map of a container, or spec.dataset, filtered as the container says."""
    surface_topography()
    from SurfaceTopography.Container.IO import open_container

    maps: dict[str, tuple[Any, dict]] = {}  # by name: how to read it, and what is said of it
    profiles = []
    counts: Counter = Counter()
    with open_container(contents.source, format="ce") as container:
        for k in range(container.nb_containers):
            surface = container.container(k)
            for place, member in enumerate(container.members(k)):
                counts[member.name] += 1
                number = counts[member.name]
                name = member.name if number == 1 else f"{member.name} ({number})"
                about = surface.info["topographies"][place]
                if len(about.get("size", "xy")) == 1:
                    profiles.append(name)
                else:
                    maps[name] = (lambda surface=surface, place=place: surface[place]), about
    if not maps:
        content = (
            "only profiles" if profiles else "no measurement (unpacked, its files can be read)"
        )
        raise ValueError(f"it lists {content}, allowed: a map")
    name = next(iter(maps)) if spec.dataset == ANY and len(maps) == 1 else spec.dataset
    if name not in maps:
        which = "is a profile" if name in profiles else "is none of its maps"
        problem = "not given" if name == ANY else f"found {name!r}, which {which}"
        raise SceneError(
            f"surface.dataset: {problem}, {spec.path} holds {len(maps)} maps, allowed: one of"
            f" {one_line(', '.join(map(repr, maps)), 400)}"
        )
    make, about = maps[name]
    with warnings.catch_warnings():  # of units that are spelt differently
        warnings.simplefilter("ignore")
        topography = make()
    if topography.dim != 2:
        raise ValueError(f"{name!r} is a profile, allowed: a map")
    heights, metadata = of_topography(topography)
    return heights, replace(
        metadata,
        channel=name,
        other_channels=tuple(key for key in maps if key != name),
        direction="as in the container",
        remarks=tuple(_remarks(about, metadata)),
        reader="container",
    )


def _remarks(about: dict, metadata: Metadata) -> list[str]:
    """Return what the container did to a map, and where the map's own file differs (it counts)."""
    filters = [about.get("detrend_mode"), about.get("fill_undefined_data_mode")]
    remarks = [
        f"filtered by {mode!r}, as the container says"
        for mode in filters
        if mode not in LEFT_AS_IT_IS
    ]
    unit = about.get("unit") or metadata.sizes_unit
    size = about.get("size")
    if size and metadata.sizes:
        wanted, sizes = (
            np.multiply(lengths, length_factor(name or "") or 1.0)
            for lengths, name in ((size, unit), (metadata.sizes, metadata.sizes_unit))
        )
        if not np.allclose(wanted, sizes, SAME, 0):
            remarks.append(f"its container says sizes of {size} {unit or ''}".rstrip())
    return remarks
