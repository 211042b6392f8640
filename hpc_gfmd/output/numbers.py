"""Numbers of all load steps as arrays, and the unit and meaning of each number and each field."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..util.quantities import in_units

Attributes = Mapping[str, Any]
About = Mapping[str, tuple[str, str]]  # {name: (meaning, unit)}, as contact.all_numbers gives

SCALARS = (bool, int, float, str)
MEANINGS = {
    "pressure": ("contact pressure, 0 where the gap is open", "pressure"),
    "gap": (
        "gap between the deformed surface and the rigid one, displacement + initial gap",
        "length",
    ),
    "displacement": ("displacement of the elastic surface away from the rigid surface", "length"),
    "plastic": ("depth of the dents where the pressure is the hardness", "length"),
    "dent": ("depth of the dents that stay, of all loads so far", "length"),
    "heights": (
        "heights of the rigid surface, peaks up, measured from the highest; initial gap = -heights",
        "length",
    ),
    "x": ("position along the first axis", "length"),
    "y": ("position along the second axis", "length"),
    "p": ("mean pressure", "pressure"),
    "load": ("mean pressure of the load steps", "pressure"),
}


def scalar_names(steps: Sequence[Attributes]) -> dict[str, None]:
    """Return names of attributes that are a number or text in some step; only identifiers, as names
    in a damaged file could be paths.
    """
    return dict.fromkeys(
        name
        for step in steps
        for name, value in step.items()
        if isinstance(value, SCALARS) and name.isidentifier()
    )


def numbers(steps: Sequence[Attributes]) -> dict[str, np.ndarray]:
    """Return {name: array over the steps}; a step without it has nan (floats then) or ""."""
    arrays = {}
    for name in scalar_names(steps):
        values = [step.get(name) for step in steps]
        missing = "" if any(isinstance(value, str) for value in values) else np.nan
        arrays[name] = np.array([missing if value is None else value for value in values])
    return arrays


def unit_of(name: str, surface: Attributes, about: About) -> str:
    """Return the unit of a number: "1" if dimensionless or unknown, "" if it has none."""
    return in_units(about.get(name, ("", ""))[1], surface)


def axes(surface: Attributes) -> dict[str, np.ndarray]:
    """Return {"x": positions, "y": positions} of the points, from 0, in the unit of length."""
    sides = zip("xy", surface["n"], surface["physical_sizes"], strict=True)
    return {name: np.arange(n) * (size / n) for name, n, size in sides}


def dataset_attributes(name: str, surface: Attributes, about: About) -> dict[str, str]:
    """Return `units`, or the dimension without one, and `long_name` of a dataset."""
    meaning, unit = MEANINGS.get(name) or about.get(name, (name, ""))
    return {"units": in_units(unit, surface) or unit, "long_name": meaning}
