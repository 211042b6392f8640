"""What a load begins with: its target, and a gap to start from where it has to be that one.

Some targets take another contact first: next to full contact the closed one, full contact with free
edges a flat punch, a gap or an approach with an attraction the contact without it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from .full_contact import Closing, Pressure
from .held import Held
from .quantities import NEARLY_CLOSED, ROOTS, Opening, opening_load
from .target import Target

if TYPE_CHECKING:
    import numpy as np

    from ..contact.contact import Contact
    from .load import Load, Unfinished
    from .starter import Starter
    from .working_surface import WorkingSurface


@dataclass
class Beginning:
    """What a load begins with, in any precision."""

    target: Target
    gap: np.ndarray | None = None  # where to start (local slab); None: as the Starter chooses
    pairs: float = 0.0  # FFT pairs so far: of other contacts, of interrupted runs, of attempts


class Solves(Protocol):
    """What Preparation asks of a Sweep: the present surface and starts, and other contacts. The
    latter are collective, and raise Stopped on all ranks.
    """

    working: WorkingSurface
    starter: Starter

    def closed(self) -> Contact:
        """Solve full contact at the smallest load, perhaps in double precision from then on."""

    def flat_punch(self) -> Contact:
        """Solve a flat punch of the surface's size at a mean pressure of 1."""

    def without_attraction(self, load: Load) -> Contact:
        """Solve a load without attraction, in the present precision."""


class Preparation:
    """Prepares the loads of a sweep, each with what those before have told. Collective."""

    def __init__(self) -> None:
        self._solved: list[dict[str, float]] = []  # of the last two loads, see `remember`
        self._punch: np.ndarray | None = None  # see `_closing`

    def of(self, load: Load, sweep: Solves, unfinished: Unfinished | None = None) -> Beginning:
        """Return what a load of a sweep begins with; unfinished: state of an interrupted run."""
        beginning = self._new(load, sweep, unfinished)
        if unfinished is not None:
            beginning.gap = unfinished.gap
            beginning.pairs += unfinished.pairs
            beginning.target.begin_at(unfinished.p_mean / sweep.working.pressure_unit)
        return beginning

    def remember(self, contact: Contact) -> None:
        """Store load, area, gap and approach of a solution, from which later targets begin."""
        a = contact.grid.a
        solved = {
            "p0": contact.p_mean / contact.pressure_unit,
            "a_r": contact.contact_points / contact.N,
            "gap_mean": contact.certificate.gap_mean * a,
            "approach": contact.certificate.approach * a,
        }
        self._solved = [*self._solved[-1:], solved]

    def _new(self, load: Load, sweep: Solves, unfinished: Unfinished | None) -> Beginning:
        """Return what a load begins with, its pressure as far as other loads tell it."""
        working = sweep.working
        model = working.model
        if load.is_pressure:
            kind = Target if model.attraction is not None else Pressure
            return Beginning(kind(load.value / working.pressure_unit))
        if model.attraction is not None:
            return _held(load, sweep, unfinished)
        if load.closes:
            return self._closing(sweep)
        is_area = load.quantity == "a_r"
        value = load.value if is_area else load.value / working.surface.slope
        if load.quantity == "gap_mean" and model.hardness is None:
            opens = opening_load(load.value, working)
            if opens < NEARLY_CLOSED:
                return _opening(value, opens, sweep)
        return Beginning(ROOTS[load.quantity](value, working, self._solved))

    def _closing(self, sweep: Solves) -> Beginning:
        """Return the target of full contact; with free edges by pressure on and displacement beyond
        a flat punch, which is solved once.
        """
        tolerance = sweep.working.settings.tolerance
        grid = sweep.working.surface.grid
        if not grid.padded:
            return Beginning(Closing(tolerance))
        pairs = 0.0
        if self._punch is None:
            contact = sweep.flat_punch()
            rows, points = grid.inside
            self._punch = contact.g
            self._punch[:rows, :points] = contact.p[:rows, :points]
            pairs = contact.pairs
        return Beginning(Closing(tolerance, self._punch), pairs=pairs)


def _opening(value: float, opens: float, sweep: Solves) -> Beginning:
    """Return the target of a mean gap next to full contact, which is solved first; value: over the
    unit of slopes; opens: its `opening_load`.
    """
    closed = sweep.closed()
    closes_at = closed.p_mean / closed.pressure_unit
    # `closed` may have gone on in double precision, on another working surface
    return Beginning(Opening(value, sweep.working, opens, closes_at), pairs=closed.pairs)


def _held(load: Load, sweep: Solves, unfinished: Unfinished | None) -> Beginning:
    """Return the `Held` of a gap or approach with attraction, and the gap to start from: that of
    `unfinished`, of the load before, or without attraction.
    """
    working = sweep.working
    solver = sweep.starter.solver
    pairs = 0.0
    if unfinished is not None:
        gap = unfinished.gap
        p0 = unfinished.p_mean / working.pressure_unit
    elif working.model.always_continues and solver is not None:
        gap = solver.state.g.copy()
        p0 = solver.state.p0
    else:
        start = sweep.without_attraction(load)
        gap = start.g
        p0 = start.p_mean / working.pressure_unit
        pairs = start.pairs
    target = Held(
        load.quantity,
        load.value / working.surface.height_unit,
        working.settings.tolerance,
        p0,
        working.problem(p0),
        gap_at_touch=working.heights.top / working.surface.grid.a,
        gap_at_start=gap,
    )
    return Beginning(target, gap, pairs)
