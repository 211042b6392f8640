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
from .area import AreaSearch
from .closing import Closing, closing_pressure, flat_solution
from .curve import Curve
from .drive import LoopState, drive
from .nested import Nested, cold_gap
from .opening import Opening, nearly_closes
from .precision import NOISE, counting, few_points, first_precision, too_little
from .prescribed import Prescribed, prescribed
from .search import Search
from .searches import numbers_of, restored
from .wall import Wall

if TYPE_CHECKING:
    from ..bodies.base import Body
    from ..parallel.grid import Grid
    from ..scene import Load
    from ..scene import Solver as Settings
    from ..surface import Surface
    from .drive import Watch

    MakeSurface = Callable[[np.dtype], Surface]
    Slabs = Callable[[Grid], dict[str, Any]]  # local slabs of a stored state by name

WARM_UP, WARM_DOWN = (
    1.45,
    1.26,
)  # a load up to so much larger or smaller starts from the one before, others from coarser grids
# (not round numbers, nor the next one: p* has rounding errors)
SAME_LOAD = (
    1e-9  # relative: g_rms, and p* with it, has other rounding errors on other numbers of ranks
)
FLAT_HAS_NONE = ("p_star", "gap_mean", "gap_over_h_rms", "a_r")
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
    solver: Any  # a solvers.base.Solver; None before the first load, and while its memory is needed
    nested: Nested | None

    def __init__(
        self,
        make_surface: MakeSurface,
        settings: Settings,
        E_star: float = 1.0,
        lam_s: float | None = None,
        duality: bool = False,
        body: Body = HALF_SPACE,
    ):
        self.make_surface, self.settings = make_surface, settings
        self.E_star, self.lam_s, self.body = float(E_star), lam_s, body
        self.solver_class = solver_class(settings.name)
        self.target = Target(
            settings.accuracy, settings.residual, settings.max_iterations, duality=duality
        )
        self._search: Search | Closing | None = None
        self._punch: np.ndarray | None = None  # see _flat_solution
        self._curve, self._failed = Curve(), False
        self._set_precision(first_precision(settings))

    def pressures(self, load: Load) -> Sequence[float | Prescribed]:
        """What `solve` takes for the loads of scene.Load on this surface: mean pressures, or
        Prescribed where they have to be found.

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
        if self.settings.precision == "single" and g_rms > 0:
            for p_mean in pressures:
                if not single_solves(p_mean / (self.E_star * g_rms), self.surface.grid.N):
                    raise SceneError(
                        'solver.precision: found "single", too little for a pressure of'
                        f' {p_mean:g}, allowed: "auto", "double"'
                    )
        best = (
            self.dtype
            if self.settings.precision == "single" or self.settings.low_memory
            else np.float64
        )
        resolution = LENGTHS * float(np.finfo(best).eps) / self.settings.tolerance
        return pressures or prescribed(name, values, self.surface, self._wall, resolution)

    def solve(
        self, load: float | Prescribed, watch: Watch | None = None, midway: bool = False
    ) -> Contact:
        """The contact at a load: a mean pressure (unit of E_star), or Prescribed.

        watch(iterations, progress) is called after every iteration, a true value stops. midway: go
        on where `restore` went back to.
        """
        if self._is_flat:
            assert not isinstance(load, Prescribed)  # refused by `pressures`
            return self._flat(load)
        if midway and isinstance(load, Prescribed) and self._search is None:
            load = self.solver.p0 * self.E_star * self.surface.slope
        if not midway:
            self._forget_failure()
            self._spent, self._search = 0.0, None
            if (
                isinstance(load, Prescribed)
                and load.closes
                and (self.closes or self.solver_class.holds_tension)
            ):
                self._search = Closing(self.settings.tolerance, self._flat_solution())
                load = self._closing_pressure() if self.closes else load
            elif (
                isinstance(load, Prescribed)
                and nearly_closes(load, self.surface, self.body)
                and self.solver_class.holds_tension
            ):
                closed = self.solve(
                    Prescribed("a_r", 1.0), lambda *_: interrupt.check(self.surface.grid.comm)
                )
                self._spent = closed.pairs
                self._search = Opening.of(load, closed, self._wall)
            elif isinstance(load, Prescribed):
                self._search = self._curve.search(
                    load, self.surface, self._wall, self.settings.tolerance
                )
        promote = self.settings.precision == "auto" and self.dtype == np.float32
        if promote and not midway and self._too_little(self._p_star(load)):
            self._set_precision(np.float64)
            promote = False
        contact = self._solve(load, watch, midway, promote)
        if promote and (contact is None or _needs_double(contact)):
            self._spent = self._spent if contact is None else contact.fft_pairs
            contact = None  # its fields make room
            self._set_precision(np.float64)
            contact = self._solve(load, watch, False)
        assert contact is not None  # without `promote` there is one
        self._failed = contact.status not in ("converged", "interrupted")
        return contact

    def _forget_failure(self) -> None:
        """After a load that failed the next one starts afresh."""
        if self._failed:
            self.solver, self._curve, self._failed = None, Curve(), False

    def _too_little(self, p_star: float) -> bool:
        """Whether single precision is too little for a load."""
        N = self.surface.grid.N
        for_area = self._search.target / 2 if isinstance(self._search, AreaSearch) else p_star
        return too_little(self.settings, N, for_area)

    def state(
        self, upcoming: float | Prescribed | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """What `restore` needs to go on in the present load or, given the load that is upcoming, at
        its beginning: local slabs by name, and numbers."""
        if upcoming is not None:
            self._forget_failure()
        arrays: dict[str, Any] = {}
        numbers: dict[str, Any] = {
            "dtype": self.dtype.name,
            "heights": self.surface.checksum,
            "curve": vars(self._curve),
        }
        if upcoming is None or self._may_start_here(upcoming):
            arrays, own = self.solver.state()
            numbers |= {"p0": self.solver.p0, "own": own}
        if upcoming is None:
            numbers |= {
                "loop": asdict(self.loop),
                "spent": self._spent,
                "pairs": self.solver.pairs - self._first_pairs,
                "search": self._search and numbers_of(self._search),
            }
        return arrays, numbers

    def restore(self, arrays: Slabs, numbers: dict[str, Any], load: float | Prescribed) -> None:
        """Go back to a `state`, perhaps of another number of ranks; load: what is asked for at that
        load, as `solve` has it.

        Collective. arrays: function of the grid, gives local slabs. Raises SceneError for the state
        of another load or version.
        """
        self._spent = 0.0
        if numbers["dtype"] != self.dtype:
            self._set_precision(numbers["dtype"])
        try:
            self._curve = Curve(**numbers["curve"])
            found = numbers.get("search")
            closes = found and found["kind"] == Closing.kind
            self._search = (
                Closing(self.settings.tolerance, self._flat_solution())
                if closes
                else found and restored(found)
            )
        except (KeyError, TypeError):
            raise SceneError(OTHER_VERSION) from None
        if "p0" in numbers:
            self._spent = numbers.get("spent", 0.0)
            p0 = numbers["p0"]
            if "loop" in numbers and not isinstance(
                load, Prescribed
            ):  # in the middle of this load, not at its beginning
                p0 = self._p_star(load)
                if not abs(p0 / numbers["p0"] - 1) < SAME_LOAD:
                    raise SceneError(
                        f"a state at p* = {numbers['p0']:g}, allowed: at {p0:g}, the load that is"
                        " asked for"
                    )
            self._begin(self._problem(p0), arrays, numbers)

    def _problem(self, p_star: float) -> Problem:
        return Problem(self.surface.grid, self.surface.h, p_star, body=self.body)

    def _may_start_here(self, load: float | Prescribed) -> bool:
        """Whether a load, or one that follows it if it closes the gap at once, may start from the
        present state."""
        if self.solver is None or isinstance(load, Prescribed):
            return self.solver is not None
        p_star = self._p_star(load)
        return self._near(p_star) or p_star >= self.body.full_p_star

    def _p_star(self, load: float | Prescribed) -> float:
        if not isinstance(load, Prescribed):
            return load / (self.E_star * self.surface.slope)
        assert self._search is not None
        return self._search.p0

    def _solve(
        self, load: float | Prescribed, watch: Watch | None, midway: bool, promote: bool = False
    ) -> Contact | None:
        """promote: give None back where the search on coarser grids finds that single precision is
        too little."""
        if not midway:
            problem = self._problem(self._p_star(load))
            if not isinstance(load, Prescribed):
                full, pairs = self._full_contact(problem)
                self._spent += pairs
                if full is not None:
                    return self._contact(load, *full, pairs=self._spent)
            self._begin(problem)
            if promote and isinstance(self._search, Search) and self._too_little(self._search.p0):
                return None
        solver = self.solver
        status, certificate, pairs = drive(solver, self.target, watch, self.loop, self._search)
        pairs = self._spent + (solver.pairs - self._first_pairs) + pairs
        p_mean = (
            solver.p0 * self.E_star * self.surface.slope if isinstance(load, Prescribed) else load
        )
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
        remark = self._search.note if self._search is not None else None
        contact = Contact(
            self.surface,
            self.E_star,
            p_mean,
            g,
            p,
            status,
            certificate,
            self.settings.tolerance,
            self.lam_s,
            self.body,
            remark,
            iterations,
            float(pairs),
        )
        self._curve.add(np.log(p_mean / (self.E_star * self.surface.slope)), contact, self._search)
        return contact

    def _begin(
        self, problem: Problem, arrays: Slabs | None = None, numbers: dict[str, Any] | None = None
    ) -> None:
        """Make or reuse the solver and give it a start: a state, the load before, coarser grids, or
        a flat plane."""
        warm = arrays is None and self._goes_on_at(problem.p0)
        g = None
        if arrays is None and not warm:
            g = self._starting_gap(problem, self.solver.g if self.solver is not None else None)
            if isinstance(self._search, Search):
                problem = replace(problem, p0=self._search.on_next_grid(self._wall))
        if self.solver is None:
            self.solver = self._make(problem, g)
        self._reset_counts()
        if warm:
            self.solver.continue_at(problem.p0)
        self.solver.p0 = problem.p0
        self._choose_certificate()
        if arrays is not None:
            self._load_state(arrays, numbers or {})
        elif warm:
            return
        elif self.target.certificate_dtype != self.dtype and self.solver.takes_gap:
            # Rounding errors of the first pressure would stay to the end: only its changes are
            # added to it.
            if g is not self.solver.g:
                self.solver.g[...] = g
            fresh = certify(problem, self.solver.g, self.solver.p)
            self._spent += fresh.pairs
            self.solver.refresh(fresh.uKu)
        else:
            self.solver.start(g)

    def _choose_certificate(self) -> None:
        """Its precision, and that of the first pressure: double where rounding errors would
        count."""
        double = self._rounding_counts(self.solver.problem_now)
        dtype = np.float64 if double else self.dtype.type
        self.target = replace(
            self.target, certificate_dtype=dtype, closes=isinstance(self._search, Closing)
        )

    def _rounding_counts(self, problem: Problem) -> bool:
        """Whether rounding errors of the pressure may, which the certificate cannot tell from
        pressure out of contact: those of single points where few of them touch, or few do not."""
        few = (
            few_points(problem.grid.N, problem.p0, self.target.accuracy)
            or problem.p0 >= HALF_SPACE.full_p_star
        )
        return few or self._noise(problem) > NOISE * counting(self.target, problem.p0)

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
        if isinstance(self._search, Closing | Opening):
            g = self.surface.grid.empty(self.dtype) if into is None else into
            g[...] = 0
            return g
        if self.nested is None:
            if self._search is not None:
                self._search.on_coarsest_grid()
            return cold_gap(problem)
        g, pairs = self.nested.start(problem, self._make, into, self._search)
        self._spent += pairs
        return g

    def _make(self, problem: Problem, g: np.ndarray | None = None) -> Any:
        """A solver; g: memory for its gap, which it may take over."""
        taken = {"g": g} if g is not None and self.solver_class.takes_gap else {}
        return self.solver_class(problem, self.settings.options, **taken)

    def _goes_on_at(self, p_star: float) -> bool:
        """Whether a load starts from the present state."""
        return (
            self.solver is not None and not isinstance(self._search, Closing) and self._near(p_star)
        )

    def _near(self, p_star: float) -> bool:
        ratio = p_star / self.solver.p0
        return 1 / WARM_DOWN < ratio < WARM_UP

    @property
    def closes(self) -> bool:
        """Whether the least pressure that closes the gap is known at once."""
        return not self.surface.grid.padded

    def _closing_pressure(self) -> float:
        """The least mean pressure (unit of E_star) at which u = -h is the solution."""
        p0, pairs = closing_pressure(self._problem(1.0))
        self._spent += pairs
        return p0 * self.E_star * self.surface.slope

    def _flat_solution(self) -> np.ndarray | None:
        """What a Closing needs, solved for once: None where the surface does not end.
        Collective."""
        if self.surface.grid.padded and self._punch is None:
            self.solver = None  # its memory is needed now
            self._punch, pairs = flat_solution(self)
            self._spent += pairs
        return self._punch

    def _full_contact(
        self, problem: Problem
    ) -> tuple[tuple[np.ndarray, np.ndarray, str, Certificate] | None, float]:
        """Whether u = -h is the solution, which needs no iteration; (g, p, status, certificate) or
        None, and the pairs spent on finding out."""
        pairs = 0.0
        if not isinstance(self._search, Closing):
            if problem.p0 < self.body.full_p_star:
                return None, 0.0
            likely, pairs = (True, 0.0) if self.nested is None else self.nested.may_be_full(problem)
            if not likely:
                return None, pairs
        g, p = np.zeros_like(problem.h), np.empty_like(problem.h)
        certificate = certify(problem, g, p, dual=self.target.duality)
        pairs += certificate.pairs
        if certificate.contact < problem.grid.N:
            return None, pairs
        exact = replace(certificate, errors=(0.0, 0.0, full_contact_error(problem)))
        return (g, p, "converged", exact), pairs

    def _set_precision(self, dtype: DTypeLike) -> None:
        """Make the surface in this precision and plan all transforms that its contacts need."""
        self.dtype = dtype = np.dtype(dtype)
        self.solver = self.nested = None
        before = self.__dict__.pop("surface", None)
        known = before and before.checksum
        del before  # with its transforms
        self.surface = self.make_surface(dtype)
        if known not in (None, self.surface.checksum):
            raise SceneError("surface.path: the heights have changed since this run read them")
        self.__dict__.pop("_wall", None)
        if not self._is_flat:
            grid = self.surface.grid
            grid.fft(dtype)
            grid.fft(np.float64)  # of the certificate
            wanted = self.settings.nested
            nests = self.solver_class.nests if wanted == "auto" else wanted
            self.nested = Nested(grid, dtype, self.settings.accuracy) if nests else None

    @cached_property
    def _wall(self) -> Wall:
        """Where a load has to be found. Collective where it is first asked for."""
        surface = self.surface if self.surface.h is not None else self.make_surface(self.dtype)
        return Wall.of(surface.grid, surface.gap)

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
