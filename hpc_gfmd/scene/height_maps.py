"""Keys of a scene for files with height maps: how a file is read, and how two scans are placed."""

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from .table import LIST, Height, Length, LengthUnit, MapPath, Pair, Paths, Table, Text, alike, key
from .table import Path as PathText

ANY = "surface"  # the data set or channel where the scene names none


class Reading(Table):
    """How a file with a height map is read."""

    path: Paths | None = key(
        "a relative one counts from the folder of the scene; two maps of the same points are added"
        " as they are",
        None,
        default_text="none, where bodies are given",
        example="map.npy",
        allowed="the path of a height map (.npy, .h5, .nc, .csv, .tif, .x3p, ...), or a list of"
        " two",
    )
    dataset: PathText = key(
        "which one, where the file has several",
        ANY,
        allowed="the name of a data set (HDF5, NetCDF, .npz) or of a channel",
    )
    skip_lines: Annotated[int, Field(ge=0)] | None = key(
        "of a text: lines before the numbers",
        None,
        example=3,
        default_text="those that are no numbers",
    )
    decimal: Literal[".", ","] | None = key(
        "of a text: what decimals begin with", None, example=",", default_text="what fits"
    )
    missing: Annotated[tuple[Text, ...], LIST] = key(
        'what stands for missing points; in a text besides nothing, "***", "BAD", "---", "nan"',
        (),
        example=["9999"],
        allowed="a list of texts",
    )
    coordinates: Literal["none", "line", "column", "both"] | None = key(
        "of a text: which of first line and column are coordinates",
        None,
        example="both",
        default_text="what the numbers show",
    )
    first_axis: Literal["x", "y"] | None = key(
        "what the first index of an array, or the line number of a text, runs along",
        None,
        example="y",
        default_text="what the file says, else x",
    )
    height_range: Pair[Height] | None = key(
        "of a TIFF or PNG of whole numbers: heights of the lowest and the highest possible",
        None,
        unit="length",
        example=["0 nm", "500 nm"],
    )
    # None, other than in a surface that is made: as the file says
    physical_sizes: Pair[Length] | None = key(
        "lengths [L_x, L_y] of the map; plain ones are in surface.xy_unit, else surface.unit",
        None,
        unit="length",
        example=["10 um", "8 um"],
        default_text="what the file says",
    )
    unit: LengthUnit | None = key(
        "of the heights, and of plain sizes",
        None,
        example="nm",
        default_text="what the file says",
        allowed='a unit of length, such as "nm"',
    )
    xy_unit: LengthUnit | None = key(
        "of x and y, and of plain sizes, where it is not that of the heights",
        None,
        example="mm",
        default_text="what the file says, else unit",
        allowed='a unit of length, such as "mm"',
    )

    @model_validator(mode="after")
    def _alike(self) -> Self:
        """Raise ValueError if one end of the range of heights has a unit and the other has none."""
        alike("heights", {"surface.height_range": self.height_range})
        return self


class RoughBody(Reading):
    """One of two scans, each measured from above: a path, or a table with it.

    Besides these keys it has those of kind = "file" that tell how a file is read, from dataset to
    unit; keys that are not given here have the values given beside bodies.
    """

    path: MapPath = key(
        "a relative one counts from the folder of the scene",
        example="map.npy",
        allowed="the path of a height map (.npy, .h5, .nc, .csv, .tif, .x3p, ...)",
    )
    dataset: PathText | None = key(  # type: ignore[assignment]
        "which one, where the file has several",
        None,
        allowed="the name of a data set (HDF5, NetCDF, .npz) or of a channel",
    )
    missing: Annotated[tuple[Text, ...], LIST] | None = key(  # type: ignore[assignment]
        "what stands for missing points", None, allowed="a list of texts"
    )
    shift: Pair[Height] = key(
        "where its first corner lies, [x, y] from that of the other scan",
        (0.0, 0.0),
        unit="length",
        example=["5 um", "0 um"],
    )
    mirrored: Literal["none", "x", "y"] | None = key(
        "along which axis, as a scan from above is when its body is turned over to face the other",
        None,
        default_text='"x" of the second scan, "none" of the first',
        example="x",
    )
    flip: bool = key("turn the heights over: valleys become peaks, as of a replica", False)


OWN_KEYS = ("path", "shift", "mirrored", "flip")  # of a RoughBody, beside those of reading


def _as_table(value: Any) -> Any:
    """Return {"path": value} for a text, any other value as it is."""
    return {"path": value} if isinstance(value, str) else value


AnyBody = Annotated[RoughBody, BeforeValidator(_as_table)]
Bodies = Annotated[tuple[AnyBody, AnyBody], LIST]
