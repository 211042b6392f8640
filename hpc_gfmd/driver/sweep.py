"""Solve the loads on one surface, one after another.

A load gets its target (preparation.py), a start (starter.py) and the iterations (drive.py), and
becomes a Contact. Single precision is tried first if the accuracy allows it; where it fails, double
precision goes on from its gap, also for all later loads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..certificate.criterion import StoppingCriterion
from ..parallel import interrupt
from ..util.errors import SceneError
from .branches import CYCLE, SaddleGuard, compared
from .contact_model import ContactModel
from .drive import drive
from .grid_errors import gap_discretisation
from .load import Load, Unfinished
from .low_memory import LowMemorySurface
from .precision import DOUBLE, first_precision, needs_double
from .preparation import Preparation
from .scene_loads import loads_of
from .starter import Starter
from .without_iterations import separated_contact
from .working_surface import WorkingSurface

if TYPE_CHECKING:
    from ..contact.contact import Contact
    from ..scene import LoadTable, SolverTable
    from ..surface import Precision, Surface
    from .drive import Watch
    from .grid_errors import CoarseContact
    from .preparation import Beginning
    from .working_surface import MakeSurface


class Sweep:
    """Solves the loads on one surface, each from the solution before if that is close.

    make_surface(precision): makes the surface, collectively; called again if a load needs double.
    settings: the table [solver] of a scene. duality: as in Certifier. of_result: as in
    StoppingCriterion. table: the table [load], whose first load may need double from the beginning.
    `working`, `starter`: the surface and the starts in the present precision. `coarser`: the
    contacts on coarser grids that the last load started from, finest first; empty if it started
    otherwise.
    """

    def __init__(
        self,
        make_surface: MakeSurface,
        settings: SolverTable,
        model: ContactModel,
        duality: bool = False,
        of_result: float | None = None,
        table: LoadTable | None = None,
    ):
        if settings.low_memory and settings.name not in ("auto", "bpx"):
            raise SceneError('solver.low_memory: found true, allowed: with solver.name = "bpx"')
        self.make_surface = make_surface
        self.settings = settings
        self.model = model
        self.criterion = StoppingCriterion(
            settings.accuracy, settings.residual, settings.max_iterations, of_result
        )
        self.duality = duality
        self._preparation = Preparation()
        self._failed = False  # whether the load before has no solution
        self._separated_at: Load | None = None  # the load before, if the bodies came apart at it
        self.coarser: Sequence[CoarseContact] = ()
        # of the last load with a nested start
        self._gap_discretisation: float | None = None
        self._work_in(first_precision(settings, model, table))

    def _work_in(self, precision: Precision) -> None:
        """Make the surface and the starter in a precision. Collective."""
        kind = LowMemorySurface if self.settings.low_memory else WorkingSurface
        self.working = kind(self.make_surface, self.model, self.settings, precision)
        self.starter = Starter(self.working, self.criterion, self.duality)

    @property
    def surface(self) -> Surface:
        """The surface in the present precision."""
        return self.working.surface

    @property
    def dtype(self) -> np.dtype:
        """The present precision; once a load needs double precision, all later ones use it."""
        return self.working.dtype

    def loads(self, table: LoadTable) -> list[Load]:
        """Return the loads of a scene's [load], without searches, as `loads_of`. Collective."""
        loads = loads_of(table, self.working, self.starter.solver_class)
        if self.model.branch != CYCLE:
            return loads
        pairs = pairwise(loads)
        return [loads[0], *(replace(load, parts=load.is_beyond(before)) for before, load in pairs)]

    def solve(
        self, load: Load, watch: Watch | None = None, unfinished: Unfinished | None = None
    ) -> Contact:
        """Solve one load, in single precision first if that may be enough. Collective.

        The solver stays at the solution, from which the next load may start and whose arrays it
        overwrites; the surface may be made again in double precision.

        Parameters
        ----------
        load : Load
            As `loads` returns it; it is not changed.
        watch : callable, optional
            watch(iterations, progress) before every iteration; a true value ends the load with the
            status "interrupted".
        unfinished : Unfinished, optional
            State of this load from an interrupted run.

        Raises
        ------
        Stopped
            On all ranks, if a signal asks for it during another contact that this load requires.
        SceneError
            If the heights of the surface's file have changed since.
        """
        if self._failed and not self.model.always_continues:
            self.starter.forget()
        if self._stays_separated(load):
            return self._separated(load)
        beginning = self._preparation.of(load, self, unfinished)
        self.coarser = ()
        contact = self._attempt(load, beginning, watch, unfinished)
        if contact is None:
            self._go_on_in_double()
            contact = self._attempt(load, beginning, watch, unfinished)
        assert contact is not None  # double precision always gives one
        self._failed = contact.status not in ("converged", "interrupted", "separated")
        self._separated_at = load if contact.is_separated else None
        if contact.status == "converged":
            self._preparation.remember(contact)
        if self.model.unique:
            return self._with_other_branch(contact)
        return contact

    # -- one load in one precision

    def _go_on_in_double(self) -> None:
        """Make the surface again in double, to start at the solver's gap; SceneError if heights
        changed. Collective.
        """
        checksum = self.surface.checksum
        gap = self.starter.gap_in(DOUBLE)
        self.working.release()
        del self.working, self.starter  # their memory is needed for the next ones
        self._work_in(DOUBLE)
        self.starter.kept = gap
        if checksum not in (None, self.surface.checksum):
            raise SceneError("surface.path: the heights have changed since this run read them")

    def _attempt(
        self, load: Load, beginning: Beginning, watch: Watch | None, unfinished: Unfinished | None
    ) -> Contact | None:
        """Solve a load in this precision, and add to the pairs of its beginning; return its
        contact, None if it needs double. Collective. Without a contact the starter's solver holds
        the gap that was reached.
        """
        working = self.working
        starter = self.starter
        target = beginning.target
        gap = beginning.gap
        target.learn_heights(working)
        continues = gap is None and starter.continues(target)
        is_fresh = gap is None and not continues and starter.kept is None
        if needs_double(working, target, gap):
            if is_fresh:
                starter.forget()
            return None
        if target.p0 < 0 and is_fresh:
            return self._separated(load, pairs=beginning.pairs)
        start = starter.continued(target) if continues else starter.start(target, gap)
        self.coarser = start.coarser or self.coarser
        solver = start.solver
        if unfinished is not None:
            solver.iterations = unfinished.iterations
        beginning.pairs += start.pairs
        if needs_double(working, target):  # as the coarser grids have found
            beginning.pairs += solver.pairs
            return None
        attracts = self.model.attraction is not None
        guard = SaddleGuard(solver, self.model.branch_of(load)) if attracts else None
        outcome = drive(
            solver, self.criterion, watch, target, guard, start.certificate, start.certifier
        )
        beginning.pairs += solver.pairs + outcome.pairs
        if outcome.status == "separated":
            return self._separated(load, target.note, solver.iterations, beginning.pairs)
        # converged at a load that single precision cannot find
        is_undecided = outcome.status == "converged" and target.needs_double
        contact = working.contact(
            load.value if load.is_pressure else solver.state.p0 * working.pressure_unit,
            solver.state,
            "stagnated" if is_undecided else outcome.status,
            outcome.certificate,
            remark=target.note,
            iterations=solver.iterations,
            pairs=beginning.pairs,
        )
        if needs_double(working, target, solved=(contact, solver.problem_now)):
            if contact.status == "nonfinite":
                starter.forget()
            return None
        if unfinished is not None:
            self.coarser = unfinished.coarser
            self._gap_discretisation = unfinished.gap_discretisation
        return self._with_grid_error(contact, load.quantity == "gap_mean")

    def _with_grid_error(self, contact: Contact, holds_gap: bool) -> Contact:
        """Return a contact with the error of its gap by the grid, or that of the load before."""
        if self.coarser:
            self._gap_discretisation = gap_discretisation(contact, self.coarser, holds_gap)
        return replace(contact, gap_discretisation=self._gap_discretisation)

    def _stays_separated(self, load: Load) -> bool:
        """Return whether bodies that have come apart stay so at a mean gap or approach."""
        if load.is_pressure or not self.model.always_continues or self._separated_at is None:
            return False
        if load.quantity == "approach":
            touches = load.value > 0
        else:
            touches = load.value < self.working.heights.top * self.working.surface.slope
        return load.is_beyond(self._separated_at) or not touches

    def _separated(
        self, load: Load, remark: str | None = None, iterations: int = 0, pairs: float = 0.0
    ) -> Contact:
        """Return the contact of bodies that have come apart, and drop the solver."""
        self.starter.forget()
        p_mean = load.value if load.is_pressure else 0.0
        return separated_contact(self.working, p_mean, remark, iterations, pairs)

    # -- other contacts, for Preparation and `unique`

    def closed(self) -> Contact:
        """Solve full contact at the smallest load, perhaps in double precision from then on."""
        return self.solve(Load("a_r", 1.0), self._raise_if_stopped)

    def flat_punch(self) -> Contact:
        """Solve a flat punch of the surface's size at a mean pressure of 1."""
        surface = self.surface
        self.starter.forget()  # its memory is needed now

        def flat(dtype: np.dtype) -> Surface:
            h = np.zeros(surface.grid.inside, dtype)
            return replace(surface, h=h, h_rms=0.0, g_rms=0.0, checksum=None)

        sweep = Sweep(flat, self.settings, ContactModel(body=self.model.body))
        return sweep.solve(Load("pressure", 1.0), self._raise_if_stopped)

    def without_attraction(self, load: Load) -> Contact:
        """Solve a load without attraction, in the present precision."""
        sweep = self._on_same_surface(self.model.without_attraction)
        return sweep.solve(load, self._raise_if_stopped)

    def _with_other_branch(self, contact: Contact) -> Contact:
        """Return the contact with `other_branch`: retraction starts from closed surfaces; both
        pairs count. Collective.
        """
        sweep = self._on_same_surface(self.model.on_other_branch)
        start = None
        if sweep.model.always_continues:
            start = Unfinished(np.zeros_like(contact.g), contact.p_mean, iterations=0, pairs=0.0)
        other = sweep.solve(Load("pressure", contact.p_mean), self._raise_if_stopped, start)
        return replace(
            contact, other_branch=compared(contact, other), pairs=contact.pairs + other.pairs
        )

    def _on_same_surface(self, model: ContactModel) -> Sweep:
        """Return a new sweep of another model on this surface, in the present precision only."""
        precision = "double" if self.dtype == DOUBLE else "single"
        settings = self.settings.model_copy(update={"precision": precision})
        return Sweep(lambda dtype: self.surface, settings, model)

    def _raise_if_stopped(self, *_: object) -> None:
        """Raise Stopped on all ranks if a signal asks the run to stop; takes what `watch` takes."""
        interrupt.check(self.surface.grid.comm)
