"""The allowed values that messages name are the bounds with which a key is checked."""

import re
from typing import Annotated

import pytest
from pydantic import TypeAdapter, ValidationError

from hpc_gfmd.scene import Scene
from hpc_gfmd.scene.surface import KINDS
from hpc_gfmd.scene.table import about, allowed_of

TABLES = {
    name: field.annotation
    for name, field in Scene.model_fields.items()
    if hasattr(field.annotation, "model_fields")
} | KINDS
FIELDS = {
    f"{table}.{name}": field
    for table, model in TABLES.items()
    for name, field in model.model_fields.items()
    if about(field)
}
NUMBER = re.compile(r"(a|a whole) number (from|above|greater than) (-?[\d.]+)")


def test_every_key_has_a_text_of_allowed_values():
    texts = {name: allowed_of(field) for name, field in FIELDS.items()}
    assert [name for name, text in texts.items() if text in ("", "a text")] == []


BOUNDED = [n for n in FIELDS if NUMBER.match(allowed_of(FIELDS[n]))]


def test_lower_bound_matches_its_text():
    """The bound itself passes if the text includes it; nothing below it passes."""
    for name in BOUNDED:
        field = FIELDS[name]
        kind, word, bound = NUMBER.match(allowed_of(field)).groups()
        number = int(bound) if kind == "a whole" else float(bound)
        check = TypeAdapter(Annotated[(field.annotation, *field.metadata, None)])
        if word == "from":
            check.validate_python(number)
        else:
            with pytest.raises(ValidationError):
                check.validate_python(number)
        with pytest.raises(ValidationError):
            check.validate_python(number - 1)
