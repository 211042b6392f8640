"""What the wall allows and bears: rigid, dents at a hardness, or attracts; equations (1) to (3) in
docs/method.md.

Solvers and certificates ask a Wall, whichever, for its projection, for rigid moves of the body,
which cost no elastic energy, and for p^ of the duality gap. `limit` and `law` go to the compiled
passes, which clip each step and add the attraction.
"""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

import numpy as np

from ..kernels.adhesive_rows import add_attraction, shift_gap
from ..kernels.selection import depths_below
from ..parallel.threads import added
from .selection import nth_smallest

if TYPE_CHECKING:
    from .problem import Problem
    from .state import State

# A step is made shorter only below this: clipped points stay a little open then. Measured: alike
# from .9 to .95, 6 to 7 % more pairs at .8 and at 1
SHORT = 0.9
# Distance to where a spring holds separated bodies at rest, in ranges of the law, below which they
# have come apart for good. Chosen.
SETTLED = 1e-3

# A state with more than so many times the energy of an undeformed body is replaced by the latter.
# Measured: rough strips have up to 400 times and start better so; flat tops and bowls at p* below
# 1e-7 have from 250 times on, and take 2 to 6 times the pairs so; checkerboards with 1e8 stagnate.
WORSE_THAN_UNDEFORMED = 1e3


class Wall:
    """A rigid wall: g >= 0, p >= 0, p g = 0; base of the others, collective with local slabs.

    `limit`: largest pressure, `law`: attraction, both in the working precision or None; `yields`:
    steps are clipped more than once; `hardness`: work of a dent over its depth.
    """

    yields = False
    hardness = 0.0

    def __init__(self, problem: Problem):
        self.problem = problem
        self.grid = problem.grid
        self.limit = problem.limit
        self.law = problem.law()

    def project(self, state: State) -> float:
        """Set the gap to 0 where it is below; return the largest penetration before."""
        g = state.g
        rows, points = self.grid.inside

        def lift(i0: int, i1: int) -> float:
            on_surface = g[i0:i1, :points]
            lowest = float(on_surface.min(initial=0.0))
            if not lowest < 0:
                return 0.0
            np.maximum(on_surface, 0, out=on_surface)
            return -lowest

        (deepest,) = self.grid.comm.max([max(self.grid.by_rows(lift, rows), default=0.0)])
        return float(deepest)

    def add_traction(self, state: State) -> bool:
        """Turn the body's pressure into the wall's; return whether that is another one."""
        return False

    def step_length(self, pd: float, dKd: float, td: float, gained: float) -> float:
        """Return the length <= 1 of least energy; pd, td, gained: of pressure and attraction."""
        optimum = -pd / dKd if dKd > 0 else 1.0
        return optimum if 0 < optimum < SHORT else 1.0

    def lower(self, state: State) -> tuple[float, bool]:
        """Lower a body until it touches; return by how much, and whether the pressure changed."""
        by = self._lowest(state.g)
        state.g -= self.problem.dtype.type(by)
        return by, False

    def _lowest(self, g: np.ndarray) -> float:
        """Return the smallest gap on the surface; 0 if below 0, or if a spring holds the body."""
        rows, points = self.grid.inside
        (lowest,) = self.grid.comm.min([g[:rows, :points].min(initial=inf)])
        return float(lowest) if 0 < lowest < inf and self.problem.spring == 0 else 0.0

    def has_let_go(self, wall_load: float) -> bool:
        """Return whether bodies that do not touch have come apart for good."""
        return False

    def undeform(self, state: State) -> bool:
        """Replace a state by the undeformed body if that has far less energy, as on flat tops at
        light loads, whose edges coarse grids distort. False without stored heights, on padded grids
        and with an attraction.
        """
        h = self.problem.stored
        if h is None or self.grid.padded or self.law is not None:
            return False
        undeformed = state.p_cell * self.grid.N * self.problem.root_mean_square
        if not 0.5 * state.uKu > WORSE_THAN_UNDEFORMED * undeformed:
            return False
        state.g[...] = h
        state.p[...] = state.p_cell
        state.uKu = 0.0
        return True

    def balance(self, state: State, contact: float, yielded: float, descent: float) -> bool:
        """Shift the gap by a constant, if too few touch or too many yield to carry p0 and if that
        gains more than `descent`; return whether.
        """
        return False

    def admissible(
        self, load: float, closed_p: float, contact: float, yielded: float
    ) -> tuple[float, float]:
        """Return (scale, shift) of p^ = scale p + shift, between 0 and `limit` and carrying `load`;
        scale -1 if none. closed_p: sum of p in contact.
        """
        return (load / closed_p if closed_p > 0 else -1.0), 0.0


class HardWall(Wall):
    """A wall with a hardness H: 0 <= p <= H, dents, g < 0, where p = H. A rigid body's energy is
    least where the n-th smallest gap is 0, n being load/H, rounded up.
    """

    yields = True

    def __init__(self, problem: Problem):
        super().__init__(problem)
        self.hardness = float(problem.hardness)

    def project(self, state: State) -> float:
        return 0.0  # every displacement is feasible

    def points_to_carry(self, p0: float) -> int:
        """Return how many points with the pressure H carry a load: load/H, rounded up."""
        N = self.grid.N
        return min(max(int(np.ceil(N * p0 / self.hardness)), 1), N)

    def undeform(self, state: State) -> bool:
        """Replace a state by a rigid body that dents the wall, if of less energy: starts without a
        hardness have pressures far beyond. False without stored heights.
        """
        h = self.problem.stored
        if h is None:
            return False
        grid = self.grid
        g = state.g
        p_cell = state.p_cell
        rows, points = grid.inside
        level = nth_smallest(grid, lambda i0, i1: h[i0:i1], self.points_to_carry(state.p0))

        def sums(i0: int, i1: int) -> tuple[float, float, float]:
            inner = max(min(i1, rows) - i0, 0)
            heights = h[i0 : i0 + inner]
            dents, _ = depths_below(g[i0 : i0 + inner], (inner, points), 0.0)
            _, rigid_dents = depths_below(heights, (inner, points), level)
            return g[i0:i1].sum(dtype=float) - heights.sum(dtype=float), dents, rigid_dents

        u, dents, rigid_dents = grid.comm.sum(added(grid.by_rows(sums), 3)).tolist()
        energy = 0.5 * state.uKu + p_cell * u + self.hardness * dents
        rigid_energy = -grid.N * state.p0 * float(level) + self.hardness * rigid_dents
        if not rigid_energy < energy:
            return False

        def lay(i0: int, i1: int) -> None:
            inner = max(min(i1, rows) - i0, 0)
            g[i0:i1] = -level
            g[i0 : i0 + inner, :points] += h[i0 : i0 + inner]
            state.p[i0:i1] = p_cell

        grid.by_rows(lay)
        state.uKu = 0.0
        return True

    def balance(self, state: State, contact: float, yielded: float, descent: float) -> bool:
        grid = self.grid
        g = state.g
        load = grid.N * state.p0
        if self.hardness * yielded <= load <= self.hardness * contact:
            return False
        shift = nth_smallest(grid, lambda i0, i1: g[i0:i1], self.points_to_carry(state.p0))
        rows, points = grid.inside

        def depths(i0: int, i1: int) -> tuple[float, float]:
            return depths_below(g[i0:i1], (i1 - i0, points), shift)

        before, after = grid.comm.sum(added(grid.by_rows(depths, rows), 2)).tolist()
        gain = load * float(shift) - self.hardness * (after - before)
        if not gain > descent:
            return False

        def lower(i0: int, i1: int) -> None:
            g[i0:i1] -= shift

        grid.by_rows(lower)
        return True

    def admissible(
        self, load: float, closed_p: float, contact: float, yielded: float
    ) -> tuple[float, float]:
        missing = load - closed_p
        elastic = closed_p - self.hardness * yielded
        if missing <= 0:
            return (1 + missing / elastic if elastic > 0 else -1.0), 0.0
        room = self.hardness * (contact - yielded) - elastic
        share = missing / room if room > 0 else inf
        return 1 - share, share * self.hardness


class AdhesiveWall(Wall):
    """A wall that attracts by a law phi(g): its pressure is that of the body plus t = phi'(g)."""

    def add_traction(self, state: State) -> bool:
        def add(i0: int, i1: int) -> tuple[float, float]:
            return add_attraction(self.law, state.g, state.p[i0:i1], i0, i1, self.grid.inside)

        state.attracted, _ = self.grid.comm.sum(added(self.grid.by_rows(add), 2)).tolist()
        return True

    def step_length(self, pd: float, dKd: float, td: float, gained: float) -> float:
        """Return 1 if the known energy there is below the least of its frozen majorant."""
        length = super().step_length(pd, dKd, td, gained)
        whole = pd + 0.5 * dKd + gained - td
        return 1.0 if length < 1 and whole <= 0.5 * pd * length else length

    def lower(self, state: State) -> tuple[float, bool]:
        """Nothing if the load pulls the body off the wall."""
        lowest = self._lowest(state.g) if state.wall_load > 0 else 0.0
        if lowest == 0:
            return 0.0, False
        by = self.problem.dtype.type(lowest)

        def shift(i0: int, i1: int) -> float:
            return shift_gap(self.law, state.g, state.p, by, i0, i1, self.grid.inside)

        state.attracted = float(self.grid.comm.sum([sum(self.grid.by_rows(shift))])[0])
        return lowest, True

    def has_let_go(self, wall_load: float) -> bool:
        """The load pulls at least as hard as the attraction, and a spring is nearly at rest."""
        assert self.law is not None
        left = self.problem.spring * float(self.law.range) * SETTLED  # until nothing holds it back
        return wall_load <= 0 and (left == 0 or -wall_load < left)


def wall_of(problem: Problem) -> Wall:
    """Return the wall of a problem. A hardness together with an attraction is refused by scenes."""
    if problem.attraction is not None:
        return AdhesiveWall(problem)
    return HardWall(problem) if problem.yields else Wall(problem)
