"""Common parts of all tables of a scene: strict validation, types of numbers, keys."""

import os
from collections.abc import Collection, Mapping
from functools import cache
from math import inf
from typing import Annotated, Any, Literal, Self, TypeVar, get_args

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
from .allowed import LARGEST, MAX_INT, SMALLEST, allowed_values

MAX_N = 2**24  # grid points per direction


class Table(BaseModel):
    """A frozen table with strict types; inf and nan are refused.

    true and "1" are not accepted as numbers, nor 1.0 as an integer.
    """

    model_config = ConfigDict(strict=True, frozen=True, extra="forbid", allow_inf_nan=False)

    def __deepcopy__(self, memo: Any = None) -> Self:
        """Return the table itself, which is never changed."""
        return self


Positive = Annotated[float, Field(ge=SMALLEST, le=LARGEST)]


def _tuple(value: Any) -> Any:
    """Return a list as a tuple, any other value as it is."""
    return tuple(value) if isinstance(value, list) else value


def each(value: Any) -> tuple:
    """Return a list or tuple as a tuple, and any other value as a tuple of this one value."""
    return tuple(value) if isinstance(value, list | tuple) else (value,)


def _with_unit(dimension: str) -> WrapValidator:
    """Return a validator of numbers that makes a text with a unit a Quantity."""

    def read(value: Any, check: Any) -> float:
        """Return a plain number, checked with its bounds, or the Quantity of a text."""
        if not isinstance(value, str | Quantity):
            return check(value)
        value = parse(value, dimension) if isinstance(value, str) else value
        check(float(value))
        return value

    return WrapValidator(read)


def _from_folder(path: str, scene: ValidationInfo) -> str:
    """Return a path; a relative one is joined to the folder of the scene file, if known."""
    return os.path.join(scene.context, path) if scene.context else path


def _length_unit(text: str) -> str:
    """Return the name of a unit of length. Raises ValueError for any other text."""
    factor(text)
    return text


def _printable(text: str) -> str:
    """Return a text. Raises ValueError if it has control characters."""
    if not text.isprintable():
        raise ValueError("control characters")
    return text


def _distinct(values: tuple) -> tuple:
    """Return values. Raises ValueError if a value occurs twice."""
    if len(set(values)) < len(values):
        raise ValueError("named twice")
    return values


def _not_tiny(value: float) -> float:
    """Return a number. Raises ValueError if it is not 0 but below SMALLEST in magnitude."""
    if 0 < abs(value) < SMALLEST:
        raise ValueError(f"the least magnitude is {SMALLEST:g}")
    return value


def _bent(radii: Any) -> Any:
    """Return radii. Raises ValueError if all of them are inf (straight along both axes)."""
    if radii in (inf, (inf, inf)):
        raise ValueError("straight along both axes")
    return radii


AS_GIVEN = PlainSerializer(lambda value: getattr(value, "text", value))  # with its unit
LIST = BeforeValidator(_tuple)
DISTINCT = AfterValidator(_distinct)

NotNegative = Annotated[float, Field(ge=0, le=LARGEST)]
Fraction = Annotated[float, Field(gt=0, lt=1)]
Share = Annotated[float, Field(gt=0, le=1)]
Ratio = Annotated[float, Field(ge=1, le=LARGEST)]
Height = Annotated[float, Field(ge=-LARGEST, le=LARGEST), _with_unit("length"), AS_GIVEN]
Length = Annotated[Positive, _with_unit("length"), AS_GIVEN]
Radius = Annotated[float, Field(ge=SMALLEST, allow_inf_nan=True), _with_unit("length"), AS_GIVEN]
Radii = Annotated[Radius | tuple[Radius, Radius], LIST, AfterValidator(_bent)]
Coordinate = Annotated[NotNegative, _with_unit("length"), AS_GIVEN]
Pressure = Annotated[Positive, _with_unit("pressure"), AS_GIVEN]
Force = Annotated[Positive, _with_unit("force"), AS_GIVEN]
Work = Annotated[Positive, _with_unit("work"), AS_GIVEN]
# of loads, which pull where the surfaces attract each other
Signed = Annotated[float, Field(ge=-LARGEST, le=LARGEST), AfterValidator(_not_tiny)]
SignedPressure = Annotated[Signed, _with_unit("pressure"), AS_GIVEN]
SignedForce = Annotated[Signed, _with_unit("force"), AS_GIVEN]
SignedLength = Annotated[Signed, _with_unit("length"), AS_GIVEN]
Time = Annotated[Positive, _with_unit("time"), AS_GIVEN]
Moment = Annotated[NotNegative, _with_unit("time"), AS_GIVEN]
LengthUnit = Annotated[str, AfterValidator(_length_unit)]
Whole = Annotated[int, Field(ge=1, le=MAX_INT)]
Text = Annotated[str, AfterValidator(_printable)]
Path = Annotated[Text, Field(min_length=1)]
MapPath = Annotated[Path, AfterValidator(_from_folder)]
Paths = Annotated[MapPath | tuple[MapPath, MapPath], LIST]
Corners = Annotated[tuple[Coordinate, Coordinate, Coordinate, Coordinate], LIST]
Points = Annotated[int, Field(ge=1, le=MAX_N)]
Modes = Annotated[int, Field(ge=0, le=MAX_N)]
T = TypeVar("T")
Pair = Annotated[tuple[T, T], LIST]  # of x and y, or of the lowest and the highest
Loads = Annotated[tuple[T, ...], Field(min_length=1), BeforeValidator(each)]  # one, or a list

Side = Literal["periodic", "free"]
Boundary = Annotated[Side | tuple[Side, Side], LIST]
MapSide = Literal["periodic", "mirror", "free"]
MapBoundary = Annotated[MapSide | tuple[MapSide, MapSide], LIST]


def key(
    meaning: str,
    default: Any = ...,
    *,
    allowed: str = "",
    unit: str = "",
    example: Any = None,
    default_text: str = "",
    **more: Any,
) -> Any:
    """Return a pydantic field with all that help and messages show. allowed: unless derived from
    the type; unit: "length" or "s"; example: for `init`; default_text: in place of the default.
    """
    example = default if example is None else example
    extra = {"allowed": allowed, "unit": unit, "example": example, "default_text": default_text}
    return Field(default, description=meaning, json_schema_extra=extra, **more)


def about(field: Any) -> dict[str, Any]:
    """Return what `key` stored in a field: "allowed", "unit", "example", "default_text"."""
    return field.json_schema_extra or {}


@cache
def keys_with_unit(table: type[Table], dimension: str) -> tuple[str, ...]:
    """Return the keys of a table whose numbers have a dimension, such as "length"."""
    fields = table.model_fields.items()
    return tuple(name for name, field in fields if about(field).get("unit") == dimension)


def allowed_of(field: Any) -> str:
    """Return the description of allowed values, given to `key` or derived from the type."""
    extra = about(field)
    return extra["allowed"] or allowed_values(
        field.annotation, tuple(field.metadata), extra["unit"]
    )


def table_fields(field: Any) -> Mapping[str, Any]:
    """Return {key: field} of the table, or of the tables in a list, that a field takes, if any."""
    types = [field.annotation]
    for annotation in types:  # those inside of others, too
        if hasattr(annotation, "model_fields"):
            return annotation.model_fields
        types.extend(get_args(annotation))
    return {}


def one_of(table: BaseModel, *keys: str) -> None:
    """Raise ValueError, with the keys that are set, unless exactly one of some keys is set."""
    present = [key for key in keys if getattr(table, key) is not None]
    if len(present) != 1:
        found_text = f"found {' and '.join(present)}" if present else "not given"
        raise ValueError(f"{found_text}, allowed: one of {', '.join(keys)}")


def has_unit(value: Any) -> bool:
    """Whether a number, or at least one number of a tuple, was given with a unit."""
    return any(isinstance(item, Quantity) for item in each(value))


def alike(noun: str, quantities: dict[str, Any], defaults: Collection[str] = ()) -> None:
    """Raise ValueError if some quantities (not 0, inf, None) have units and others none."""
    numbers = [
        (key, number)
        for key, value in quantities.items()
        for number in each(value)
        if number and number != inf
    ]
    plain = {key: number for key, number in numbers if not isinstance(number, Quantity)}
    texts = {key: number.text for key, number in numbers if isinstance(number, Quantity)}
    if plain and texts:
        without_unit = ", ".join(
            f"{key}: {'not given, hence' if key in defaults else 'found'} {number:g}"
            for key, number in plain.items()
        )
        with_unit = ", ".join(f"{key} = {text!r}" for key, text in texts.items())
        raise ValueError(
            f"{without_unit} beside {with_unit}, allowed: all {noun} with units, or none"
        )
