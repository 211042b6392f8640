"""Heights as pictures: TIFF and PNG of whole numbers, which stand for a range of heights, and TIFF
of numbers with decimals, which are heights."""

from pathlib import Path
from typing import Any

import numpy as np

from ..util.quantities import Quantity, factor
from . import instruments
from .metadata import Map, Metadata

GREY = ("L", "I", "I;16", "I;16B")  # modes of Pillow that have one number a point


def read(path: str | Path, spec: Any) -> Map:
    """Read a picture: (heights (n_x, n_y), Metadata), x to the right, y down; spec: scene.File.
    What an instrument wrote as a TIFF is read as such. Raises ValueError for colours, and for whole
    numbers without a range."""
    is_png = Path(path).suffix.lower() == ".png"
    if found := None if is_png else instruments.recognised(path, spec):
        return found
    z = _grey(path) if is_png else _tiff(path)
    if z.dtype.kind == "f" and spec.height_range is None:
        return z.T, Metadata()
    if z.ndim != 2 or z.dtype.kind == "f" or spec.height_range is None:
        raise ValueError(
            f"found an array {z.shape} of {z.dtype}, allowed: one number a point, either with"
            ' decimals, or whole and surface.height_range = ["0 nm", "500 nm"] for the lowest and'
            " the highest one that there may be"
        )
    unit = spec.unit or "m"
    low, high = (h / factor(unit) if isinstance(h, Quantity) else h for h in spec.height_range)
    limits = np.iinfo(z.dtype)
    share = (z.T - float(limits.min)) / (float(limits.max) - limits.min)
    named = any(isinstance(h, Quantity) for h in spec.height_range)
    return low + (high - low) * share, Metadata(unit=unit if named else None)


def _tiff(path: str | Path) -> np.ndarray:
    import tifffile

    try:
        return tifffile.imread(path)
    except ValueError:  # packed: Pillow reads fewer types of numbers, but unpacks more
        return _grey(path)


def _grey(path: str | Path) -> np.ndarray:
    from PIL import Image

    with Image.open(path) as picture:
        if picture.mode not in GREY:
            raise ValueError(f"found colours ({picture.mode}), allowed: one number a point")
        z = np.asarray(picture)
    return z.astype(np.uint16) if picture.mode == "I" else z  # how some versions open 16 bits
