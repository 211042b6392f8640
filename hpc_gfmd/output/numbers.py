"""The numbers of all loads as arrays along them, and what each number and each field is: units and
meaning."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..util.quantities import in_units

Attributes = Mapping[str, Any]
About = Mapping[str, tuple[str, str]]  # {name: (meaning, unit)}, as contact.all_numbers gives

MEANINGS = {
    "pressure": ("contact pressure, 0 where the gap is open", "pressure"),
    "gap": (
        "gap between the deformed surface and the rigid one, displacement + initial gap",
        "length",
    ),
    "displacement": ("displacement of the elastic surface away from the rigid surface", "length"),
    "plastic": ("depth of the dents where the pressure is the hardness", "length"),
    "heights": (
        "heights of the rigid surface, peaks up, measured from the highest; initial gap = -heights",
        "length",
    ),
    "x": ("position along the first axis", "length"),
    "y": ("position along the second axis", "length"),
    "p": ("mean pressure", "pressure"),
    "load": ("mean pressure of the load steps", "pressure"),
}


def names_of(steps: Sequence[Attributes]) -> dict[str, None]:
    """List what load steps say in one number or text, in their order. What is no identifier stays
    out: it may be a path."""
    return dict.fromkeys(
        name
        for step in steps
        for name, value in step.items()
        if name.isidentifier() and isinstance(value, bool | int | float | str)
    )


def numbers(steps: Sequence[Attributes]) -> dict[str, np.ndarray]:
    """Return the numbers and texts of `names_of` as arrays over the steps; nan or "" where a step
    has none."""
    arrays = {}
    for name in names_of(steps):
        values = [step.get(name) for step in steps]
        missing = "" if any(isinstance(value, str) for value in values) else np.nan
        arrays[name] = np.array([missing if value is None else value for value in values])
    return arrays


def unit_of(name: str, surface: Attributes, about: About) -> str:
    """Return the unit of a number.

    Parameters
    ----------
    name : str
        Of the number.
    surface : mapping
        Attributes of the surface, which know the units.
    about : mapping
        Meaning and unit of the numbers.

    Returns
    -------
    str
        "1" without dimension, "" where the unit has no name.
    """
    return in_units(about.get(name, ("", ""))[1], surface)


def axes(surface: Attributes) -> dict[str, np.ndarray]:
    """Return the positions of the points along x and along y."""
    sides = zip("xy", surface["n"], surface["physical_sizes"], strict=True)
    return {name: np.arange(n) * (size / n) for name, n, size in sides}


def said_of(name: str, surface: Attributes, about: About) -> dict[str, str]:
    """Return the attributes `units` and `long_name` of a number or a field.

    Parameters
    ----------
    name, surface, about
        As for `unit_of`.

    Returns
    -------
    dict of str to str
        With the dimension, as "length", where the unit has no name.
    """
    meaning, unit = MEANINGS.get(name) or about.get(name, (name, ""))
    return {"units": in_units(unit, surface) or unit, "long_name": meaning}
