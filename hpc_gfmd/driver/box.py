"""Light contacts with free edges are solved in a box: a rectangle with all points that can touch.

An open half-space is the same everywhere, so the contact in the box is one of its own, at the same
force; one application of S gives the gap on the whole surface (certificate/of_pressure.py). If
points beyond the box penetrate, a larger box is solved. A box has the points, ranks and plans of a
coarser grid, but the spacing of the finest.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..certificate.of_pressure import Part
from ..parallel import interrupt
from ..parallel.grid import Grid
from ..parallel.halo import rows_of
from .grid_errors import CoarseContact

if TYPE_CHECKING:
    from ..operators.problem import Problem
    from ..parallel.comm import Comm
    from ..solvers.base import Solver

SPACE = 64  # points beyond free edges, as in surface/cell.py: S is not accurate with fewer
SMALLEST = 2**18  # points of a grid on which a box saves time
MARGIN = 1 / 8  # share of the rectangle that touches which the box has on each side of it, at least


class Rectangle(NamedTuple):
    """Points i0 <= i < i1, j0 <= j < j1 of the surface, at least one."""

    i0: int
    i1: int
    j0: int
    j1: int

    @classmethod
    def of(cls, grid: Grid, chosen: Callable[[int, int], np.ndarray]) -> Rectangle | None:
        """Return the smallest rectangle with all points of a mask, None without any. Collective."""
        nothing = (-np.inf,) * 4

        def ends(i0: int, i1: int) -> tuple[float, ...]:
            mask = chosen(i0, i1)
            columns = np.flatnonzero(mask.any(axis=0))
            if not columns.size:
                return nothing
            rows = grid.rows[0] + i0 + np.flatnonzero(mask.any(axis=1))
            return -rows[0], rows[-1] + 1, -columns[0], columns[-1] + 1

        parts = [nothing, *grid.by_rows(ends, grid.inside[0])]
        i0, i1, j0, j1 = grid.comm.max(np.max(parts, axis=0)).tolist()
        return None if np.isinf(i0) else cls(int(-i0), int(i1), int(-j0), int(j1))

    def times(self, steps: Sequence[int]) -> Rectangle:
        """Return the same rectangle on a grid with so many times the points along each axis."""
        x, y = steps
        return Rectangle(self.i0 * x, self.i1 * x, self.j0 * y, self.j1 * y)

    def joined(self, rectangle: Rectangle | None) -> Rectangle:
        """Return the smallest rectangle that contains both."""
        if rectangle is None:
            return self
        pairs = list(zip(self, rectangle))
        return Rectangle(min(pairs[0]), max(pairs[1]), min(pairs[2]), max(pairs[3]))


@dataclass(frozen=True)
class Box:
    """A rectangle of the surface on which the contact is solved."""

    touching: Rectangle  # the points that may touch, as far as known
    level: int  # number of the coarser grid that has as many points, 1 for the first one
    corner: tuple[int, int]  # its first row and column on the surface
    points: tuple[int, int]  # number of its rows and columns

    @classmethod
    def around(
        cls, touching: Rectangle | None, fine: Grid, coarser: Sequence[Grid], comm: Comm
    ) -> Box | None:
        """Return the smallest box around a rectangle, None if none is faster than the whole
        surface. Collective on `comm`, whose rank 0 has all of `coarser`, finest first.
        """
        box = None
        if touching is not None and fine.cell_points >= SMALLEST:
            for level, grid in enumerate(coarser, 1):
                corner = _place(touching, fine.nominal, grid.nominal)
                is_accurate = all(n - m >= SPACE for n, m in zip(grid.n, grid.nominal))
                if corner is None or not is_accurate:
                    break
                box = cls(touching, level, corner, grid.nominal)
        return comm.bcast(box)


def _place(touching: Rectangle, surface: Sequence[int], box: Sequence[int]) -> tuple | None:
    """Return the first point of a box around a rectangle with its margin, or None."""
    corner = []
    for (begin, end), points, width in zip((touching[:2], touching[2:]), surface, box):
        margin = int(np.ceil(MARGIN * (end - begin))) + 1
        begin = max(begin - margin, 0)
        end = min(end + margin, points)
        if end - begin > width:
            return None
        corner.append(min(max((begin + end - width) // 2, 0), points - width))
    return tuple(corner)


class BoxContact(NamedTuple):
    """The contact in a box."""

    part: Part  # its pressure, on this rank's part of the surface
    pairs: float  # FFT pairs that it took, converted to pairs of the whole grid
    # contacts on coarser grids of the box, with mean gaps over the box
    coarser: Sequence[CoarseContact]

    def coarser_of_surface(
        self, gap_mean: float, of_surface: Sequence[CoarseContact]
    ) -> list[CoarseContact]:
        """Return the contacts on coarser grids with mean gaps over the surface; `gap_mean`: of the
        solution. The first is taken to be halfway to that of `of_surface`.
        """
        gaps = [contact.gap_mean for contact in of_surface]
        gaps = [(gap_mean + gaps[0]) / 2, *gaps]
        return [contact._replace(gap_mean=gap) for contact, gap in zip(self.coarser, gaps)]


SolveAlone = Callable[["Problem"], tuple["Solver", float, Sequence[CoarseContact]]]


def solved_in(box: Box, problem: Problem, coarser: Sequence[Grid], solve: SolveAlone) -> BoxContact:
    """Solve a contact in a box. Collective. solve(problem) returns solver, FFT pairs and contacts
    on coarser grids.
    """
    fine = problem.grid
    i, j = box.corner
    columns = slice(j, j + box.points[1])
    grid = _grid_of(box, fine, coarser)
    owned = np.minimum(fine.starts, fine.nominal[0])
    starts = np.append(0, np.cumsum(fine.comm.allgather(grid.inside[0] if grid else 0)))
    h = np.ascontiguousarray(problem.heights[:, columns])
    h = rows_of(fine.comm, h, owned, i + starts[:-1], i + starts[1:], fine.n[0])
    fields = np.empty((2, 0, box.points[1]), problem.dtype)
    with interrupt.shared(fine.comm, (0.0, ())) as solved:
        if grid is not None:
            share = grid.N / fine.N
            alone = replace(problem, grid=grid, h=h, p0=problem.p0 / share, h_rms=None)
            solver, pairs, contacts = solve(alone)
            rows, points = grid.inside
            fields = np.stack([solver.state.g[:rows, :points], solver.state.p[:rows, :points]])
            pairs *= grid.cell_points / fine.cell_points
            solved.value = pairs, [contact._replace(p0=contact.p0 * share) for contact in contacts]
    pairs, contacts = solved.value
    ends = np.clip(owned - i, 0, box.points[0])
    g, p = rows_of(fine.comm, fields, starts, ends[:-1], ends[1:], starts[-1])
    first_row = max(i - fine.rows[0], 0)
    part = Part(slice(first_row, first_row + len(g)), columns, p, (g <= 0) & (p > 0))
    return BoxContact(part, pairs, contacts)


def _grid_of(box: Box, fine: Grid, coarser: Sequence[Grid]) -> Grid | None:
    """Return the grid of a box, on the ranks of the coarser grid; None on other ranks."""
    if len(coarser) < box.level:
        return None
    coarse = coarser[box.level - 1]
    sizes = [n * spacing for n, spacing in zip(coarse.n, fine.spacings)]
    return Grid.kept(coarse.n, sizes, coarse.comm, coarse.threads, coarse.starts, coarse.nominal)
