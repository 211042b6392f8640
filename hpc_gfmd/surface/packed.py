"""Numbers that stand for others: the conventions of NetCDF (CF) for packed data and for points
without a value."""

from collections.abc import Mapping
from typing import Any

import numpy as np

MISSING = ("_FillValue", "missing_value")


class Packing:
    """What the attributes of a variable say. Raises ValueError where they are no numbers."""

    def __init__(self, attributes: Mapping[str, Any]) -> None:
        self.scale, self.offset, *self.missing = (
            _number(attributes, name) for name in ("scale_factor", "add_offset", *MISSING)
        )
        self.plain = {self.scale, self.offset, *self.missing} == {None}

    def unpacked(self, z: np.ndarray) -> np.ndarray:
        """Values of the file as heights; not a number where there is none."""
        if self.plain:
            return z
        heights = z.astype(np.float64)
        if self.scale is not None:
            heights *= self.scale
        if self.offset is not None:
            heights += self.offset
        heights[np.isin(z, [value for value in self.missing if value is not None])] = np.nan
        return heights


def _number(attributes: Mapping[str, Any], name: str) -> Any:
    if name not in attributes:
        return None
    value = np.asarray(attributes[name])
    if value.size != 1 or value.dtype.kind not in "fiu":
        raise ValueError(f"its attribute {name} is no number")
    return value.reshape(-1)[0]
