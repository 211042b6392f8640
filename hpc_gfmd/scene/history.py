"""What a scene with a memory of its loads (load.history, load.time) needs and excludes."""

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

from ..util.errors import SceneError
from ..util.quantities import format_quantity
from .settings import LoadTable, Material, Output
from .table import alike


def require_history(load: LoadTable, material: Material, output: Output) -> None:
    """Raise ValueError for a memory of loads without anything to remember, or with its opposite."""
    if "dent" in output.fields and not (load.history and material.hardness is not None):
        raise ValueError(
            'output.fields: found "dent", allowed with load.history and material.hardness'
        )
    if load.history and material.hardness is None and material.adhesion is None:
        raise ValueError(
            "load.history: found true, allowed: with material.hardness or material.adhesion"
        )
    if load.history and load.branch != "approach":
        raise ValueError(
            f'load.branch: found "{load.branch}" with load.history, where each load is on the'
            " branch of its direction, allowed: none"
        )
    if load.history and load.unique:
        raise ValueError("load.unique: found true with load.history, allowed: false")
    _require_times(load, material)
    if material.relaxation is None:
        return
    total = math.fsum(share for share, _ in material.relaxation)
    if total >= 1:
        raise ValueError(
            f"material.relaxation: found shares that add up to {total:g}, allowed: less than 1"
        )
    if material.E2 is not None or material.base == "elastic":
        stiffer = "E2" if material.E2 is not None else "base_E"
        raise ValueError(
            f"material.relaxation: found beside {stiffer}, a solid that relaxes differently,"
            " allowed: one elastic solid, also as a layer on a rigid base"
        )
    if material.adhesion is not None:
        raise ValueError("material.relaxation: found beside material.adhesion, allowed: one")
    if material.hardness is not None and not load.history:
        raise ValueError(
            "load.history: found false with material.hardness and material.relaxation, allowed:"
            " true"
        )


def refuse_relaxation(tables: Mapping[str, Any], origin: str = "scene") -> None:
    """Raise SceneError, which begins with `origin`, for a law of a body that relaxes."""
    material = tables.get("material")
    if isinstance(material, Mapping) and "relaxation" in material:
        raise SceneError(
            f"{origin}: material.relaxation: found in a law, which would depend on time, allowed:"
            " a law of a body that does not relax"
        )


def _require_times(load: LoadTable, material: Material) -> None:
    """Raise ValueError unless each load of a solid that relaxes, and only those, has a time."""
    times = load.time
    if (times is None) != (material.relaxation is None):
        present = "load.time" if times else "material.relaxation"
        raise ValueError(f"{present}: found alone, allowed: load.time and material.relaxation")
    if times is None:
        return
    _, values = load.prescribed
    if len(times) != len(values):
        raise ValueError(
            f"load.time: found {len(times)} times for {len(values)} loads, allowed: as many"
        )
    for before, after in pairwise(times):
        if after < before:
            raise ValueError(
                f"load.time: found {format_quantity(after)} after {format_quantity(before)},"
                " allowed: times that do not fall"
            )
    elements = material.relaxation or ()
    alike("times", {"load.time": times, "material.relaxation": [tau for _, tau in elements]})


def notes_on_history(load: LoadTable, material: Material) -> list[str]:
    """Return a note on the loads that shape the dents, if others are solved beside them."""
    name, values = load.prescribed
    if not load.history or material.hardness is None or material.relaxation is not None:
        return []
    heights = [-value if name.startswith("gap") else value for value in values]
    largest = -math.inf
    shaping = []
    for k, (height, following) in enumerate(zip(heights, [*heights[1:], -math.inf])):
        if largest < height > following:
            shaping.append(f"{k + 1}")
        largest = max(largest, height)
    if len(shaping) == len(values):
        return []
    return [
        "load.history: dents are those of the largest load so far (load"
        f"{'s' * (len(shaping) > 1)} {', '.join(shaping)}); the other loads are points of a curve,"
        " and may be left out"
    ]
