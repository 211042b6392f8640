"""With an attraction a load may have several equilibria: where it starts, and how to leave saddles;
equations (2) to (4) in docs/method.md.

Approach comes down from larger gaps: the contact without attraction, or a smaller load before.
Retraction comes up from the larger load before. In a cycle each load comes from the one before, on
the branch of its direction.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..certificate.stability import LEAST, stability_of, stability_up_to_equilibrium
from ..contact.contact import OtherBranch
from ..kernels.adhesive_rows import gain_along

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..contact.contact import Contact
    from ..solvers.base import Solver

APPROACH, RETRACTION, CYCLE = "approach", "retraction", "cycle"
SOLVED = "converged", "separated"  # a status that says which equilibrium there is
ENOUGH = 1.1  # a stability is accurate enough above this factor times what the errors require
KICKS = 12  # largest number of kicks away from saddles for one load
# lengths of a kick that are tried: its largest change of the gap, in ranges of the attraction
KICK_LENGTHS = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0)


def goes_on(branch: str, p0: float, p0_before: float) -> bool:
    """Return whether a load may start from the one before: on retraction if it does not rise, on
    approach if it does not fall and that one was above 0, in a cycle always.
    """
    if branch == CYCLE:
        return True
    if branch == RETRACTION:
        return p0 <= p0_before
    return 0 < p0_before <= p0


class SaddleGuard:
    """Computes the stability of a solver's state, and kicks it away from saddles, first in the
    direction of `branch`. `kicks` counts them.
    """

    def __init__(self, solver: Solver, branch: str):
        self.solver = solver
        self.branch = branch
        self.kicks = 0
        self._mode: np.ndarray | None = None  # of the last search, with which the next one begins

    @property
    def at_saddle(self) -> bool:
        """Whether there is no equilibrium near the state, as far as its stability is known."""
        stability = self.solver.state.stability
        return stability is not None and stability.lowest <= 0

    def confirm(self, certificate: Certificate) -> tuple[Certificate | None, float]:
        """Return an accepted certificate, None at a saddle that a spring holds, which a search with
        an early end may miss, and the FFT pairs of an exact one. Collective.
        """
        if self.solver.problem.spring == 0:
            return certificate, 0.0
        pairs = self.look()
        stability = self.solver.state.stability
        assert stability is not None  # just computed
        if self.at_saddle:
            return None, pairs
        return replace(certificate, stability=stability.value), pairs

    def look(self, measure: float = np.inf) -> float:
        """Compute the stability, until it is clear whether it exceeds `measure` (inf: exactly, 0:
        no errors requested), and prepare the next step; return the FFT pairs. Collective.
        """
        solver = self.solver
        state = solver.state
        state.stability = None
        estimate = solver.progress().estimate
        distance = estimate.distance if estimate is not None and measure > 0 else 0.0
        stability = stability_of(
            solver.problem_now,
            state.g,
            state.p,
            solver.levels,
            ENOUGH * measure,
            measure if 0 < measure < np.inf else -LEAST,
            self._mode,
        )
        self._mode = stability.mode
        lowest = stability_up_to_equilibrium(solver.problem_now, state.g, stability, distance)
        state.stability = replace(stability, lowest=lowest)
        solver.after_stability()
        return stability.pairs

    def leave_saddle(self) -> bool:
        """Kick the solver along the mode in which the energy falls, after `look`; changes gap, and
        p0 with a spring. Collective, one FFT pair. False if stable, if no kick lowers the energy,
        or after twelve.
        """
        solver = self.solver
        state = solver.state
        mode = self._mode
        is_stable = state.stability is not None and state.stability.value > 0
        if self.kicks >= KICKS or mode is None or is_stable:
            return False
        length = self._length_of_kick(mode)
        if length == 0:
            return False
        rows, points = solver.grid.inside
        step = solver.problem.dtype.type(length)
        g = state.g
        before = _mean_of_cell(solver)

        def kick(i0: int, i1: int) -> None:
            g[i0:i1] += step * mode[i0:i1]
            inner = max(min(i1, rows) - i0, 0)
            on_surface = g[i0 : i0 + inner, :points]
            np.maximum(on_surface, 0, out=on_surface)

        solver.grid.by_rows(kick)
        state.stability = None
        moved = _mean_of_cell(solver) - before
        state.p0 += solver.problem.spring * moved * (solver.grid.cell_points / solver.N)
        solver.start(g)
        self.kicks += 1
        return True

    def _length_of_kick(self, mode: np.ndarray) -> float:
        """Return the step along the mode e, <e, K e> = 1, that lowers the energy most, or 0;
        retraction tries opening (> 0) first, approach closing. Collective.
        """
        work, largest = self._work_along(mode)
        law = self.solver.problem.attraction
        assert law is not None  # without an attraction there are no saddles
        unit = float(law.range) / largest
        side = 1.0 if self.branch == RETRACTION else -1.0
        for sign in (side, -side):
            lengths = [sign * unit * share for share in KICK_LENGTHS]
            changes = [
                length * work + 0.5 * length**2 + self._gain_along(mode, length)
                for length in lengths
            ]
            least = int(np.argmin(changes))
            if changes[least] < 0:
                return lengths[least]
        return 0.0

    def _work_along(self, mode: np.ndarray) -> tuple[float, float]:
        """Return <w, e>, w the body's pressure, e the mode, and the largest |e|. Collective."""
        solver = self.solver
        state = solver.state
        grid, law = solver.grid, solver.problem.attraction
        assert law is not None
        rows, points = grid.inside
        work, largest = [0.0], [0.0]

        def add(i0: int, i1: int) -> None:
            here = slice(i0, max(min(i1, rows), i0)), slice(0, points)
            e = mode[here].astype(np.float64)
            t = law.traction(state.g[here].astype(np.float64))
            of_wall = np.vdot(state.p[i0:i1].astype(np.float64), mode[i0:i1])
            work.append(float(of_wall - np.vdot(t, e)))
            largest.append(float(np.abs(e).max(initial=0.0)))

        grid.by_rows(add)
        (total,) = grid.comm.sum([sum(work)])
        (most,) = grid.comm.max([max(largest)])
        return float(total), float(most)

    def _gain_along(self, mode: np.ndarray, length: float) -> float:
        """Return the change of the energy of attraction by a step along a mode. Collective."""
        solver, law = self.solver, self.solver.problem.law()
        step, inside = solver.problem.dtype.type(length), solver.grid.inside

        def gain(i0: int, i1: int) -> float:
            return float(gain_along(law, solver.state.g, mode, step, i0, i1, inside))

        (total,) = solver.grid.comm.sum([sum(solver.grid.by_rows(gain))])
        return float(total)


def _mean_of_cell(solver: Solver) -> float:
    grid = solver.grid
    parts = grid.by_rows(lambda i0, i1: float(solver.state.g[i0:i1].sum(dtype=np.float64)))
    return float(grid.comm.sum([sum(parts)])[0]) / grid.cell_points


def compared(contact: Contact, other: Contact) -> OtherBranch | None:
    """Return what `other`, of the same load and grid on the other branch, gives. Collective.

    Both agree if contact points, mean gap and pressure field differ by no more than the sum of
    their estimated errors (plus one point), or if both are separated. None if one of them is
    neither converged nor separated.
    """
    if contact.status not in SOLVED or other.status not in SOLVED:
        return None
    a_r = other.contact_points / other.N
    if contact.is_separated or other.is_separated:
        return OtherBranch(a_r, contact.status == other.status)
    area, gap, pressure = np.add(contact.certificate.errors, other.certificate.errors)
    points = abs(contact.contact_points - other.contact_points)
    gaps = abs(contact.gap_mean - other.gap_mean)
    agrees = (
        points <= area * contact.contact_points + 1
        and gaps <= gap * contact.gap_mean
        and _difference_of_pressures(contact, other) <= pressure
    )
    return OtherBranch(a_r, bool(agrees))


def _difference_of_pressures(contact: Contact, other: Contact) -> float:
    """Return the relative L2 norm of the difference of two pressure fields. Collective."""

    def squares(i0: int, i1: int) -> tuple[float, float]:
        """Return the sums of (p - q)^2 and p^2 over some local rows."""
        p, q = (one.pressure_rows(i0, i1).astype(np.float64) for one in (contact, other))
        return float(((p - q) ** 2).sum()), float((p**2).sum())

    grid = contact.grid
    parts = [(0.0, 0.0), *grid.by_rows(squares, grid.inside[0])]
    difference, whole = grid.comm.sum(np.sum(parts, axis=0)).tolist()
    return float(np.sqrt(difference / whole)) if whole > 0 else np.inf
