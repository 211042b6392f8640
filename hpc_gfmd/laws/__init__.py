"""One law of attraction per file; `base.py` says what a law is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..util.errors import SceneError
from ..util.plugins import class_in, names_in
from .base import Law, is_concave

if TYPE_CHECKING:
    from ..scene import Material

COMMON = ("base",)  # files that are no law


def law_names() -> list[str]:
    """Return the names of all laws of attraction, without importing them."""
    return list(names_in(__name__, COMMON))


def law_class(name: str) -> type[Law]:
    """Return the class of the law of a name."""
    return class_in(__name__, name)


def attraction_of(material: Material) -> Law | None:
    """Return the law that a material (scene.Material) means, None without an attraction.

    In the unit of its moduli and that of the surface's lengths. Raises SceneError.
    """
    adhesion = material.adhesion
    if adhesion is None:
        return None
    return law_named(adhesion.law, adhesion.work, adhesion.range)


def law_named(name: str, work: float, reach: float) -> Law:
    """Make a law of attraction.

    Parameters
    ----------
    name : str
        One of `law_names`.
    work : float
        Work of adhesion per area: the energy between contact and infinity.
    reach : float
        Range of the attraction, a length.

    Returns
    -------
    Law
        In the units of its arguments.

    Raises
    ------
    SceneError
        For a law of another package whose energy is not concave.
    """
    law = law_class(name)(work, reach)
    if not is_concave(law):
        raise SceneError(
            f'material.adhesion.law: found "{name}", whose attraction does not fall with the gap'
            " everywhere, allowed: a law with an energy that is concave in the gap"
        )
    return law
