"""What is pressed against the surface: the same for all loads and precisions of a sweep."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ..bodies.halfspace import HALF_SPACE
from .branches import APPROACH, RETRACTION

if TYPE_CHECKING:
    from ..bodies.base import Body
    from ..laws.base import Law


@dataclass(frozen=True)
class ContactModel:
    """The elastic body and its material.

    Attributes
    ----------
    E_star : float
        Effective modulus; all pressures of a scene are in its unit.
    body : Body
        The elastic body, see bodies/.
    hardness : float or None
        The largest pressure, in the unit of E_star; None: there is none.
    attraction : Law or None
        Law of attraction, in the unit of E_star and that of the surface's lengths; None: there is
        none.
    branch : str
        "approach" or "retraction", see branches.py.
    unique : bool
        Whether each load is solved on the other branch, too.
    lam_s : float or None
        Shortest wavelength of the surface, in its unit of length, where that is known.
    """

    E_star: float = 1.0
    body: Body = HALF_SPACE
    hardness: float | None = None
    attraction: Law | None = None
    branch: str = APPROACH
    unique: bool = False
    lam_s: float | None = None

    @property
    def on_other_branch(self) -> ContactModel:
        """The same on the other branch, alone."""
        branch = APPROACH if self.branch == RETRACTION else RETRACTION
        return replace(self, branch=branch, unique=False)

    @property
    def without_attraction(self) -> ContactModel:
        """The same of surfaces that do not attract each other."""
        return replace(self, attraction=None, branch=APPROACH, unique=False)

    @property
    def retracts(self) -> bool:
        """Whether each load starts from the larger one before."""
        return self.attraction is not None and self.branch == RETRACTION
