"""What all tables of a scene share: strictness, number types, what a key says of itself, and the
rule "exactly one of"."""

import os
from collections.abc import Mapping
from math import inf
from typing import Annotated, Any, Literal, TypeVar, get_args

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
    """A frozen table. true is no number, "1" is none, 1.0 is no whole number; inf and nan are
    refused."""

    model_config = ConfigDict(strict=True, frozen=True, extra="forbid", allow_inf_nan=False)


Positive = Annotated[float, Field(ge=SMALLEST, le=LARGEST)]


def _tuple(value: Any) -> Any:
    """Return a list as a tuple, anything else as it is."""
    return tuple(value) if isinstance(value, list) else value


def each(value: Any) -> tuple:
    """Return the values of a list, or the only one, as a tuple."""
    return tuple(value) if isinstance(value, list | tuple) else (value,)


def _in(dimension: str) -> WrapValidator:
    """Let a number be plain, or a text with a unit of this dimension."""

    def read(value: Any, check: Any) -> float:
        if not isinstance(value, str | Quantity):
            return check(value)
        value = parse(value, dimension) if isinstance(value, str) else value
        check(float(value))
        return value

    return WrapValidator(read)


def _from_folder(path: str, scene: ValidationInfo) -> str:
    """Count a relative path from the folder of the scene file, where there is one."""
    return os.path.join(scene.context, path) if scene.context else path


def _length_unit(text: str) -> str:
    """Return the name of a unit of length. Raises ValueError for any other text."""
    factor(text)
    return text


def _printable(text: str) -> str:
    """Return a text. Raises ValueError where it has control characters."""
    if not text.isprintable():
        raise ValueError("control characters")
    return text


def _distinct(values: tuple) -> tuple:
    """Return values. Raises ValueError where one is there twice."""
    if len(set(values)) < len(values):
        raise ValueError("named twice")
    return values


def _not_tiny(value: float) -> float:
    """Return a number. Raises ValueError where it is so small that it would be taken for 0."""
    if 0 < abs(value) < SMALLEST:
        raise ValueError(f"the least magnitude is {SMALLEST:g}")
    return value


def _bent(radii: Any) -> Any:
    """Return radii. Raises ValueError where both axes are straight."""
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
Height = Annotated[float, Field(ge=-LARGEST, le=LARGEST), _in("length"), AS_GIVEN]
Length = Annotated[Positive, _in("length"), AS_GIVEN]
Radius = Annotated[float, Field(ge=SMALLEST, allow_inf_nan=True), _in("length"), AS_GIVEN]
Radii = Annotated[Radius | tuple[Radius, Radius], LIST, AfterValidator(_bent)]
Coordinate = Annotated[NotNegative, _in("length"), AS_GIVEN]
Pressure = Annotated[Positive, _in("pressure"), AS_GIVEN]
Force = Annotated[Positive, _in("force"), AS_GIVEN]
Work = Annotated[Positive, _in("work"), AS_GIVEN]
# of loads, which pull where the surfaces attract each other
Signed = Annotated[float, Field(ge=-LARGEST, le=LARGEST), AfterValidator(_not_tiny)]
SignedPressure = Annotated[Signed, _in("pressure"), AS_GIVEN]
SignedForce = Annotated[Signed, _in("force"), AS_GIVEN]
SignedLength = Annotated[Signed, _in("length"), AS_GIVEN]
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


def key(
    meaning: str,
    default: Any = ...,
    *,
    allowed: str = "",
    unit: str = "",
    example: Any = None,
    said: str = "",
    **more: Any,
) -> Any:
    """Make a field of a table, with all that help and messages say of it.

    Parameters
    ----------
    meaning : str
        What the key is, for `hpc-gfmd help scene` and the scenes of `hpc-gfmd init`.
    default : object
        Its value where a scene does not give it; without one it must be given.
    allowed : str
        Values that it may have, where the type does not say it (`allowed_of`).
    unit : str
        "length", "pressure", "force", or the name of a unit; "" for a plain number.
    example : object
        A value for the scenes of `hpc-gfmd init`; by default the default.
    said : str
        Text shown in place of a default that depends on other keys.
    **more
        All else that pydantic.Field takes.

    Returns
    -------
    FieldInfo
        For the body of a Table.
    """
    example = default if example is None else example
    extra = {"allowed": allowed, "unit": unit, "example": example, "said": said}
    return Field(default, description=meaning, json_schema_extra=extra, **more)


def about(field: Any) -> dict[str, Any]:
    """Return the arguments of `key` that made a field, by name; empty for other fields."""
    return field.json_schema_extra or {}


def allowed_of(field: Any) -> str:
    """Describe the values that a field made by `key` may have, from its type and bounds."""
    extra = about(field)
    return extra["allowed"] or allowed_values(
        field.annotation, tuple(field.metadata), extra["unit"]
    )


def table_fields(field: Any) -> Mapping[str, Any]:
    """Return the keys of the table, or of the tables in a list, that a key takes, {name: field};
    none of others."""
    types = [field.annotation]
    for annotation in types:  # those inside of others, too
        if hasattr(annotation, "model_fields"):
            return annotation.model_fields
        types.extend(get_args(annotation))
    return {}


def one_of(table: BaseModel, *keys: str) -> None:
    """Raise ValueError unless exactly one of some keys is set.

    Parameters
    ----------
    table : Table
        The table.
    *keys : str
        Its keys, None where they are not set.

    Raises
    ------
    ValueError
        With the keys that are set.
    """
    present = [key for key in keys if getattr(table, key) is not None]
    if len(present) != 1:
        found_text = f"found {' and '.join(present)}" if present else "not given"
        raise ValueError(f"{found_text}, allowed: one of {', '.join(keys)}")


def has_unit(value: Any) -> bool:
    """Return whether a number, or one of a tuple, was given with a unit."""
    return any(isinstance(item, Quantity) for item in each(value))


def alike(noun: str, quantities: dict[str, Any]) -> None:
    """Raise ValueError if some quantities have units and others are plain.

    Parameters
    ----------
    noun : str
        What they are, such as "lengths".
    quantities : dict
        Numbers, or tuples of them, by key. 0 and inf are the same in any unit; None is not given.

    Raises
    ------
    ValueError
        With all keys of both groups.
    """
    numbers = [
        (key, number)
        for key, value in quantities.items()
        for number in each(value)
        if number and number != inf
    ]
    plain = {key: number for key, number in numbers if not isinstance(number, Quantity)}
    texts = {key: number.text for key, number in numbers if isinstance(number, Quantity)}
    if plain and texts:
        without_unit = ", ".join(f"{key}: found {number:g}" for key, number in plain.items())
        with_unit = ", ".join(f"{key} = {text!r}" for key, text in texts.items())
        raise ValueError(
            f"{without_unit} beside {with_unit}, allowed: all {noun} with units, or none"
        )
