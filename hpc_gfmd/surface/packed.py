"""Numbers that stand for others: the conventions of NetCDF (CF) for packed data and for points
without a value."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

MISSING = ("_FillValue", "missing_value")


def unpacker(attributes: Mapping[str, Any]) -> Callable[[np.ndarray], np.ndarray]:
    """Return a function that makes heights of the values of a variable, nan where there is none;
    attributes: of the variable. Raises ValueError where they are no numbers."""
    names = ("scale_factor", "add_offset", *MISSING)
    said = {name: _number(attributes, name) for name in names if name in attributes}
    unwritten = 15 * 2.0**119  # NetCDF's number where nothing was written
    missing = [unwritten, *(said[name] for name in MISSING if name in said)]

    def unpacked(z: np.ndarray) -> np.ndarray:
        heights = z.astype(np.float64)
        heights *= said.get("scale_factor", 1)
        if "add_offset" in said:
            heights += said["add_offset"]
        heights[np.isin(z, missing)] = np.nan
        return heights

    return unpacked


def _number(attributes: Mapping[str, Any], name: str) -> Any:
    value = np.ravel(attributes[name])
    if value.size != 1 or value.dtype.kind not in "fiu":
        raise ValueError(f"its attribute {name} is no number")
    return value[0]
