"""What is pressed against the surface: the same for all loads and precisions of a sweep."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ..bodies.halfspace import HALF_SPACE
from .branches import APPROACH, CYCLE, RETRACTION

if TYPE_CHECKING:
    from ..bodies.base import Body
    from ..laws.base import Law
    from .load import Load


@dataclass(frozen=True)
class ContactModel:
    """The elastic body, its material, and how branches are followed."""

    E_star: float = 1.0  # effective modulus; all pressures of a scene are in its unit
    body: Body = HALF_SPACE
    # the largest pressure, in the unit of E_star; None for an elastic solid
    hardness: float | None = None
    attraction: Law | None = None  # in the unit of E_star and that of the surface's lengths
    branch: str = APPROACH  # which equilibrium is sought with an attraction (branches.py)
    unique: bool = False  # each load is also solved on the other branch
    # shortest wavelength of the surface, in its unit of length; None if unknown
    lam_s: float | None = None
    # of the heights, where loads before have changed them, as in `Problem`, in its units
    height_error: float = 0.0

    @property
    def on_other_branch(self) -> ContactModel:
        """A copy with the other branch, and with `unique` off."""
        branch = APPROACH if self.branch == RETRACTION else RETRACTION
        return replace(self, branch=branch, unique=False)

    @property
    def without_attraction(self) -> ContactModel:
        """A copy without attraction, on the approach branch, and with `unique` off."""
        return replace(self, attraction=None, branch=APPROACH, unique=False)

    @property
    def always_continues(self) -> bool:
        """Whether adhesive loads start from the one before, however far: retraction or a cycle."""
        return self.attraction is not None and self.branch in (RETRACTION, CYCLE)

    def branch_of(self, load: Load) -> str:
        """Return the branch of a load: approach or retraction."""
        if self.branch == CYCLE:
            return RETRACTION if load.parts else APPROACH
        return self.branch
