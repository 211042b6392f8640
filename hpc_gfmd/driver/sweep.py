"""One load after another on one surface: which precision, which start, and what comes out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..certificate.certificate import Certificate
from ..certificate.error_estimates import full_contact_error
from ..contact.contact import Contact
from ..parallel import interrupt
from ..util.errors import SceneError
from .drive import drive
from .full_contact import CLOSED, FullContact, closed_contact, tension_of
from .load import GivenLoad
from .load_quantities import OpeningSearch, restored, search_for
from .load_search import x_of
from .load_target import LoadTarget, loads_of
from .precision import too_little
from .start import OTHER_VERSION, Start

if TYPE_CHECKING:
    from ..scene import Load
    from ..surface import Surface
    from .drive import Watch
    from .start import Slabs

# relative: g_rms, and p* with it, has other rounding errors on other numbers of ranks
SAME_LOAD = 1e-9
NEARLY = 0.2  # of E* g_rms: full contact takes 0.3 to 20


def _needs_double(contact: Contact) -> bool:
    """Tell whether single precision turned out to be too little for a load."""
    return contact.status in ("stagnated", "nonfinite") or contact.gap_is_rounding


class Sweep(Start):
    """Solves loads on one surface in the order given. Its arguments: see Start."""

    closed_form = True  # whether the solution of full contact is at hand

    _failed = False
    _punch: np.ndarray | None = None  # see _flat_solution
    _history: Sequence[dict[str, float]] = ()  # what the last two loads gave

    def pressures(self, load: Load) -> Sequence[float | LoadTarget]:
        """Return what `solve` takes for the loads of scene.Load on this surface: mean pressures, or
        LoadTarget where they have to be found.

        Raises SceneError for what a flat surface does not have, what the precision cannot hold, and
        what no pressure gives.
        """
        return loads_of(load, self)

    def solve(
        self, load: float | LoadTarget, watch: Watch | None = None, midway: bool = False
    ) -> Contact:
        """Solve the contact at a load: a mean pressure (unit of E_star), or LoadTarget.

        watch(iterations, progress) is called after every iteration, a true value stops. midway: go
        on where `restore` went back to.
        """
        if self.is_flat:
            assert not isinstance(load, LoadTarget)  # refused by `pressures`
            return self._flat(load)
        if not midway:
            self._forget_failure()
            self._spent = 0.0
            self._load = self._load_for(load)
        promote = self.settings.precision == "auto" and self.dtype == np.float32
        if promote and not midway and self._too_little():
            self._set_precision(np.float64)
            promote = False
        contact = self._solve(watch, midway, promote)
        if promote and (contact is None or _needs_double(contact)):
            self._spent = self._spent if contact is None else contact.fft_pairs
            contact = None  # its fields make room
            self._set_precision(np.float64)
            contact = self._solve(watch, False)
        assert contact is not None  # without `promote` there is one
        self._failed = contact.status not in ("converged", "interrupted")
        return contact

    def _forget_failure(self) -> None:
        """Forget the state of a load that failed: the next one starts afresh."""
        if self._failed:
            self.solver, self._failed = None, False

    def _load_for(self, load: float | LoadTarget) -> GivenLoad:
        """Make what finds the load."""
        if not isinstance(load, LoadTarget):
            return GivenLoad(self._p_star(load), load)
        tolerance, heights = self.settings.tolerance, self.heights
        if load.quantity == "a_r" and load.value == 1:
            if self.closed_form and not self.surface.grid.padded:
                return GivenLoad(1.0, closes=True)
            if self.solver_class.holds_tension:
                return FullContact(tolerance, self._flat_solution())
        known = (tolerance, self.settings.accuracy is not None, heights)
        if load.quantity == "gap_mean" and self.solver_class.holds_tension and not self.hardness:
            single = load.value / self.surface.height_unit * self.surface.grid.N
            opens = single * float(self.body.near(self.surface.grid)[0])  # a single point so far
            if opens < NEARLY:
                closed = self.solve(
                    LoadTarget("a_r", 1.0), lambda *_: interrupt.check(self.surface.grid.comm)
                )
                self._spent = closed.pairs
                closes_at = closed.p_mean / closed.pressure_unit
                target = load.value / self.surface.slope
                return OpeningSearch.below(closes_at, opens, target, known)
        return search_for(load, self.surface, known, self._history, self._limit)

    def _too_little(self) -> bool:
        """Tell whether single precision is too little for the load."""
        return too_little(self.settings, self.surface.grid.N, self._load.half_area)

    def state(
        self, upcoming: float | LoadTarget | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return what `restore` needs to go on in the present load or, given the load that is
        upcoming, at its beginning: local slabs by name, and numbers."""
        if upcoming is not None:
            self._forget_failure()
        arrays: dict[str, Any] = {}
        numbers: dict[str, Any] = {"dtype": self.dtype.name, "history": self._history}
        if upcoming is None or self._may_start_here(upcoming):
            arrays, own = self.solver.state()
            numbers |= {"p0": self.solver.p0, "own": own}
        if upcoming is None:
            numbers |= {
                "loop": asdict(self.loop),
                "spent": self._spent,
                "pairs": self.solver.pairs - self._first_pairs,
                "search": self._load.numbers(),
            }
        return arrays, numbers

    def restore(self, arrays: Slabs, numbers: dict[str, Any], load: float | LoadTarget) -> None:
        """Go back to a `state`, perhaps of another number of ranks; load: what is asked for at that
        load, as `solve` has it.

        Collective. arrays: function of the grid, gives local slabs. Raises SceneError for the state
        of another load or version.
        """
        self._spent = 0.0
        if numbers["dtype"] != self.dtype:
            self._set_precision(numbers["dtype"])
        try:
            self._history = list(numbers["history"])
            found = numbers.get("search")
            if found and found["kind"] == "full contact":
                self._load = FullContact(self.settings.tolerance, self._flat_solution())
            else:
                # of what has to be found only the load that closes the gap is known at once
                known = GivenLoad(numbers.get("p0", 1.0), closes=isinstance(load, LoadTarget))
                self._load = restored(found) if found else known
        except (KeyError, TypeError):
            raise SceneError(OTHER_VERSION) from None
        if "p0" in numbers:
            self._spent = numbers.get("spent", 0.0)
            p0 = numbers["p0"]
            if "loop" in numbers and not isinstance(load, LoadTarget):
                # in the middle of this load, not at its beginning
                p0 = self._p_star(load)
                if not abs(p0 / numbers["p0"] - 1) < SAME_LOAD:
                    raise SceneError(
                        f"a state at p* = {numbers['p0']:g}, allowed: at {p0:g}, the load that is"
                        " asked for"
                    )
                self._load = GivenLoad(p0, load)
            self._go_back(p0, arrays, numbers)

    def _may_start_here(self, load: float | LoadTarget) -> bool:
        """Tell whether a load, or one that follows it if it closes the gap at once, may start from
        the present state."""
        if self.solver is None or isinstance(load, LoadTarget):
            return self.solver is not None
        p_star = self._p_star(load)
        return self._near(p_star) or p_star >= self.body.full_p_star

    def _solve(self, watch: Watch | None, midway: bool, promote: bool = False) -> Contact | None:
        """Solve the present load; promote: return None where the search on coarser grids finds that
        single precision is too little."""
        if not midway:
            full = self._full_contact(self._load.p0)
            if full is not None:
                return full
            self._begin(self._load.p0)
            if promote and self._too_little():
                return None
        solver = self.solver
        status, certificate, pairs = drive(solver, self.target, watch, self.loop, self._load)
        pairs = self._spent + (solver.pairs - self._first_pairs) + pairs
        found = solver.g, solver.p, status, certificate, solver.iterations, pairs
        return self._contact(self._p_mean(solver.p0), *found)

    def _p_mean(self, p0: float) -> float:
        """Return the mean pressure in the scene's unit: as it was given, where it was, without
        rounding errors of the unit."""
        return self._load.p_mean or p0 * (self.E_star * self.surface.slope)

    def _contact(
        self,
        p_mean: float,
        g: np.ndarray,
        p: np.ndarray,
        status: str,
        certificate: Certificate,
        iterations: int = 0,
        pairs: float = 0.0,
    ) -> Contact:
        of_all = self.settings.tolerance, self.lam_s, self.body, self._load.note
        done = status, certificate, *of_all, iterations, float(pairs), self.hardness
        contact = Contact(self.surface, self.E_star, p_mean, g, p, *done)
        if status == "converged":
            known = {
                "x": x_of(self._p_star(p_mean), self._limit),
                "a_r": contact.contact_points / contact.N,
                "gap_mean": certificate.gap_mean * self.surface.grid.a,
                "approach": certificate.approach * self.surface.grid.a,
            }
            self._history = [*self._history[-1:], known]
        return contact

    def _flat_solution(self) -> np.ndarray | None:
        """Solve once for what FullContact needs of a surface that ends; None of one that does not.
        Collective."""
        surface, (rows, points) = self.surface, self.surface.grid.inside
        if surface.grid.padded and self._punch is None:
            self.solver = None  # its memory is needed now

            def flat(dtype: np.dtype) -> Surface:
                h = np.zeros((rows, points), dtype)
                return replace(surface, h=h, h_rms=0.0, g_rms=0.0, checksum=None)

            step = type(self)(flat, self.settings, body=self.body).solve(
                1.0, lambda *_: interrupt.check(surface.grid.comm)
            )
            self._punch = step.g
            self._punch[:rows, :points] = step.p[:rows, :points]
            self._spent += step.pairs
        return self._punch

    def _full_contact(self, p0: float) -> Contact | None:
        """Return the contact where u = -h is the solution, which needs no iteration; None where it
        is not."""
        if not (self.closed_form and self._load.given):
            return None
        problem = self._problem(p0)
        if not self._load.closes:
            if p0 < self.body.full_p_star:
                return None
            likely, pairs = (True, 0.0) if self.nested is None else self.nested.may_be_full(problem)
            self._spent += pairs
            if not likely:
                return None
        g, p, certificate = closed_contact(problem, dual=self.target.duality)
        self._spent += certificate.pairs
        tension, rounding = tension_of(problem.grid, p)
        nearly = problem.dtype == np.float64 and 0 <= tension <= CLOSED * problem.rounding
        if nearly or self._load.closes:
            problem = self._problem(p0 + tension + rounding)
            g, p, certificate = closed_contact(problem, dual=self.target.duality)
            self._spent += certificate.pairs
        if self._load.closes:
            self._load = GivenLoad(problem.p0, closes=True)
        if certificate.contact - certificate.yielded < problem.grid.N:
            return None
        exact = replace(certificate, errors=(0.0, 0.0, full_contact_error(problem)))
        return self._contact(self._p_mean(problem.p0), g, p, "converged", exact, pairs=self._spent)

    def _flat(self, p_mean: float) -> Contact:
        """Give full contact, which a flat wall has at any load: there is nothing to compute."""
        g = np.zeros_like(self.surface.h)
        certificate = Certificate(
            contact=self.surface.grid.N, errors=(0.0, 0.0, 0.0), duality_gap=0.0
        )
        return self._contact(
            p_mean, g, np.full_like(g, p_mean / self.E_star), "converged", certificate
        )
