"""What the wall allows and bears: it is rigid, dents at a hardness, or attracts. Equations (1) to
(3) in docs/method.md.

Solvers and certificates ask a Wall for its projection, for rigid moves of the body, which cost no
elastic energy, and for the pressure p^ of the duality gap; they do not ask which wall it is.
`limit` and `law` go to the compiled passes, which clip each step to what the wall allows and add
its attraction.
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

# A step is made shorter only below this: clipped points stay a little open then. Measured: alike
# from .9 to .95, 6 to 7 % more pairs at .8 and at 1
SHORT = 0.9
SETTLED = 1e-3  # distance to where a spring holds separated bodies at rest, in ranges of the law


class Wall:
    """A rigid wall: g >= 0, p >= 0, p g = 0. Base of the others.

    `limit`: the largest pressure, and `law`: the attraction, both in the working precision or None;
    `yields`: whether points may yield, so that steps are clipped more than once; `hardness`: the
    work of a dent over its depth. Methods that take local slabs are collective.
    """

    yields = False
    hardness = 0.0

    def __init__(self, problem: Problem):
        self.problem = problem
        self.grid = problem.grid
        self.limit = problem.limit
        self.law = problem.law()

    def project(self, g: np.ndarray) -> float:
        """Set the gap to 0 where it is below; return the largest penetration before."""
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

    def add_traction(self, g: np.ndarray, p: np.ndarray) -> float | None:
        """Add the attraction to the pressure of the body, which becomes that of the wall; return
        its sum, None if there is none."""
        return None

    def step_length(self, pd: float, dKd: float, td: float, gained: float) -> float:
        """Return the length <= 1 of least energy of a step of length 1.

        pd, td: work of the pressure and of the attraction on the step; gained: what the attraction
        gains.
        """
        optimum = -pd / dKd if dKd > 0 else 1.0
        return optimum if 0 < optimum < SHORT else 1.0

    def lower(self, g: np.ndarray, p: np.ndarray, wall_load: float) -> tuple[float, float | None]:
        """Lower a body that touches nowhere until its first point touches, which would take many
        steps; return by how much, and the new sum of the attraction if that has changed p."""
        by = self._lowest(g)
        g -= self.problem.dtype.type(by)
        return by, None

    def _lowest(self, g: np.ndarray) -> float:
        """Return the smallest gap on the surface; 0 if that is below 0, or if a spring holds the
        body."""
        rows, points = self.grid.inside
        (lowest,) = self.grid.comm.min([g[:rows, :points].min(initial=inf)])
        return float(lowest) if 0 < lowest < inf and self.problem.spring == 0 else 0.0

    def has_let_go(self, wall_load: float) -> bool:
        """Return whether bodies that do not touch have come apart for good."""
        return False

    def dent(self, p0: float, p_cell: float, g: np.ndarray, p: np.ndarray, uKu: float) -> bool:
        """Replace a state by a rigid body that dents the wall, if that has less energy."""
        return False

    def balance(
        self, p0: float, g: np.ndarray, contact: float, yielded: float, descent: float
    ) -> bool:
        """Shift the gap by a constant if too few points touch, or too many yield, to carry the load
        p0, and if this lowers the energy by more than `descent`; return whether it has."""
        return False

    def admissible(
        self, load: float, closed_p: float, contact: float, yielded: float
    ) -> tuple[float, float]:
        """Return (scale, shift) such that p^ = scale p + shift in elastic contact is admissible,
        scale -1 if none is.

        p^ is then between 0 and the largest pressure and carries `load`, of which the points in
        contact carry `closed_p` with p.
        """
        return (load / closed_p if closed_p > 0 else -1.0), 0.0


class HardWall(Wall):
    """A wall with a hardness H: 0 <= p <= H, with a dent, g < 0, only where p = H.

    The energy is piecewise linear in the height of the body; its minimum is where the n-th smallest
    gap becomes 0, n being the load over H, rounded up.
    """

    yields = True

    def __init__(self, problem: Problem):
        super().__init__(problem)
        self.hardness = float(problem.hardness or inf)

    def project(self, g: np.ndarray) -> float:
        return 0.0  # every displacement is feasible

    def points_to_carry(self, p0: float) -> int:
        """Return how many points with the pressure H carry a load: load/H, rounded up."""
        N = self.grid.N
        return min(max(int(np.ceil(N * p0 / self.hardness)), 1), N)

    def dent(self, p0: float, p_cell: float, g: np.ndarray, p: np.ndarray, uKu: float) -> bool:
        """Replace a state by a rigid body that dents the wall, if that has less energy.

        States that come from a coarser grid or a clipped plane, without a hardness, have pressures
        far beyond it; a rigid body has a uniform one, the load. p0 is over the surface, p_cell over
        the grid, uKu of the state. Returns False without stored heights.
        """
        h = self.problem.stored
        if h is None:
            return False
        grid = self.grid
        rows, points = grid.inside
        level = nth_smallest(grid, lambda i0, i1: h[i0:i1], self.points_to_carry(p0))

        def sums(i0: int, i1: int) -> tuple[float, float, float]:
            inner = max(min(i1, rows) - i0, 0)
            heights = h[i0 : i0 + inner]
            dents, _ = depths_below(g[i0 : i0 + inner], (inner, points), 0.0)
            _, rigid_dents = depths_below(heights, (inner, points), level)
            return g[i0:i1].sum(dtype=float) - heights.sum(dtype=float), dents, rigid_dents

        u, dents, rigid_dents = grid.comm.sum(added(grid.by_rows(sums), 3)).tolist()
        energy = 0.5 * uKu + p_cell * u + self.hardness * dents
        rigid_energy = -grid.N * p0 * float(level) + self.hardness * rigid_dents
        if not rigid_energy < energy:
            return False

        def lay(i0: int, i1: int) -> None:
            inner = max(min(i1, rows) - i0, 0)
            g[i0:i1] = -level
            g[i0 : i0 + inner, :points] += h[i0 : i0 + inner]
            p[i0:i1] = p_cell

        grid.by_rows(lay)
        return True

    def balance(
        self, p0: float, g: np.ndarray, contact: float, yielded: float, descent: float
    ) -> bool:
        grid = self.grid
        if self.hardness * yielded <= grid.N * p0 <= self.hardness * contact:
            return False
        shift = nth_smallest(grid, lambda i0, i1: g[i0:i1], self.points_to_carry(p0))
        rows, points = grid.inside

        def depths(i0: int, i1: int) -> tuple[float, float]:
            return depths_below(g[i0:i1], (i1 - i0, points), shift)

        before, after = grid.comm.sum(added(grid.by_rows(depths, rows), 2)).tolist()
        gain = grid.N * p0 * float(shift) - self.hardness * (after - before)
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

    def add_traction(self, g: np.ndarray, p: np.ndarray) -> float | None:
        def add(i0: int, i1: int) -> tuple[float, float]:
            return add_attraction(self.law, g, p[i0:i1], i0, i1, self.grid.inside)

        t, _ = self.grid.comm.sum(added(self.grid.by_rows(add), 2)).tolist()
        return float(t)

    def step_length(self, pd: float, dKd: float, td: float, gained: float) -> float:
        """The frozen energy is a majorant: the whole step is made if the energy itself, which is
        known, is lower there than the majorant at its minimum."""
        length = super().step_length(pd, dKd, td, gained)
        whole = pd + 0.5 * dKd + gained - td
        return 1.0 if length < 1 and whole <= 0.5 * pd * length else length

    def lower(self, g: np.ndarray, p: np.ndarray, wall_load: float) -> tuple[float, float | None]:
        """Nothing if the load pulls the body off the wall."""
        lowest = self._lowest(g) if wall_load > 0 else 0.0
        if lowest == 0:
            return 0.0, None
        by = self.problem.dtype.type(lowest)

        def shift(i0: int, i1: int) -> float:
            return shift_gap(self.law, g, p, by, i0, i1, self.grid.inside)

        return lowest, float(self.grid.comm.sum([sum(self.grid.by_rows(shift))])[0])

    def has_let_go(self, wall_load: float) -> bool:
        """The load pulls at least as hard as the attraction, and a spring is nearly at rest."""
        assert self.law is not None
        left = self.problem.spring * float(self.law.range) * SETTLED  # until nothing holds it back
        return wall_load <= 0 and (left == 0 or -wall_load < left)


def wall_of(problem: Problem) -> Wall:
    """Return the wall of a problem. A hardness together with an attraction is refused by scenes."""
    if problem.attraction is not None:
        return AdhesiveWall(problem)
    return Wall(problem) if problem.hardness is None else HardWall(problem)
