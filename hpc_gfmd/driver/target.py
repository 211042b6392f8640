"""What a load prescribes: a mean pressure p0, or a quantity whose p0 is found on the way.

`Target` itself is a dead load. `Pressure` (full_contact.py) is one that may close the gap and
`Closing` the smallest that does, `Root` (root.py) is an area, a gap or an approach, and `Held`
(held.py) a gap or an approach with an attraction.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..operators.problem import Problem
    from ..parallel.comm import Comm
    from ..solvers.base import Progress, Solver

DISTINCT = 8.0  # factor on rounding errors: smaller differences of pressures count as none


class Target:
    """A prescribed mean pressure; subclasses change it. The loop (drive.py) calls `follow` after
    every iteration on every grid, `judge`, then `correct`, after every certificate. All are
    collective.
    """

    is_sought = False  # whether p0 is found by iterating
    note: str | None = None  # a remark for the user on the load that was found
    needs_double = False  # whether single precision cannot find the load, as far as known
    from_full_contact = False  # whether the iterations start from a gap of 0
    closes = False  # whether all points have to touch
    spring = 0.0  # stiffness of the spring that presses the body; 0: a dead load
    touches = False  # whether bodies that come apart have to be brought back

    def __init__(self, p0: float):
        self.p0 = p0

    @property
    def half_area(self) -> float:
        """An estimate of half the relative contact area; p0 is right at light loads."""
        return self.p0

    def learn_heights(self, working: Any) -> None:
        """Learn what is needed of the heights of a WorkingSurface in the solver's precision."""

    def begin(self, problem: Problem | None = None) -> float:
        """Begin on the grid of a coarse problem, or on the finest grid (None); return p0."""
        return self.p0

    def begin_at(self, p0: float) -> None:
        """Set the mean pressure to begin with."""
        self.p0 = p0

    def agree(self, comm: Comm) -> None:
        """Copy the state of this target from rank 0 to all ranks."""
        vars(self).update(comm.bcast(vars(self)))

    def follow(self, solver: Solver, progress: Progress, coarse: bool = False) -> bool:
        """Go to another load if the solution would probably miss; return whether it changed."""
        return False

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """Return whether a certificate may find area and target accurate; a pass over points."""
        return area_may_be_met(solver, progress, accuracy)

    def certificate_of(self, solver: Solver, certificate: Certificate) -> Certificate:
        """Return a certificate with the errors that this target makes of those at the same load."""
        return certificate

    def judge(self, solver: Solver, certificate: Certificate) -> float:
        """Return by how much a certificate misses the target, over what is allowed."""
        return 0.0

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Go to another load after a miss that `judge` has seen; return whether it changed."""
        return False

    def bring_back(self, solver: Solver) -> bool:
        """Press bodies that have come apart together again; return False to give up."""
        return False


def area_may_be_met(solver: Solver, progress: Progress, accuracy: float) -> bool:
    """Return whether a certificate may find the area accurate enough; True without an estimate."""
    estimate = progress.estimate
    return estimate is None or solver.expected_area(estimate) < accuracy
