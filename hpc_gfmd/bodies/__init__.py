"""One elastic body per file (base.py says what it is); no other folder knows a stiffness."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..util.errors import SceneError
from ..util.plugins import class_in, names_in
from ..util.quantities import format_quantity

if TYPE_CHECKING:
    from ..scene import Material
    from .base import Body

COMMON = ("base", "images")  # files without a body


def body_classes() -> dict[str, type[Body]]:
    """Import all elastic bodies, those of other packages included, and return {name: class}."""
    return {name: class_in(__name__, name) for name in names_in(__name__, COMMON)}


def body_of(material: Material, free: tuple[bool, bool] = (False, False)) -> Body:
    """Return the first body that accepts the material and boundaries of a scene."""
    for cls in body_classes().values():
        if body := cls.of(material, free):
            return body
    thickness = format_quantity(material.thickness or 0.0)
    raise SceneError(
        f"material.thickness: found {thickness} with a free boundary, allowed: with periodic"
        " boundaries"
    )
