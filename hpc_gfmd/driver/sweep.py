"""One load after another on one surface: which precision, which start, and what comes out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import DTypeLike

from ..bodies.halfspace import HALF_SPACE
from ..certificate.certificate import Certificate, certify
from ..certificate.criterion import Target
from ..certificate.error_estimates import full_contact_error
from ..contact.contact import Contact
from ..operators.problem import Problem
from ..parallel import interrupt
from ..solvers import solver_class
from ..surface.units import require_range, single_solves
from ..util.errors import SceneError
from .drive import LoopState, certificate_of, drive
from .full_contact import CLOSED, FullContact
from .load import GivenLoad, HeightStatistics
from .load_quantities import OpeningSearch, restored, search_for
from .load_search import x_of
from .load_target import LoadTarget, load_targets, require_dents
from .nested import Nested, cold_gap
from .precision import CALIBRATION, counting, few_points, first_precision, too_little

if TYPE_CHECKING:
    from ..bodies.base import Body
    from ..parallel.grid import Grid
    from ..scene import Load
    from ..scene import Solver as Settings
    from ..surface import Surface
    from .drive import Watch

    MakeSurface = Callable[[np.dtype], Surface]
    Slabs = Callable[[Grid], dict[str, Any]]  # local slabs of a stored state by name

# a load up to so much larger or smaller starts from the one before, others from coarser grids
WARM_UP, WARM_DOWN = 1.45, 1.26
# (not round numbers, nor the next one: p* has rounding errors)
# relative: g_rms, and p* with it, has other rounding errors on other numbers of ranks
SAME_LOAD = 1e-9
FLAT_HAS_NONE = ("p_star", "gap_mean", "gap_over_h_rms", "a_r")
NEARLY = 0.2  # of E* g_rms: full contact takes 0.3 to 20
LENGTHS = 100.0  # rounding errors of the largest height that a gap or an approach may have
OTHER_VERSION = "a state of another version of hpc_gfmd, allowed: of this one"


def _needs_double(contact: Contact) -> bool:
    """Whether single precision turned out to be too little for a load."""
    return contact.status in ("stagnated", "nonfinite") or contact.gap_is_rounding


class Sweep:
    """Solves loads on one surface in the order given.

    make_surface(dtype) -> surface.Surface; settings: scene.Solver. duality: whether the duality gap
    is wanted; body: see bodies/. Raises SceneError for what cannot be asked.
    """

    surface: Surface
    dtype: np.dtype  # the working precision
    solver: Any  # a solvers.base.Solver; None before the first load, and while its memory is needed
    nested: Nested | None
    closed_form = True  # whether the solution of full contact is at hand

    def __init__(
        self,
        make_surface: MakeSurface,
        settings: Settings,
        E_star: float = 1.0,
        lam_s: float | None = None,
        duality: bool = False,
        body: Body = HALF_SPACE,
        hardness: float | None = None,
    ):
        self.make_surface, self.settings = make_surface, settings
        self.E_star, self.lam_s, self.body, self.hardness = float(E_star), lam_s, body, hardness
        self.solver_class = solver_class(settings.name)
        self.target = Target(
            settings.accuracy, settings.residual, settings.max_iterations, duality=duality
        )
        self._load = GivenLoad(1.0)
        self._failed = False
        self._punch: np.ndarray | None = None  # see _flat_solution
        self._history: list[dict[str, float]] = []  # what the last two loads gave
        self._set_precision(first_precision(settings))

    def pressures(self, load: Load) -> Sequence[float | LoadTarget]:
        """What `solve` takes for the loads of scene.Load on this surface: mean pressures, or
        LoadTarget where they have to be found.

        Raises SceneError for what a flat surface does not have, what the precision cannot hold, and
        what no pressure gives.
        """
        name, values = load.given
        flat, g_rms = self.surface.g_rms == 0, self.surface.g_rms
        if flat and (name in FLAT_HAS_NONE or (name == "approach" and self._is_flat)):
            raise SceneError(
                f"load.{name}: found a flat surface (g_rms = 0), allowed: load.pressure"
            )
        pressures = load.p0(self.E_star, g_rms, float(np.prod(self.surface.sizes)))
        require_range(self.E_star, self.surface, pressures)
        if self.hardness is not None:
            require_dents(self.solver_class, self.hardness, name, values, pressures)
        if self.settings.precision == "single" and g_rms > 0:
            for p_mean in pressures:
                if not single_solves(p_mean / (self.E_star * g_rms), self.surface.grid.N):
                    raise SceneError(
                        'solver.precision: found "single", too little for a pressure of'
                        f' {p_mean:g}, allowed: "auto", "double"'
                    )
        if pressures:
            return pressures
        best = (
            self.dtype
            if self.settings.precision == "single" or self.settings.low_memory
            else np.float64
        )
        resolution = LENGTHS * float(np.finfo(best).eps) / self.settings.tolerance
        top = 0.0 if name == "a_r" else self._heights.top * self.surface.slope
        return load_targets(name, values, self.surface, top, resolution)

    def solve(
        self, load: float | LoadTarget, watch: Watch | None = None, midway: bool = False
    ) -> Contact:
        """The contact at a load: a mean pressure (unit of E_star), or LoadTarget.

        watch(iterations, progress) is called after every iteration, a true value stops. midway: go
        on where `restore` went back to.
        """
        if self._is_flat:
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
        # what is given comes back as it was, without rounding errors of the unit
        return contact if isinstance(load, LoadTarget) else replace(contact, p_mean=load)

    def _forget_failure(self) -> None:
        """After a load that failed the next one starts afresh."""
        if self._failed:
            self.solver, self._failed = None, False

    def _load_for(self, load: float | LoadTarget) -> GivenLoad:
        """What finds the load."""
        if not isinstance(load, LoadTarget):
            return GivenLoad(self._p_star(load), load)
        tolerance, heights = self.settings.tolerance, self._heights
        if load.quantity == "a_r" and load.value == 1:
            if self.closed_form and not self.surface.grid.padded:
                return GivenLoad(self._closing_pressure(), closes=True)
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
        """Whether single precision is too little for the load."""
        return too_little(self.settings, self.surface.grid.N, self._load.half_area)

    def state(
        self, upcoming: float | LoadTarget | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """What `restore` needs to go on in the present load or, given the load that is upcoming, at
        its beginning: local slabs by name, and numbers."""
        if upcoming is not None:
            self._forget_failure()
        arrays: dict[str, Any] = {}
        numbers: dict[str, Any] = {
            "dtype": self.dtype.name,
            "heights": self.surface.checksum,
            "history": self._history,
        }
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
                self._load = restored(found) if found else GivenLoad(numbers.get("p0", 1.0))
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
            self._begin(p0, arrays, numbers)

    def _problem(self, p_star: float) -> Problem:
        return Problem(self.surface.grid, self.surface.gap, p_star, None, self.body, self._limit)

    @property
    def _limit(self) -> float | None:
        """The hardness in the program's unit."""
        return None if self.hardness is None else self._p_star(self.hardness)

    def _may_start_here(self, load: float | LoadTarget) -> bool:
        """Whether a load, or one that follows it if it closes the gap at once, may start from the
        present state."""
        if self.solver is None or isinstance(load, LoadTarget):
            return self.solver is not None
        p_star = self._p_star(load)
        return self._near(p_star) or p_star >= self.body.full_p_star

    def _p_star(self, load: float) -> float:
        return load / (self.E_star * self.surface.slope)

    def _solve(self, watch: Watch | None, midway: bool, promote: bool = False) -> Contact | None:
        """promote: give None back where the search on coarser grids finds that single precision is
        too little."""
        unit = self.E_star * self.surface.slope
        if not midway:
            full, pairs = self._full_contact(self._load.p0)
            self._spent += pairs
            if full is not None:
                return self._contact(
                    self._load.p_mean or self._load.p0 * unit, *full, pairs=self._spent
                )
            self._begin(self._load.p0)
            if promote and self._too_little():
                return None
        solver = self.solver
        status, certificate, pairs = drive(solver, self.target, watch, self.loop, self._load)
        pairs = self._spent + (solver.pairs - self._first_pairs) + pairs
        p_mean = self._load.p_mean or solver.p0 * unit
        return self._contact(
            p_mean, solver.g, solver.p, status, certificate, solver.iterations, pairs
        )

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
                "x": x_of(p_mean / (self.E_star * self.surface.slope), self._limit),
                "a_r": contact.contact_points / contact.N,
                "gap_mean": certificate.gap_mean * self.surface.grid.a,
                "approach": certificate.approach * self.surface.grid.a,
            }
            self._history = [*self._history[-1:], known]
        return contact

    def _begin(
        self, p0: float, arrays: Slabs | None = None, numbers: dict[str, Any] | None = None
    ) -> None:
        """Make or reuse the solver and give it a start: a state, the load before, coarser grids, or
        a flat plane."""
        if arrays is None and self._goes_on_at(p0):
            self._reset_counts()
            self.solver.continue_at(p0)
            self._choose_certificate()
            return
        problem, g = self._opened(p0)
        if arrays is None:
            g = self._starting_gap(problem, g)
            problem = replace(problem, p0=self._load.on_finest_grid())
        problem = self._kept(problem)
        if self.solver is None:
            self.solver = self._make(problem, g)
        self._reset_counts()
        self.solver.p0 = problem.p0
        self._choose_certificate()
        if arrays is not None:
            self._load_state(arrays, numbers or {})
        elif self.target.certificate_dtype != self.dtype and self.solver.takes_gap:
            # Rounding errors of the first pressure would stay to the end: only its changes are
            # added to it.
            if g is not self.solver.g:
                self.solver.g[...] = g
            fresh = certificate_of(self.solver, replace(self.target, duality=False))
            self._spent += fresh.pairs
            self.solver.refresh(fresh.uKu)
        else:
            self.solver.start(g)

    def _opened(self, p0: float) -> tuple[Problem, np.ndarray | None]:
        """Give the problem with its heights, and memory for the starting gap, if there is any."""
        return self._problem(p0), None if self.solver is None else self.solver.g

    def _kept(self, problem: Problem) -> Problem:
        """Give the problem as it is while the solver iterates."""
        return problem

    def _choose_certificate(self) -> None:
        """Its precision, and that of the first pressure: double where rounding errors would
        count."""
        double = self._rounding_counts(self.solver.problem_now)
        dtype = np.float64 if double else self.dtype.type
        self.target = replace(self.target, certificate_dtype=dtype, closes=self._load.closes)

    def _rounding_counts(self, problem: Problem) -> bool:
        """Whether rounding errors of the pressure may, which the certificate cannot tell from
        pressure out of contact: those of single points where few of them touch, or few do not."""
        few = (
            few_points(problem.grid.N, problem.p0, self.target.accuracy)
            or problem.p0 >= HALF_SPACE.full_p_star
        )
        return few or self._noise(problem) > CALIBRATION.noise * counting(self.target, problem.p0)

    def _noise(self, problem: Problem) -> float:
        return problem.noise(self.surface.h_rms / self.surface.height_unit)

    def _reset_counts(self) -> None:
        """A load begins."""
        self._first_pairs, self.solver.iterations, self.loop = self.solver.pairs, 0, LoopState()

    def _load_state(self, arrays: Slabs, numbers: dict[str, Any]) -> None:
        try:
            self.solver.load_state(arrays(self.surface.grid), numbers["own"])
            self.loop = LoopState(**numbers.get("loop", {}))
        except (KeyError, TypeError):
            raise SceneError(OTHER_VERSION) from None
        self._first_pairs -= numbers.get("pairs", 0.0)

    def _starting_gap(self, problem: Problem, into: np.ndarray | None) -> np.ndarray:
        if self._load.from_full_contact:
            g = self.surface.grid.empty(self.dtype) if into is None else into
            g[...] = 0
            return g
        if self.nested is None:
            return cold_gap(problem)
        g, pairs = self.nested.start(problem, self._make, self._load, into)
        self._spent += pairs
        return g

    def _make(self, problem: Problem, g: np.ndarray | None = None) -> Any:
        """A solver; g: memory for its gap, which it may take over."""
        taken = {"g": g} if g is not None and self.solver_class.takes_gap else {}
        return self.solver_class(problem, self.settings.options, **taken)

    def _goes_on_at(self, p_star: float) -> bool:
        """Whether a load starts from the present state."""
        return self.solver is not None and not self._load.closes and self._near(p_star)

    def _near(self, p_star: float) -> bool:
        ratio = p_star / self.solver.p0
        return 1 / WARM_DOWN < ratio < WARM_UP

    def _closing_pressure(self) -> float:
        """The least load at which u = -h is the solution: the largest tension without any."""
        problem = self._problem(1.0)
        g, p = np.zeros_like(problem.heights), np.empty_like(problem.heights)
        self._spent += certify(problem, g, p).pairs
        tension, largest = problem.grid.comm.max(
            [-float(p.min(initial=np.inf)), float(np.abs(p).max(initial=0))]
        )
        return float(problem.p0 + tension + CLOSED * float(np.finfo(p.dtype).eps) * largest)

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

    def _full_contact(
        self, p0: float
    ) -> tuple[tuple[np.ndarray, np.ndarray, str, Certificate] | None, float]:
        """Whether u = -h is the solution, which needs no iteration; (g, p, status, certificate) or
        None, and the pairs spent on finding out."""
        pairs = 0.0
        if not (self.closed_form and self._load.given):
            return None, 0.0
        problem = self._problem(p0)
        if not self._load.closes:
            if p0 < self.body.full_p_star:
                return None, 0.0
            likely, pairs = (True, 0.0) if self.nested is None else self.nested.may_be_full(problem)
            if not likely:
                return None, pairs
        g, p = np.zeros_like(problem.heights), np.empty_like(problem.heights)
        certificate = certify(problem, g, p, dual=self.target.duality)
        pairs += certificate.pairs
        if certificate.contact - certificate.yielded < problem.grid.N:
            return None, pairs
        exact = replace(certificate, errors=(0.0, 0.0, full_contact_error(problem)))
        return (g, p, "converged", exact), pairs

    def _set_precision(self, dtype: DTypeLike) -> None:
        """Make the surface in this precision and plan all transforms that its contacts need."""
        self.solver = self.nested = None
        before = self.__dict__.pop("surface", None)
        known = before and before.checksum
        if before is not None:
            before.grid.forget_fft(self.dtype)
        del before
        self.dtype = np.dtype(dtype)
        self.surface = self.make_surface(self.dtype)
        if known not in (None, self.surface.checksum):
            raise SceneError("surface.path: the heights have changed since this run read them")
        self.__dict__.pop("_heights", None)
        self._plan()

    def _plan(self) -> None:
        """Plan the transforms, and the grids of a nested start."""
        grid, wanted = self.surface.grid, self.settings.nested
        if not self._is_flat:
            grid.fft(self.dtype)
            grid.fft(np.float64)  # of the certificate
            nests = self.solver_class.nests if wanted == "auto" else wanted
            self.nested = Nested(grid, self.dtype) if nests else None

    @cached_property
    def _heights(self) -> HeightStatistics:
        """Where a load has to be found. Collective where it is first asked for."""
        surface = self.surface if self.surface.h is not None else self.make_surface(self.dtype)
        return HeightStatistics.of(surface.grid, surface.gap)

    @property
    def _is_flat(self) -> bool:
        """Whether all points touch at any load: at its end a flat surface is a punch."""
        return self.surface.g_rms == 0 and not self.surface.grid.padded

    def _flat(self, p_mean: float) -> Contact:
        """A flat wall: full contact at any load, nothing to compute."""
        g = np.zeros_like(self.surface.h)
        certificate = Certificate(
            contact=self.surface.grid.N, errors=(0.0, 0.0, 0.0), duality_gap=0.0
        )
        return self._contact(
            p_mean, g, np.full_like(g, p_mean / self.E_star), "converged", certificate
        )
