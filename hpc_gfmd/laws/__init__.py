"""One law of attraction per file; `base.py` says what a law is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..util.errors import SceneError
from ..util.plugins import class_in, names_in
from .base import Law, is_concave

if TYPE_CHECKING:
    from ..scene import Material

COMMON = ("base",)  # files of this folder without a law


def law_names() -> list[str]:
    """List the names of all laws, including those of other packages, without importing them."""
    return list(names_in(__name__, COMMON))


def law_class(name: str) -> type[Law]:
    """Import the file of a law and return its class, or raise GfmdError."""
    return class_in(__name__, name)


def attraction_of(material: Material) -> Law | None:
    """Make the law of a scene.Material, or None; SceneError for a plug-in's that is not concave."""
    adhesion = material.adhesion
    if adhesion is None:
        return None
    return law_named(adhesion.law, adhesion.work, adhesion.range)


def law_named(name: str, work: float, reach: float) -> Law:
    """Return the law of this name; SceneError unless its energy is concave (a plug-in's may not
    be).
    """
    law = law_class(name)(work, reach)
    if not is_concave(law):
        raise SceneError(
            f'material.adhesion.law: the attraction of "{name}" does not fall with the gap'
            " everywhere; its energy must be concave in the gap"
        )
    return law
