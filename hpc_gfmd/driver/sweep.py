"""One load after another on one surface: in which precision, from which start, and what comes
out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..bodies.halfspace import HALF_SPACE
from ..contact.other_branch import compared
from ..parallel import interrupt
from ..util.errors import SceneError
from .branches import SaddleGuard
from .contact_model import ContactModel
from .drive import drive
from .full_contact import ClosingSearch, needs_double
from .held import Held
from .load import Load, Unfinished
from .load_quantities import OpeningSearch
from .low_memory import LowMemorySurface
from .precision import first_precision, too_little, too_soft
from .scene_loads import loads_of
from .searches import Searches
from .starter import Starter
from .without_iterations import Attempt, contact_of, flat_contact, full_contact, separated_contact
from .working_surface import WorkingSurface

if TYPE_CHECKING:
    from ..bodies.base import Body
    from ..contact.contact import Contact
    from ..laws.base import Law
    from ..scene import LoadTable, SolverTable
    from ..surface import Surface
    from .drive import Outcome, Watch
    from .working_surface import MakeSurface

DOUBLE = np.dtype(np.float64)


def make_sweep(
    make_surface: MakeSurface,
    settings: SolverTable,
    E_star: float = 1.0,
    lam_s: float | None = None,
    duality: bool = False,
    body: Body = HALF_SPACE,
    hardness: float | None = None,
    attraction: Law | None = None,
    branch: str = "approach",
    unique: bool = False,
) -> Sweep:
    """Compose the sweep of a surface.

    Collective.

    Parameters
    ----------
    make_surface : callable
        Makes the surface.Surface in a precision: ``make_surface(dtype)``.
    settings : scene.SolverTable
        The table [solver] of a scene.
    E_star, body, hardness, lam_s, attraction, branch, unique
        See `ContactModel`.
    duality : bool
        Whether the certificates have to give the duality gap.

    Raises
    ------
    SceneError
        For a solver, or a surface, that low memory cannot do with.

    Returns
    -------
    Sweep
        Which has made the surface in the first precision.
    """
    model = ContactModel(float(E_star), body, hardness, attraction, branch, unique, lam_s)
    return _sweep_with(make_surface, settings, model, duality)


def _sweep_with(
    make_surface: MakeSurface, settings: SolverTable, model: ContactModel, duality: bool = False
) -> Sweep:
    """Compose the sweep of a surface; see `make_sweep`."""
    starter = Starter(settings, duality)
    kind = WorkingSurface
    if settings.low_memory:
        if starter.solver_class.name != "bpx":
            raise SceneError('solver.low_memory: found true, allowed: with solver.name = "bpx"')
        kind = LowMemorySurface
    surface_in = partial(kind, make_surface, model, nests=starter.nests)
    return Sweep(surface_in, starter, Searches(settings))


class Sweep:
    """Solves loads on one surface in the order given.

    Parameters
    ----------
    surface_in : callable
        Makes the WorkingSurface in a precision: ``surface_in(dtype)``. Collective.
    starter : Starter
        Starts the solver at each load.
    searches : Searches
        Begins the search for each load that is no pressure.

    Attributes
    ----------
    working : WorkingSurface
        The surface in the present precision.
    """

    def __init__(
        self, surface_in: Callable[[np.dtype], WorkingSurface], starter: Starter, searches: Searches
    ):
        self.surface_in = surface_in
        self.starter = starter
        self.searches = searches
        self.settings = starter.settings
        self._failed = False
        self._separated_at: Load | None = None  # the load before, where it has pulled too much
        self._punch: np.ndarray | None = None  # see _flat_solution
        self.working = surface_in(first_precision(self.settings))

    @property
    def surface(self) -> Surface:
        """The surface in the present precision."""
        return self.working.surface

    @property
    def dtype(self) -> np.dtype:
        """The present precision; once a load is in double precision, all others are."""
        return self.working.dtype

    def loads(self, table: LoadTable) -> list[Load]:
        """Return the loads that the table [load] of a scene asks for.

        Collective. Raises SceneError for what this surface does not have, see `loads_of`.
        """
        return loads_of(table, self.working, self.settings, self.starter.solver_class)

    def solve(
        self, load: Load, watch: Watch | None = None, unfinished: Unfinished | None = None
    ) -> Contact:
        """Solve one load.

        Collective.

        Parameters
        ----------
        load : Load
            As for `loads`; it stays as it is.
        watch : callable, optional
            Called after every iteration, ``watch(iterations, progress)``; a true value stops.
        unfinished : Unfinished, optional
            What is there of this load from a run that was stopped: it goes on from there.

        Returns
        -------
        Contact
            It refers to the solver's fields, which the next load overwrites.

        Raises
        ------
        Stopped
            On all ranks, when the run is to stop before the first iteration.
        """
        if self.working.is_flat:
            return flat_contact(self.working, load, self.starter.criterion)
        if self._failed and not self.working.model.retracts:
            self.starter.forget()
        held = None
        if self.working.model.attraction is not None and not load.is_pressure:
            if self.working.model.retracts and load.is_beyond(self._separated_at):
                separated = self._separated(load, 0, 0.0).contact
                assert separated is not None
                return separated
            load, held, pairs = self._held(load, unfinished)
        else:
            load = self.searches.begin(load, self.working)
            pairs = self._solve_before(load)
        if unfinished is not None:
            pairs += unfinished.pairs
            if load.search is not None:
                load.search.begin_at(unfinished.p_mean / self.working.pressure_unit)
        contact = None
        *tried_before, final = self._precisions(load, unfinished)
        gap = held if unfinished is None else unfinished.gap
        gap_before = self._gap_before(load) if gap is None and final != self.dtype else None
        for dtype in (*tried_before, final):
            if dtype != self.dtype:
                self._work_in(dtype)
                gap = gap_before if gap is None else gap
            contact, pairs = self._attempt(load, watch, unfinished, gap, pairs, dtype != final)
            if contact is not None:
                break
        assert contact is not None  # the final precision always gives one
        self._failed = contact.status not in ("converged", "interrupted", "separated")
        self._separated_at = load if contact.is_separated else None
        searched = self.working.model.attraction is None  # no other load is
        if contact.status == "converged" and searched:
            self.searches.remember(contact, self.working)
        if self.working.model.unique:
            return self._with_other_branch(contact)
        return contact

    # -- precisions

    def _precisions(self, load: Load, unfinished: Unfinished | None) -> list[np.dtype]:
        """Return the precisions in which a load is tried, one after the other."""
        if self.settings.precision != "auto" or self.dtype == DOUBLE:
            return [self.dtype]
        was_in_double = unfinished is not None and unfinished.gap.dtype == DOUBLE
        if was_in_double or self._is_too_little(load):
            return [DOUBLE]
        return [self.dtype, DOUBLE]

    def _gap_before(self, load: Load) -> np.ndarray | None:
        """Return a copy of the gap of the load before, from which a load on the retraction branch
        starts in whatever precision; None where it starts by itself."""
        if self.working.model.retracts and self.starter.follows(self.working, load):
            return self.starter.gap.copy()
        return None

    def _is_too_little(self, load: Load) -> bool:
        """Return whether single precision is known to be too little for a load."""
        if load.search is not None and load.search.needs_double:
            return True
        settings = self.settings
        surface = self.surface
        h_rms = surface.h_rms / surface.height_unit
        if too_soft(settings.accuracy, h_rms, self.working.hardness):
            return True
        return too_little(settings, surface.grid.N, load.half_area)

    def _work_in(self, dtype: np.dtype) -> None:
        """Go on with the surface in another precision. Raises SceneError where its heights have
        changed."""
        if dtype == self.dtype:
            return
        checksum = self.surface.checksum
        self.starter.forget()
        self.working.release()
        del self.working  # its memory is needed for the next one
        self.working = self.surface_in(dtype)
        if checksum not in (None, self.surface.checksum):
            raise SceneError("surface.path: the heights have changed since this run read them")

    # -- one load in one precision

    def _attempt(
        self,
        load: Load,
        watch: Watch | None,
        unfinished: Unfinished | None,
        gap: np.ndarray | None,
        pairs: float,
        may_need_double: bool,
    ) -> Attempt:
        """Solve a load in the present precision.

        gap: where to start, None: as the starter finds it; pairs: FFT pairs that the load has taken
        before; may_need_double: whether single precision may turn out to be too little.
        """
        if load.search is not None:
            load.search.measure(lambda: self.working.heights)
        model = self.working.model
        attracts = model.attraction is not None
        begins = gap is None and not self.starter.follows(self.working, load)
        if attracts and load.p0 < 0 and begins:
            return self._separated(load, 0, pairs)
        closed = full_contact(self.working, load, self.starter.criterion, pairs)
        if closed.contact is not None:
            return closed
        start = self.starter.start(self.working, load, gap)
        solver = start.solver
        if unfinished is not None:
            solver.iterations = unfinished.iterations
        pairs = closed.pairs + start.pairs
        if may_need_double and self._is_too_little(load):  # as the coarser grids have found
            return Attempt(None, pairs + solver.pairs)
        guard = SaddleGuard(solver, model.branch) if attracts else None
        outcome = drive(solver, start.criterion, watch, load.search, guard)
        pairs += solver.pairs + outcome.pairs
        if outcome.status == "separated":
            return self._separated(load, solver.iterations, pairs)
        contact = contact_of(
            self.working,
            load,
            start.criterion,
            solver.p0,
            solver.g,
            solver.p,
            self._status_of(outcome, load),
            outcome.certificate,
            iterations=solver.iterations,
            pairs=pairs,
        )
        if may_need_double and (
            needs_double(contact, load, solver.problem_now) or self._is_too_little(load)
        ):
            return Attempt(None, pairs)
        return Attempt(contact, pairs)

    def _status_of(self, outcome: Outcome, load: Load) -> str:
        """Return the status of a load: what a search found in single precision is no target met
        where that takes double precision."""
        doubtful = load.search is not None and load.search.needs_double
        if outcome.status == "converged" and doubtful and self.dtype != DOUBLE:
            return "stagnated"
        return outcome.status

    def _separated(self, load: Load, iterations: int, pairs: float) -> Attempt:
        """Return what is left where the load pulls more than the attraction."""
        self.starter.forget()
        criterion = self.starter.criterion
        contact = separated_contact(self.working, load, criterion, iterations, pairs)
        return Attempt(contact, pairs)

    # -- other contacts on the same surface

    def _on_same_surface(self, model: ContactModel) -> Sweep:
        """Return a sweep of another model on this surface, in the present precision."""
        precision = "double" if self.dtype == DOUBLE else "single"
        settings = self.settings.model_copy(update={"precision": precision})
        return _sweep_with(lambda dtype: self.surface, settings, model)

    def _with_other_branch(self, contact: Contact) -> Contact:
        """Solve a load on the other branch, too, and say of its contact whether both agree.

        Retraction begins at closed surfaces, which are the smallest gaps that there are, approach
        as it always does.
        """
        sweep = self._on_same_surface(self.working.model.on_other_branch)
        start = None
        if sweep.working.model.retracts:
            start = Unfinished(np.zeros_like(contact.g), contact.p_mean, iterations=0, pairs=0.0)
        other = sweep.solve(Load("pressure", contact.p_mean), self._raise_if_stopped, start)
        return replace(
            contact, other_branch=compared(contact, other), pairs=contact.pairs + other.pairs
        )

    def _held(self, load: Load, unfinished: Unfinished | None) -> tuple[Load, np.ndarray, float]:
        """Return a load that is held by a spring, the gap from which it starts, and the FFT pairs
        that this took: on retraction that of the load before, else the contact without attraction.
        Collective."""
        working, solver = self.working, self.starter.solver
        pairs = 0.0
        if unfinished is not None:
            gap, p0 = unfinished.gap, unfinished.p_mean / working.pressure_unit
        elif working.model.retracts and solver is not None:
            gap, p0 = solver.g.copy(), solver.p0
        else:
            bare = self._on_same_surface(working.model.without_attraction)
            start = bare.solve(load, self._raise_if_stopped)
            gap, p0, pairs = start.g, start.p_mean / working.pressure_unit, start.pairs
        target = load.value / working.surface.height_unit
        search = Held(load.quantity, target, self.settings.tolerance, p0, working.problem(p0))
        return replace(load, search=search), gap, pairs

    # -- what some loads need before their own

    def _solve_before(self, load: Load) -> float:
        """Solve the contacts that the search for a load begins with; return the FFT pairs that they
        took."""
        search = load.search
        if isinstance(search, ClosingSearch) and self.surface.grid.padded:
            search.unit, pairs = self._flat_solution()
            return pairs
        if isinstance(search, OpeningSearch):
            closed = self.solve(Load("a_r", 1.0), self._raise_if_stopped)
            search.begin_below(closed.p_mean / closed.pressure_unit)
            return closed.pairs
        return 0.0

    def _flat_solution(self) -> tuple[np.ndarray, float]:
        """Return what `ClosingSearch.unit` needs, solved once, and the FFT pairs that it took."""
        if self._punch is not None:
            return self._punch, 0.0
        surface = self.surface
        rows, points = surface.grid.inside
        self.starter.forget()  # its memory is needed now

        def flat(dtype: np.dtype) -> Surface:
            h = np.zeros((rows, points), dtype)
            return replace(surface, h=h, h_rms=0.0, g_rms=0.0, checksum=None)

        sweep = make_sweep(flat, self.settings, body=self.working.model.body)
        contact = sweep.solve(Load("pressure", 1.0), self._raise_if_stopped)
        self._punch = contact.g
        self._punch[:rows, :points] = contact.p[:rows, :points]
        return self._punch, contact.pairs

    def _raise_if_stopped(self, *_: object) -> None:
        """Raise Stopped on all ranks when the run is to stop: nothing of this contact is kept."""
        interrupt.check(self.surface.grid.comm)
