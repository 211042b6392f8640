"""Solve the loads on one surface, one after another.

A load gets its target, a start (starter.py) and the iterations (drive.py), and becomes a Contact.
Single precision is tried first if the accuracy allows it; where it fails, double precision goes on
from its gap, also for all later loads. Some loads need another contact before their own: the full
one, that of a flat punch, or the one without attraction.
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
from .full_contact import Closing, Pressure
from .grid_errors import grid_errors
from .held import Held
from .load import Load, Unfinished
from .low_memory import LowMemorySurface
from .precision import DOUBLE, first_precision, needs_double
from .quantities import NEARLY_CLOSED, ROOTS, Opening, opening_load
from .scene_loads import loads_of
from .starter import Starter
from .target import Target
from .without_iterations import contact_of, flat_contact, separated_contact
from .working_surface import WorkingSurface

if TYPE_CHECKING:
    from ..contact.contact import Contact, GridErrors
    from ..scene import LoadTable, SolverTable
    from ..surface import Precision, Surface
    from .drive import Watch
    from .grid_errors import CoarseContact
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
        self._history: list[dict[str, float]] = []  # of the last two loads, see _remember
        self._failed = False  # whether the load before has no solution
        self._separated_at: Load | None = None  # the load before, if the bodies came apart at it
        self._punch: np.ndarray | None = None  # see _flat_solution
        self.coarser: Sequence[CoarseContact] = ()
        self._of_grid: GridErrors | None = None  # of the last load with a nested start
        self._work_in(first_precision(settings, model, table))

    def _work_in(self, precision: Precision, gap: np.ndarray | None = None) -> None:
        """Make the surface and the starter in a precision; gap: where the next load starts.
        Collective.
        """
        kind = LowMemorySurface if self.settings.low_memory else WorkingSurface
        self.working = kind(self.make_surface, self.model, self.settings, precision)
        self.starter = Starter(self.working, self.criterion, self.duality, gap)

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
        if self.working.is_flat:
            return flat_contact(self.working, load.value)
        if self._failed and not self.model.always_continues:
            self.starter.forget()
        if self._stays_separated(load):
            return self._separated(load)
        target, gap, pairs = self._prepared(load, unfinished)
        if unfinished is not None:
            gap = unfinished.gap
            pairs += unfinished.pairs
            target.begin_at(unfinished.p_mean / self.working.pressure_unit)
        self.coarser = ()
        contact, pairs = self._attempt(load, target, watch, unfinished, gap, pairs)
        if contact is None:
            self._go_on_in_double()
            contact, pairs = self._attempt(load, target, watch, unfinished, gap, pairs)
        assert contact is not None  # double precision always gives one
        self._failed = contact.status not in ("converged", "interrupted", "separated")
        self._separated_at = load if contact.is_separated else None
        if contact.status == "converged":
            self._remember(contact)
        if self.model.unique:
            return self._with_other_branch(contact)
        return contact

    # -- from a load to its target

    def _prepared(
        self, load: Load, unfinished: Unfinished | None
    ) -> tuple[Target, np.ndarray | None, float]:
        """Return the target of a load, the gap to start from if it has to be that, and the FFT
        pairs of other contacts that had to be solved for these. Collective.
        """
        model = self.model
        working = self.working
        if load.is_pressure:
            kind = Target if model.attraction is not None else Pressure
            return kind(load.value / working.pressure_unit), None, 0.0
        if model.attraction is not None:
            return self._held(load, unfinished)
        if load.closes:
            return self._closing()
        is_area = load.quantity == "a_r"
        value = load.value if is_area else load.value / working.surface.slope
        if load.quantity == "gap_mean" and model.hardness is None:
            opens = opening_load(load.value, working)
            if opens < NEARLY_CLOSED:
                closed = self.solve(Load("a_r", 1.0), self._raise_if_stopped)
                closes_at = closed.p_mean / closed.pressure_unit
                # which may have gone on in double precision: another working surface
                return Opening(value, self.working, opens, closes_at), None, closed.pairs
        return ROOTS[load.quantity](value, working, self._history), None, 0.0

    def _closing(self) -> tuple[Target, None, float]:
        """Return the target of full contact; with free edges a flat punch is solved first."""
        if not self.surface.grid.padded:
            return Closing(self.settings.tolerance), None, 0.0
        unit, pairs = self._flat_solution()
        return Closing(self.settings.tolerance, unit), None, pairs

    def _held(self, load: Load, unfinished: Unfinished | None) -> tuple[Target, np.ndarray, float]:
        """Return the `Held` of a gap or approach with attraction, the gap to start from (that of
        `unfinished`, of the load before, or without attraction, solved here), and FFT pairs.
        Collective.
        """
        working, solver = self.working, self.starter.solver
        pairs = 0.0
        if unfinished is not None:
            gap, p0 = unfinished.gap, unfinished.p_mean / working.pressure_unit
        elif self.model.always_continues and solver is not None:
            gap, p0 = solver.state.g.copy(), solver.state.p0
        else:
            bare = self._on_same_surface(self.model.without_attraction)
            start = bare.solve(load, self._raise_if_stopped)
            gap, p0, pairs = start.g, start.p_mean / working.pressure_unit, start.pairs
        target = Held(
            load.quantity,
            load.value / working.surface.height_unit,
            self.settings.tolerance,
            p0,
            working.problem(p0),
            gap_at_touch=working.heights.top / working.surface.grid.a,
            gap_at_start=gap,
        )
        return target, gap, pairs

    def _remember(self, contact: Contact) -> None:
        """Store load, area, gap and approach of a solution, from which later targets begin."""
        a = self.surface.grid.a
        solved = {
            "p0": contact.p_mean / self.working.pressure_unit,
            "a_r": contact.contact_points / contact.N,
            "gap_mean": contact.certificate.gap_mean * a,
            "approach": contact.certificate.approach * a,
        }
        self._history = [*self._history[-1:], solved]

    def _go_on_in_double(self) -> None:
        """Make the surface again in double, to start at the solver's gap; SceneError if heights
        changed. Collective.
        """
        checksum = self.surface.checksum
        gap = self.starter.gap_in(DOUBLE)
        self.working.release()
        del self.working, self.starter  # their memory is needed for the next ones
        self._work_in(DOUBLE, gap)
        if checksum not in (None, self.surface.checksum):
            raise SceneError("surface.path: the heights have changed since this run read them")

    # -- one load in one precision

    def _attempt(
        self,
        load: Load,
        target: Target,
        watch: Watch | None,
        unfinished: Unfinished | None,
        gap: np.ndarray | None,
        pairs: float,
    ) -> tuple[Contact | None, float]:
        """Solve a load in this precision; return its contact, None if it needs double, and all
        FFT pairs. Collective. gap: where to start, or None; pairs: those taken before. Without a
        contact the starter's solver holds the gap that was reached.
        """
        working = self.working
        starter = self.starter
        target.learn_heights(working)
        continues = gap is None and starter.continues(target)
        is_fresh = gap is None and not continues and starter.kept is None
        if needs_double(working, target, gap):
            if is_fresh:
                starter.forget()
            return None, pairs
        if target.p0 < 0 and is_fresh:
            return self._separated(load, pairs=pairs), pairs
        start = starter.continued(target) if continues else starter.start(target, gap)
        self.coarser = start.coarser or self.coarser
        solver = start.solver
        if unfinished is not None:
            solver.iterations = unfinished.iterations
        pairs += start.pairs
        if needs_double(working, target):  # as the coarser grids have found
            return None, pairs + solver.pairs
        attracts = self.model.attraction is not None
        guard = SaddleGuard(solver, self.model.branch_of(load)) if attracts else None
        outcome = drive(
            solver, self.criterion, watch, target, guard, start.certificate, start.certifier
        )
        pairs += solver.pairs + outcome.pairs
        if outcome.status == "separated":
            return self._separated(load, target.note, solver.iterations, pairs), pairs
        # converged at a load that single precision cannot find
        is_undecided = outcome.status == "converged" and target.needs_double
        contact = contact_of(
            working,
            load.value if load.is_pressure else solver.state.p0 * working.pressure_unit,
            solver.state,
            "stagnated" if is_undecided else outcome.status,
            outcome.certificate,
            remark=target.note,
            iterations=solver.iterations,
            pairs=pairs,
        )
        if needs_double(working, target, solved=(contact, solver.problem_now)):
            if contact.status == "nonfinite":
                starter.forget()
            return None, pairs
        if unfinished is not None:
            self.coarser, self._of_grid = unfinished.coarser, unfinished.of_grid
        return self._with_grid_errors(contact), pairs

    def _with_grid_errors(self, contact: Contact) -> Contact:
        """Return a contact with errors by the grid, its own or those of the load before."""
        if self.coarser:
            self._of_grid = grid_errors(contact, self.coarser)
        return replace(contact, of_grid=self._of_grid)

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

    # -- other contacts on the same surface

    def _on_same_surface(self, model: ContactModel) -> Sweep:
        """Return a new sweep of another model on this surface, in the present precision only."""
        precision = "double" if self.dtype == DOUBLE else "single"
        settings = self.settings.model_copy(update={"precision": precision})
        return Sweep(lambda dtype: self.surface, settings, model)

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

    def _flat_solution(self) -> tuple[np.ndarray, float]:
        """Solve a flat punch, once; return pressure on and displacement beyond the surface, and FFT
        pairs. Collective.
        """
        if self._punch is not None:
            return self._punch, 0.0
        surface = self.surface
        rows, points = surface.grid.inside
        self.starter.forget()  # its memory is needed now

        def flat(dtype: np.dtype) -> Surface:
            h = np.zeros((rows, points), dtype)
            return replace(surface, h=h, h_rms=0.0, g_rms=0.0, checksum=None)

        sweep = Sweep(flat, self.settings, ContactModel(body=self.model.body))
        contact = sweep.solve(Load("pressure", 1.0), self._raise_if_stopped)
        self._punch = contact.g
        self._punch[:rows, :points] = contact.p[:rows, :points]
        return self._punch, contact.pairs

    def _raise_if_stopped(self, *_: object) -> None:
        """Raise Stopped on all ranks if a signal asks the run to stop; takes what `watch` takes."""
        interrupt.check(self.surface.grid.comm)
