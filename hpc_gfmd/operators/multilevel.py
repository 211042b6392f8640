"""The locally damped multilevel (BPX) preconditioner, distributed over slabs.

    M r = sum over levels of P ... P (weight_l + DAMPING theta_l)^-1 R ... R r

weight_l is the body's stiffness on that level (bodies/base.py), theta_l the local contact fraction:
the restricted indicator of the contact. Damping each level by it is what keeps the spectrum of M K
on the free points narrow at every load, without a parameter to tune.

The finest level is never swept here: the solver's own passes restrict to level 1 (p on F, the
indicator of A, and x) and interpolate from it. Which ranks have which rows of a level is told by
hierarchy.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import DTypeLike

from ..kernels.bfloat16 import stored_dtype
from ..kernels.bpx import UpdateSums, update_passes
from ..kernels.multilevel import restrict_level, smooth_level
from ..parallel.threads import added, on_threads, shares
from ..util.aligned import LINE, zeros_aligned
from .coarsest import DAMPING, CoarsestLevels
from .hierarchy import Hierarchy

if TYPE_CHECKING:
    from ..bodies.base import Body
    from ..parallel.grid import Grid

# <r, S r> of a field of zero mean is at most so many times the compliance of the shortest wave
# times the sum over levels of <r, r>/weight. On all kinds of grids the largest eigenvalue is 2.21;
# of what solvers leave it is 0.5 to 1.6 times, mostly 1.2.
EQUIVALENCE = 1.8


class Multilevel:
    """The sweep for one grid and body in one precision. longest: rows per pass of the solver;
    coarsest_points: see hierarchy.py."""

    def __init__(
        self,
        grid: Grid,
        body: Body,
        dtype: DTypeLike,
        longest: int,
        coarsest_points: int | None = None,
    ):
        self.grid, self.comm, self.inside = grid, grid.comm, grid.inside
        self.dtype: np.dtype = np.dtype(dtype)
        self.damping = np.array([DAMPING], self.dtype)[0]
        known = grid.once(
            (Hierarchy, body, self.dtype, coarsest_points),
            lambda: Hierarchy(grid, body, self.dtype, coarsest_points),
        )
        self.hierarchy, self.steps, self.gap_mode = known, known.steps, known.gap_mode
        self.transfers = [step.transfer for step in self.steps]
        self.distributed = len(self.steps) - 1  # coarse levels that more than one rank may have
        # Level 1 is in the windows of all ranks in any case: that is what the solver's passes write
        # to and read from.
        self.fields = [np.zeros(step.window_shape, self.dtype) for step in self.steps]
        # the rows that this rank owns: in the window where that is the same
        self.owned = [
            field if step.in_place else np.zeros(step.owned_shape, self.dtype)
            for step, field in zip(self.steps[:-1], self.fields)
        ]
        last = slice(len(self.steps), None)
        self.coarsest = (
            CoarsestLevels(known.levels[last], known.weights[last], known.softness[last])
            if self.comm.rank == 0
            else None
        )

        first = self.transfers[0]
        self.ends = np.array(first.passes(longest), np.int64).reshape(-1, 2)
        rows, edges = (6, grid.n[1] + LINE // self.dtype.itemsize), (2, 3, first.m[1])
        # of the solver's passes, of each thread: rows, and what passes share
        self.scratch = [
            (zeros_aligned(rows, self.dtype), np.zeros(edges, self.dtype))
            for _ in range(grid.threads)
        ]

    def update(
        self,
        g: np.ndarray,
        p: np.ndarray,
        d: np.ndarray,
        s: float,
        rows: Sequence[tuple],
        hardness: np.floating | None = None,
        comes: bool = True,
        law: Any = None,
        attracted: np.ndarray | None = None,
    ) -> UpdateSums:
        """Make the solver's update of its state, see kernels/bpx.py: update_passes, and restrict it
        to level 1. rows: of the transforms, of each thread; d: of the slab, or of one pass; law: of
        attraction, as kernels take it; attracted: gets what `add_change` returns of each pass,
        where there is one (kernels/adhesive_rows.py). Returns this rank's UpdateSums."""
        coarse, tables, ends = self.fields[0], self.transfers[0].tables, self.ends
        found = np.zeros((len(ends), len(UpdateSums._fields)))
        if not len(ends):
            return UpdateSums.total(found)
        parts = shares(len(ends), self.grid.threads)
        first = np.empty((len(parts), 3, coarse.shape[2]), self.dtype)
        step = self.dtype.type(s)
        args = g, p, d, step, comes, coarse, tables, hardness, self.inside, law, attracted

        def some(share: int, k0: int, k1: int, thread: int) -> None:
            own = rows[thread], self.scratch[thread], first[share], found
            update_passes(ends, k0, k1, *own, *args)

        pieces = [(share, *part) for share, part in enumerate(parts)]
        on_threads(self.grid.threads, some, pieces, range(self.grid.threads))
        row_of = tables[0]
        coarse[:, : row_of[0] + 1] = 0
        coarse[:, row_of[-1] + 2 :] = 0
        for (k0, _), row in zip(parts, first):
            coarse[:, row_of[ends[k0, 0]]] += row
        return UpdateSums.total(found)

    @property
    def z(self) -> np.ndarray:
        """The result on level 1, own rows and halo, (rows + 2, m)."""
        return self.fields[0][0]

    def sweep(self, anew: bool = False) -> tuple[float, ...]:
        """Make z on level 1 (own rows and halo) from what was restricted to it in the windows of
        all ranks. anew: by an M that has the gap mode of this contact.

        Returns this rank's share of <p, M' p> and <x, M' p>, both on F, as sums over level 1 times
        N/N_1: M' is M without the finest level; of the mean of p on F; and of the sums over these
        levels of softness times <r, r>, <t, t>, <r, t>, <t, s> and <r, s>, r and t being p on F and
        the indicator of A restricted to the level, times N/N_l, s being 1 on the surface and 0
        beyond.
        """
        for k in range(self.distributed):
            own = self.owned[k]
            self._add_up(k, own[:, 1:-1])
            self.restrict_from(k + 1, own[:2])
        rz, xz, mean, *sums = self._sweep_coarsest(anew)
        for k in reversed(range(self.distributed)):
            own = self.owned[k]
            rz, xz, *here = self.smooth(k + 1, own, own[0])
            sums = [a + b * self.hierarchy.area.weights[k + 1] for a, b in zip(sums, here)]
            self._hand_out(k, self.owned[k][:1, 1:-1])
        first = self.steps[0].transfer
        ratio = self.grid.cell_points / (first.m[0] * first.m[1])
        return rz * ratio, xz * ratio, mean, *sums

    def restrict_from(self, k: int, fine: np.ndarray) -> None:
        """Restrict two fields of level k, (2, rows + 2, n) with valid own rows, to the window of
        the next one."""
        coarse, transfer = self.fields[k][:2], self.transfers[k]
        coarse[:, :1], coarse[:, -1:] = 0, 0
        on_threads(
            self.grid.threads,
            lambda i0, i1: restrict_level(fine, coarse, transfer.tables, i0, i1),
            transfer.pieces,
        )

    def smooth(self, k: int, fields: np.ndarray, out: np.ndarray) -> np.ndarray:
        """Make z of level k from that of the next one, see kernels/multilevel.py; fields: its r, t
        and perhaps x. Returns the sums."""
        z, transfer = self.fields[k][0], self.transfers[k]
        weight, nominal = self.hierarchy.weights[k], self.hierarchy.nominal[k]

        def smooth(i0: int, i1: int) -> tuple[float, ...]:
            return smooth_level(
                fields, z, out, weight, self.damping, transfer.tables, nominal, i0, i1
            )

        sums = on_threads(self.grid.threads, smooth, transfer.pieces)
        return added(sums, 7)

    def _add_up(self, k: int, rows: np.ndarray) -> None:
        """Add up all windows on the rows of level k + 1 that this rank owns, (fields, rows, m)."""
        if not np.may_share_memory(rows, self.fields[k]):
            rows[...] = 0
        self.steps[k].windows.add(self.comm, self.fields[k][: len(rows)], rows)

    def _hand_out(self, k: int, z: np.ndarray) -> None:
        """Copy z on this rank's rows of level k + 1, (1, rows, m), into all windows."""
        self.steps[k].windows.fill(self.comm, z, self.fields[k][:1])

    def test_products(
        self,
        open_p: float,
        open_pp: float,
        contact: float,
        rr: float,
        tt: float,
        rt: float,
        ts: float,
        rs: float,
    ) -> tuple[float, float, float]:
        """Return |w|_S^2, share^2 |v|_S^2 and share <v, S w>, over the compliance of the shortest
        wave, by sums over levels.

        w = r - missing t is the pressure r that is out of contact less that load in contact; v =
        t/share - s the test pressure of certificate/error_estimates.py, share that of the surface
        in contact, s the indicator of the surface. contact: points; open_p, open_pp: sums of r and
        r^2; the others as `sweep` returns them.
        """
        share, missing, norm = contact / self.grid.N, open_p / contact, self.hierarchy.area.norm
        finest = contact * (1 - share)  # by itself: what is added may be rounding errors
        residual = max(rr - 2 * missing * rt + missing**2 * tt, 0.0)
        product = rt - share * (open_p + rs) - missing * (finest + tt - share * ts)
        test = max(tt - 2 * share * ts + share**2 * norm, 0.0)
        return open_pp + missing**2 * contact + residual, finest + test, product

    def restrict(
        self, g: np.ndarray, p: np.ndarray, hardness: np.floating | None = None
    ) -> UpdateSums:
        """Restrict what the update passes do, from a state that no step has led to; returns
        UpdateSums."""
        longest = int(np.diff(self.ends).max(initial=0))
        still = np.zeros((longest, self.grid.n[1]), self.dtype)
        d = np.zeros(still.shape, stored_dtype(self.dtype))
        none = np.zeros((1, 1), np.result_type(self.dtype, np.complex64))
        rows = still, none, none[0], np.zeros(1, np.int64), 0, (0, 0), (0, 0)
        return self.update(g, p, d, 0.0, [rows] * self.grid.threads, hardness, comes=False)

    def _sweep_coarsest(self, anew: bool) -> tuple[float, ...]:
        """Rank 0 sweeps the levels that it has alone; returns what `sweep` does, of these
        levels."""
        last, step = len(self.steps) - 1, self.steps[-1]
        n, m = step.transfer.m
        rows = np.empty((len(self.fields[last]), n if self.coarsest else 0, m), self.dtype)
        self._add_up(last, rows)
        if not self.coarsest:
            self._hand_out(last, rows[:1])
            return (0.0,) * 8
        r_s, t_s = (self.hierarchy.area.products_of_coarsest(field) for field in rows[:2])
        if anew:
            self._find_mode(self.coarsest, rows[1])
        z, squares, mean = self.coarsest.sweep(rows[0], rows[1])
        self._hand_out(last, z[None])
        ratio = self.grid.cell_points / (n * m)
        # where level 1 itself is one of them
        products = (0.0, 0.0) if self.distributed else (_dot(rows[0], z), _dot(rows[2], z))
        return *products, mean, *(a * ratio for a in squares), t_s, r_s

    def _find_mode(self, coarsest: CoarsestLevels, t: np.ndarray) -> None:
        coarsest.mode = coarsest.mode[:0]
        if self.gap_mode.wanted(t.mean()):
            coarsest.at = self.gap_mode.at or 0
            if coarsest.at > 0:
                coarsest.sweep(t, t)
                t = coarsest.contact(coarsest.at)
            coarsest.mode = self.gap_mode.find(t).ravel()


def _dot(a: np.ndarray, b: np.ndarray) -> float:
    """Return <a, b>, not by BLAS, whose threads would get into the way of the other ranks."""
    return float(np.einsum("ij,ij->", a, b))
