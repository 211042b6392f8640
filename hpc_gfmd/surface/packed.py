"""The conventions of NetCDF (CF) for packed numbers and for numbers that mark missing points."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

MISSING = ("_fillvalue", "missing_value", "nodata", "nodata_value", "no_data_value")
PACKING = ("scale_factor", "add_offset", "valid_min", "valid_max", "valid_range", *MISSING)
UNWRITTEN = 15 * 2.0**119  # NetCDF's number where nothing was written


def unpacker(attributes: Mapping[str, Any]) -> Callable[[np.ndarray], np.ndarray]:
    """Return what converts stored numbers to heights, by the attributes PACKING and `_Unsigned`;
    nan where missing or out of the valid range.
    """
    by_name = {name.lower(): value for name, value in attributes.items()}
    numbers = {name: _numbers(name, by_name[name]) for name in PACKING if name in by_name}
    missing = np.concatenate([[UNWRITTEN], *(numbers[name] for name in MISSING if name in numbers)])
    limits = numbers.get("valid_range", np.array([-np.inf, np.inf]))
    if limits.size != 2:
        raise ValueError("its attribute valid_range is not two numbers")
    limits[0] = numbers.get("valid_min", limits)[0]
    limits[1] = numbers.get("valid_max", limits)[-1]
    kind = {"true": "u", "false": "i"}.get(_text(by_name.get("_unsigned")).lower())

    def unpacked(z: np.ndarray) -> np.ndarray:
        stored = z
        if kind and z.dtype.kind in "iu":
            stored = z.astype(z.dtype.newbyteorder("=")).view(f"{kind}{z.dtype.itemsize}")
        heights = stored.astype(np.float64)
        without = np.isin(heights, _in_type(missing, stored.dtype))
        lowest, highest = _in_type(limits, stored.dtype)
        without |= (heights < lowest) | (heights > highest)
        heights *= numbers["scale_factor"][0] if "scale_factor" in numbers else 1
        if "add_offset" in numbers:
            heights += numbers["add_offset"][0]
        heights[without] = np.nan
        return heights

    return unpacked


def _in_type(values: np.ndarray, dtype: np.dtype) -> np.ndarray:
    """Return values as float64 after being stored in a dtype, unsigned by their bits; infinite ones
    and those that do not fit stay.
    """
    if dtype.kind == "f":
        with np.errstate(over="ignore"):
            return values.astype(dtype).astype(np.float64)
    span = 2.0 ** (8 * dtype.itemsize)
    wraps = (dtype.kind == "u") & (values < 0) & (values >= -span / 2)
    return np.where(wraps, values + span, values)


def _numbers(name: str, value: Any) -> np.ndarray:
    """Return the numbers of an attribute, float64, shape (k,), or raise ValueError."""
    array = np.ravel(value)
    if array.size < 1 or array.dtype.kind not in "fiu":
        raise ValueError(f"its attribute {name} is no number")
    return array.astype(np.float64)


def _text(value: Any) -> str:
    """Return an attribute that is one text or number as text, "" for arrays, "None" without it."""
    array = np.ravel(value)
    text = array[0] if array.size == 1 else ""
    return text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text)
