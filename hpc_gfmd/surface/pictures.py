"""Heights as TIFF and PNG: whole numbers span spec.height_range, decimals (TIFF) are heights."""

from typing import Any
from xml.etree import ElementTree

import numpy as np

from ..util.quantities import Quantity, factor
from . import instruments
from .contents import Contents
from .metadata import Map, Metadata, missing_numbers

GREY = ("L", "I", "I;16", "I;16B")  # modes of Pillow that have one number a point
DIRECTION = "to the right in the picture, y down"
_NO_DATA = 42113  # GDAL's tags of a TIFF
_SCALES = 42112
_UPRIGHT = 1
_WHITE_IS_0 = 0  # photometric interpretation
_ALLOWED = (
    'one number a point, either with decimals, or whole and surface.height_range = ["0 nm", "500'
    ' nm"] for the lowest and the highest one that there may be'
)

COLOURS = (
    "found colours ({}), allowed: one number a point, as instruments export heights; which heights"
    " colours stand for is not in the file"
)


def read_png(contents: Contents, spec: Any) -> Map:
    """Read a PNG, x right, y down, nan at spec.missing; needs spec.height_range."""
    z = _grey(contents)
    return _heights(z, np.isin(z, missing_numbers(spec, contents.path)), spec, ())


def read_tiff(contents: Contents, spec: Any) -> Map:
    """Read a TIFF, x right, y down, nan where a mask, GDAL or spec.missing says so.
    SurfaceTopography reads it if it finds sizes or a unit; missing numbers count as stored, before
    GDAL's scale and offset, which make decimals.
    """
    if (scan := instruments.recognised(contents, spec)) is not None:
        return scan
    import tifffile

    page: Any
    with tifffile.TiffFile(contents.source) as file:
        pages = [page for page in file.pages if not getattr(page, "is_reduced", False)]
        masks = [page for page in pages if getattr(page, "is_mask", False)]
        pictures = [page for page in pages if page not in masks]
        if len(pictures) != 1:
            raise ValueError(f"it has {len(pictures)} pictures, allowed: one")
        (page,) = pictures
        tags = page.tags
        if tags.valueof(274, _UPRIGHT) != _UPRIGHT:
            raise ValueError("it is stored turned or mirrored, allowed: TIFF orientation 1")
        scale, offset = _scale_and_offset(tags.valueof(_SCALES, ""))
        missing = [*_numbers(tags.valueof(_NO_DATA, "")), *missing_numbers(spec, contents.path)]
        try:
            z = page.asarray()
            valid = masks[0].asarray() if masks else None
        except ValueError as error:  # packed in a way that only Pillow unpacks
            if masks:
                raise ValueError(f"{error}; Pillow does not read its mask") from None
            z = _unpacked(contents, page)
            valid = None
    if valid is not None and valid.shape != z.shape:
        raise ValueError(f"its mask has {valid.shape} points, its heights {z.shape}")
    without = np.isin(z, _in_type(np.array(missing), z.dtype))
    if valid is not None:
        without |= valid == 0
    if (scale, offset) != (1.0, 0.0):
        z = z * scale + offset
    return _heights(z, without, spec, (scale, offset))


def _heights(z: np.ndarray, holes: np.ndarray, spec: Any, scaled: tuple) -> Map:
    """Convert numbers z (n_y, n_x) with holes to heights (n_x, n_y) and metadata; scaled: (scale,
    offset) that were applied, for a remark, or ().
    """
    if z.ndim != 2:
        raise ValueError(f"found an array {z.shape} of {z.dtype}, allowed: {_ALLOWED}")
    has_decimals = z.dtype.kind == "f"
    if has_decimals == (spec.height_range is not None):
        raise ValueError(f"found an array {z.shape} of {z.dtype}, allowed: {_ALLOWED}")
    if has_decimals:
        heights = z.T if not holes.any() else np.where(holes, np.nan, z).T
        remarks: tuple[str, ...] = ()
        if scaled not in ((), (1.0, 0.0)):
            remarks = (f"heights are {scaled[0]:g} times its numbers, plus {scaled[1]:g}",)
        return heights, Metadata(direction=DIRECTION, remarks=remarks)
    unit = spec.unit or "m"
    low, high = (h / factor(unit) if isinstance(h, Quantity) else h for h in spec.height_range)
    limits = np.iinfo(z.dtype)
    is_named = any(isinstance(h, Quantity) for h in spec.height_range)
    texts = [getattr(h, "text", f"{h:g}") for h in spec.height_range]
    remark = (
        f"{limits.min} to {limits.max}, the range of {z.dtype}, stand for {texts[0]} to {texts[1]};"
        f" its numbers are {z.min()} to {z.max()}"
    )
    heights = z.T - float(limits.min)
    heights /= float(limits.max) - limits.min
    heights *= high - low
    heights += low
    heights[holes.T] = np.nan
    return heights, Metadata(
        unit=unit if is_named else None, direction=DIRECTION, remarks=(remark,)
    )


def _grey(contents: Contents) -> np.ndarray:
    """Read a picture with one whole number per point, (n_y, n_x); ValueError for colours."""
    from PIL import Image

    with Image.open(contents.source) as picture:
        if picture.mode not in GREY:
            raise ValueError(COLOURS.format(picture.mode))
        z = np.asarray(picture)
    return z.astype(np.uint16) if picture.mode == "I" else z  # how some versions open 16 bits


def _unpacked(contents: Contents, page: Any) -> np.ndarray:
    """Read the picture of a packed TIFF by Pillow; ValueError if that would change its numbers."""
    from PIL import Image

    if page.photometric == _WHITE_IS_0:
        raise ValueError("it is packed, and 0 stands for white, allowed: not packed")
    with Image.open(contents.source) as picture:
        if picture.mode not in (*GREY, "F"):
            raise ValueError(COLOURS.format(picture.mode))
        z = np.asarray(picture)
    numbers = z.astype(page.dtype)
    is_narrower = z.itemsize < numbers.itemsize
    if is_narrower or (z.itemsize > numbers.itemsize and not np.array_equal(numbers, z)):
        raise ValueError(f"it is packed, with numbers {page.dtype}, allowed: not packed")
    return numbers


def _numbers(text: Any) -> np.ndarray:
    """Return the number in GDAL's tag for missing points, if there is one, as an array."""
    text = text.decode("ascii", "replace") if isinstance(text, bytes) else str(text)
    try:
        return np.array([float(text.strip("\0 "))]) if text.strip("\0 ") else np.array([])
    except ValueError:
        raise ValueError(f"its GDAL_NODATA is {text!r}, which is no number") from None


def _scale_and_offset(text: Any) -> tuple[float, float]:
    """Return scale and offset in GDAL's metadata (XML), else (1, 0); ValueError if damaged."""
    text = text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text)
    scale = 1.0
    offset = 0.0
    if not text.strip("\0 "):
        return scale, offset
    for item in ElementTree.fromstring(text.strip("\0 ")).iter("Item"):
        if item.get("role") == "scale":
            scale = float(item.text or 1)
        elif item.get("role") == "offset":
            offset = float(item.text or 0)
    return scale, offset


def _in_type(values: np.ndarray, dtype: np.dtype) -> np.ndarray:
    """Return values rounded to dtype if that is a floating-point type; otherwise as they are."""
    with np.errstate(over="ignore"):
        return values.astype(dtype) if dtype.kind == "f" else values
