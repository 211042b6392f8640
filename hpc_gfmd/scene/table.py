"""What all tables of a scene share: strictness, number types, what a key says of itself, and the
rule "exactly one of"."""

import os
from math import inf
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainSerializer,
    ValidationInfo,
    WrapValidator,
)

from ..util.quantities import Quantity, factor, parse

MAX_INT = 2**63 - 1  # the integers of TOML and of HDF5
MAX_N = 2**24  # grid points per direction


class Table(BaseModel):
    """A frozen table. true is no number, "1" is none, 1.0 is no whole number; inf and nan are
    refused."""

    model_config = ConfigDict(strict=True, frozen=True, extra="forbid", allow_inf_nan=False)


# The bounds keep squares and products of a few such numbers finite in double precision.
SMALLEST, LARGEST = 1e-100, 1e100
Positive = Annotated[float, Field(ge=SMALLEST, le=LARGEST)]


def _tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def each(value: Any) -> tuple:
    """The values of a list, or the only one."""
    return tuple(value) if isinstance(value, list | tuple) else (value,)


def _in(dimension: str) -> WrapValidator:
    """Of a number: plain, or as a text with a unit."""

    def read(value: Any, check: Any) -> float:
        if not isinstance(value, str | Quantity):
            return check(value)
        value = parse(value, dimension) if isinstance(value, str) else value
        check(float(value))
        return value

    return WrapValidator(read)


def _from_folder(path: str, scene: ValidationInfo) -> str:
    """A relative path counts from the folder of the scene file, where there is one."""
    return os.path.join(scene.context, path) if scene.context else path


def _length_unit(text: str) -> str:
    factor(text)
    return text


def _printable(text: str) -> str:
    if not text.isprintable():
        raise ValueError("control characters")
    return text


def _distinct(values: tuple) -> tuple:
    if len(set(values)) < len(values):
        raise ValueError("named twice")
    return values


def _bent(radii: Any) -> Any:
    if radii in (inf, (inf, inf)):
        raise ValueError("straight along both axes")
    return radii


AS_GIVEN = PlainSerializer(lambda value: getattr(value, "text", value))  # with its unit
LIST = BeforeValidator(_tuple)
ONE_OR_MANY = BeforeValidator(each)
SOME = Field(min_length=1)
DISTINCT = AfterValidator(_distinct)

NotNegative = Annotated[float, Field(ge=0, le=LARGEST)]
Fraction = Annotated[float, Field(gt=0, lt=1)]
Share = Annotated[float, Field(gt=0, le=1)]
Ratio = Annotated[float, Field(ge=1, le=LARGEST)]
Height = Annotated[float, Field(ge=-LARGEST, le=LARGEST), _in("length"), AS_GIVEN]
HeightRange = Annotated[tuple[Height, Height], LIST]
Length = Annotated[Positive, _in("length"), AS_GIVEN]
Radius = Annotated[float, Field(ge=SMALLEST, allow_inf_nan=True), _in("length"), AS_GIVEN]
Radii = Annotated[Radius | tuple[Radius, Radius], LIST, AfterValidator(_bent)]
Coordinate = Annotated[NotNegative, _in("length"), AS_GIVEN]
Pressure = Annotated[Positive, _in("pressure"), AS_GIVEN]
Force = Annotated[Positive, _in("force"), AS_GIVEN]
LengthUnit = Annotated[str, AfterValidator(_length_unit)]
Whole = Annotated[int, Field(ge=1, le=MAX_INT)]
Text = Annotated[str, AfterValidator(_printable)]
Path = Annotated[Text, Field(min_length=1)]
MapPath = Annotated[Path, AfterValidator(_from_folder)]
Paths = Annotated[MapPath | tuple[MapPath, MapPath], LIST]
Corners = Annotated[tuple[Coordinate, Coordinate, Coordinate, Coordinate], LIST]
Sizes = Annotated[tuple[Length, Length], LIST]
PointsOfAxis = Annotated[int, Field(ge=1, le=MAX_N)]
Points = Annotated[tuple[PointsOfAxis, PointsOfAxis], LIST]
ModesOfAxis = Annotated[int, Field(ge=0, le=MAX_N)]
Modes = Annotated[tuple[ModesOfAxis, ModesOfAxis], LIST]
Loads = Annotated[tuple[Positive, ...], SOME, ONE_OR_MANY]
Pressures = Annotated[tuple[Pressure, ...], SOME, ONE_OR_MANY]
Forces = Annotated[tuple[Force, ...], SOME, ONE_OR_MANY]
Lengths = Annotated[tuple[Length, ...], SOME, ONE_OR_MANY]
Gaps = Annotated[tuple[Coordinate, ...], SOME, ONE_OR_MANY]
RelativeGaps = Annotated[tuple[NotNegative, ...], SOME, ONE_OR_MANY]
Areas = Annotated[tuple[Share, ...], SOME, ONE_OR_MANY]

Side = Literal["periodic", "free"]
Boundary = Annotated[Side | tuple[Side, Side], LIST]

POSITIVE = "a number greater than 0"
POSITIVES = "a number greater than 0, or a list of them"
LENGTH = f'{POSITIVE}, plain or as "100 um"'
FRACTION = "a number above 0 and below 1"
SWITCH = "true or false"


def key(
    meaning: str,
    allowed: str,
    default: Any = ...,
    *,
    unit: str = "",
    example: Any = None,
    said: str = "",
    **more: Any,
) -> Any:
    """A field of a table, and all that is said of it: `meaning` and `unit` by `hpc-gfmd help scene`
    and in the scenes of `hpc-gfmd init`, `allowed` there and in error messages. example: a value
    where there is no default, or none that says how it is written; said: what stands for the
    default where that depends on other keys; more: of pydantic.Field."""
    default = {} if "default_factory" in more else {"default": default}
    return Field(
        description=meaning,
        json_schema_extra={"allowed": allowed, "unit": unit, "example": example, "said": said},
        **default,
        **more,
    )


def allowed(field: Any) -> str:
    """What a field made by `key` may be."""
    return field.json_schema_extra["allowed"]


def one_of(table: BaseModel, *keys: str) -> None:
    """Raise ValueError unless exactly one of `keys` is set."""
    found = [key for key in keys if getattr(table, key) is not None]
    if len(found) != 1:
        said = f"found {' and '.join(found)}" if found else "not given"
        raise ValueError(f"{said}, allowed: one of {', '.join(keys)}")


def has_unit(value: Any) -> bool:
    """Whether a number, or the numbers of a tuple, were given with a unit."""
    return any(isinstance(item, Quantity) for item in each(value))


def alike(what: str, given: dict[str, Any]) -> None:
    """Raise ValueError if some of the quantities have units and others are plain; 0 and inf are
    the same in any unit, None is not given."""
    numbers = [
        (key, item) for key, value in given.items() for item in each(value) if item and item != inf
    ]
    plain = {key: item for key, item in numbers if not isinstance(item, Quantity)}
    named = {key: item.text for key, item in numbers if isinstance(item, Quantity)}
    if plain and named:
        (one, number), (other, text) = next(iter(plain.items())), next(iter(named.items()))
        raise ValueError(
            f"{one}: found {number:g} beside {other} = {text!r}, allowed: all {what} with units, or"
            " none"
        )
