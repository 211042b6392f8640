"""The locally damped multilevel (BPX) preconditioner, distributed over slabs: equation (5) in
docs/method.md.

    M r = sum over levels of P ... P (weight_l + DAMPING theta_l)^-1 R ... R r

weight_l is the body's stiffness on that level (bodies/base.py), theta_l the local share of contact.
Damping each level by it is what keeps the spectrum of M K on the free points narrow at every load,
without a parameter to tune.

The finest level is never swept here: the solver's own passes restrict to level 1 (p on F, the
indicator of A, and K d on F) and interpolate from it. Which ranks have which rows of a level is
decided in hierarchy.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import DTypeLike

from ..kernels.bfloat16 import stored_dtype
from ..kernels.bpx import UpdateSums, update_passes
from ..kernels.multilevel import SUMS, join_shares, restrict_level, smooth_level
from ..kernels.transforms import no_rows
from ..parallel.coarsening import Transfer
from ..parallel.halo import add_all, add_overlaps
from ..parallel.threads import Shares, added, on_threads, pieces_of
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
    """Sweep of the multilevel preconditioner M over the coarse levels of a grid, in one precision.

    `update` or `restrict` put a state on level 1: r, the pressure out of contact, t, 1 in contact,
    and K d of the last step; `sweep` makes z = M r there and overwrites r. `precondition` does both
    for any field of the grid. Making a Multilevel is collective.

    - `distributed`: how many levels below the grid are shared by ranks; `coarsest` sweeps the
      levels below these, None on ranks that have no part in them; `last_comm`: the ranks that do.
    - `fields[k]`: this rank's window of level k + 1, (fields, rows + 2, m), whose rows are parts
      of sums until `_gather` adds those of neighbours; `owned[k]`: the rows that this rank goes on
      with, the same array where none are gathered; `steps[k]` leads there from level k.
    - `ends` (passes, 2): the rows i0 <= i < i1 of each pass of the solver, at most `longest`;
      `scratch`: of each thread.
    """

    def __init__(
        self,
        grid: Grid,
        body: Body,
        dtype: DTypeLike,
        longest: int,
        coarsest_points: int | None = None,
    ):
        self.grid = grid
        self.comm = grid.comm
        self.dtype: np.dtype = np.dtype(dtype)
        self.damping = np.array([DAMPING], self.dtype)[0]
        hierarchy = self.hierarchy = grid.once(
            (Hierarchy, body, self.dtype, coarsest_points),
            lambda: Hierarchy(grid, body, self.dtype, coarsest_points),
        )
        steps = self.steps = hierarchy.steps
        self.gap_mode = hierarchy.gap_mode
        self.transfers = [step.transfer for step in steps]
        self.distributed = len(steps) - 1
        self.coarsest: CoarsestLevels | None = None
        complete_on = steps[-1].ranks
        self.last_comm = self.comm.subcomm(complete_on)
        if self.last_comm is not None:
            self.coarsest = CoarsestLevels(hierarchy.coarsest_tables, grid.threads)
        # Level 1 is in the windows of all ranks in any case: that is what the solver's passes write
        # to and read from.
        self.fields = [np.zeros(step.window_shape, self.dtype) for step in steps[:-1]]
        # the window of a single process is the whole level
        self.fields.append(
            self.coarsest.fields
            if self.coarsest is not None and self.comm.size == 1
            else np.zeros(steps[-1].window_shape, self.dtype)
        )
        # the rows that this rank goes on with
        self.owned = [
            field if step.windows is None else np.zeros(step.owned_shape, self.dtype)
            for step, field in zip(steps[:-1], self.fields)
        ]
        to_level_1 = self.transfers[0]
        self.ends = grid.once(
            (Transfer.passes, longest),
            lambda: np.array(to_level_1.passes(longest), np.int64).reshape(-1, 2),
        )
        parts = Shares(len(self.ends), grid.threads).parts
        self._first_rows = np.empty((len(parts), 3, to_level_1.m[1]), self.dtype)
        gathered = (6, grid.n[1] + LINE // self.dtype.itemsize)
        shared = (2, 3, to_level_1.m[1])
        self.scratch = [
            (zeros_aligned(gathered, self.dtype), np.zeros(shared, self.dtype))
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
        spectra: bool = True,
        law: Any = None,
    ) -> UpdateSums:
        """Set g += s d and p += s K d, restrict to the window of level 1, return this rank's
        UpdateSums. Not collective. d: as in kernels/bfloat16.py; `rows`: of threads, with K d, as
        `spectra` or not.
        """
        grid = self.grid
        coarse = self.fields[0]
        tables = self.transfers[0].tables
        sums = np.zeros((len(self.ends), len(UpdateSums._fields)))
        if not len(self.ends):
            return UpdateSums.total(sums)
        shares = Shares(len(self.ends), grid.threads)
        step = self.dtype.type(s)

        def update_shares(thread: int) -> None:
            update_passes(
                self.ends,
                shares.parts,
                shares.turns,
                rows[thread],
                self.scratch[thread],
                self._first_rows,
                sums,
                g,
                p,
                d,
                step,
                spectra,
                coarse,
                tables,
                hardness,
                grid.inside,
                law,
            )

        shares.on_threads(update_shares, range(grid.threads))
        join_shares(self.ends, shares.parts, self._first_rows, coarse, tables[0])
        return UpdateSums.total(sums)

    @property
    def z(self) -> np.ndarray:
        """The result of `sweep` on level 1, a view: (window rows + 2, m)."""
        return self.fields[0][0]

    def sweep(self, new_share: float | None = None) -> tuple[float, ...]:
        """Replace r by z = M' r, M without the finest level, on this rank's window of level 1.
        Collective.

        new_share: elastic contact over points, if the contact is new: M gets its gap mode, if
        needed. Returns shares of sums over ranks: <p, M' p> and <K d, M' p> (after `update`,
        `restrict`) out of contact, over level 1 times N/N_1; the mean of p out of contact; <r, r>,
        <t, t>, <r, t>, <t, s>, <r, s> over levels l times softness N/N_l.
        """
        for k in range(self.distributed):
            self._gather(k)
            self._restrict_from(k + 1, self.owned[k][:2])
        rz, xz, *sums, mean = self._sweep_coarsest(new_share)
        for k in reversed(range(self.distributed)):
            fields = self.owned[k]
            rz, xz, *level_sums = self._smooth(k + 1, fields, fields[0])
            weight = self.hierarchy.area.weights[k + 1]
            sums = [total + weight * term for total, term in zip(sums, level_sums)]
            self._hand_out(k)
        m_x, m_y = self.steps[0].transfer.m
        ratio = self.grid.cell_points / (m_x * m_y)
        return rz * ratio, xz * ratio, mean, *sums

    def _restrict_from(self, k: int, fine: np.ndarray) -> None:
        """Restrict r and t of level k (0: the grid) to the next one's window. Not collective."""
        coarse = self.fields[k][:2]
        transfer = self.transfers[k]
        on_threads(
            self.grid.threads,
            lambda i0, i1, scratch: restrict_level(
                fine, coarse, transfer.tables, i0, i1, tuple(scratch[0][:2])
            ),
            transfer.pieces,
            self.scratch,
        )
        # K d is not restricted: of its rows the sweep adds up these two, if this rank has any
        self.fields[k][2:, 1:2] = 0
        self.fields[k][2:, -1:] = 0

    def _smooth(self, k: int, fields: np.ndarray, out: np.ndarray) -> np.ndarray:
        """Make z of level k (0: the grid) from r, t there and z of the next. Not collective.
        Returns <r, z>, <x, z>, <r, r>, <t, t>, <r, t>, <t, s>, <r, s> over counted rows; `out` may
        be r.
        """
        z_coarse = self.fields[k][0]
        transfer = self.transfers[k]
        weight = self.hierarchy.weights[k]
        nominal = self.hierarchy.nominal[k]

        def smooth_rows(i0: int, i1: int, scratch: tuple[np.ndarray, ...]) -> tuple[float, ...]:
            return smooth_level(
                fields,
                z_coarse,
                out,
                weight,
                self.damping,
                transfer.tables,
                nominal,
                i0,
                i1,
                tuple(scratch[0][:2]),
            )

        rows = len(transfer.k0)
        begin, end = self.steps[k].counted_rows
        counted = [(begin + i0, begin + i1) for i0, i1 in pieces_of(end - begin, transfer.n[1])]
        halo = [(i0, i1) for i0, i1 in ((0, begin), (end, rows)) if i0 < i1 <= rows]
        sums = on_threads(self.grid.threads, smooth_rows, counted + halo, self.scratch)
        return added(sums[: len(counted)], SUMS)

    def precondition(self, fields: np.ndarray, out: np.ndarray) -> float:
        """Set out = M r over the compliance of the shortest wave, for r and t on the grid itself
        (`fields`; all with halo rows); return <r, out>. Collective.
        """
        self._restrict_from(0, fields)
        self.sweep()
        return float(self.comm.sum([self._smooth(0, fields, out)[0]])[0])

    def _gather(self, k: int) -> None:
        """Complete the sums, and bring rows of level k + 1 to the ranks that go on. Collective."""
        step = self.steps[k]
        if step.windows is not None:
            rows = self.owned[k][:, 1:-1]
            rows[...] = 0
            step.windows.add(self.comm, self.fields[k][:, 1:-1], rows)
            self._add_group(k)

    def _add_group(self, end: int) -> None:
        """Add up shared rows before `fields[end]`, since the last gathering, by one message a
        neighbour. Collective.
        """
        begin = end
        while begin > 0 and self.steps[begin - 1].windows is None:
            begin -= 1
        steps = self.steps[begin:end]
        if steps:
            windows = [field[:, 1:-1] for field in self.fields[begin:end]]
            add_overlaps(self.comm, [step.overlaps for step in steps], windows)

    def _hand_out(self, k: int) -> None:
        """Copy z of level k + 1, if its rows are gathered, into all ranks' windows. Collective."""
        windows = self.steps[k].windows
        if windows is not None:
            windows.fill(self.comm, self.owned[k][:1, 1:-1], self.fields[k][:1, 1:-1])

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
        """Estimate |w|_S^2, share^2 |v|_S^2, share <v, S w> over the shortest wave's compliance. w
        = r - missing t: pressure out of contact, less that load in contact; v = t/share - s
        (certificate/error_estimates.py).
        """
        share = contact / self.grid.N
        missing = open_p / contact
        norm = self.hierarchy.area.norm
        finest = contact * (1 - share)  # by itself: what is added may be rounding errors
        residual = max(rr - 2 * missing * rt + missing**2 * tt, 0.0)
        product = rt - share * (open_p + rs) - missing * (finest + tt - share * ts)
        test = max(tt - 2 * share * ts + share**2 * norm, 0.0)
        return open_pp + missing**2 * contact + residual, finest + test, product

    def restrict(
        self, g: np.ndarray, p: np.ndarray, hardness: np.floating | None = None
    ) -> UpdateSums:
        """Restrict a state to level 1, as `update` does, with K d = 0. Not collective."""
        longest = int(np.diff(self.ends).max(initial=0))
        still = np.zeros((longest, self.grid.n[1]), self.dtype)
        d = np.zeros(still.shape, stored_dtype(self.dtype))
        rows = [no_rows(still)] * self.grid.threads
        return self.update(g, p, d, 0.0, rows, hardness, spectra=False)

    def _sweep_coarsest(self, new_share: float | None) -> tuple[float, ...]:
        """Sweep the levels that a rank has alone, after r and t are summed, and copy z to the
        window; sums on the first such rank, else 0. Collective.
        """
        k = self.distributed
        nothing = (0.0,) * (SUMS + 1)
        coarsest = self.coarsest
        if coarsest is None or self.last_comm is None:
            self._add_group(k)
            return nothing
        transfer = self.transfers[k]
        fields = coarsest.fields
        is_whole = self.fields[k] is fields
        if is_whole:
            fields[:, 1] += fields[:, -1]  # the row after the last is the first
        else:
            bounds = [(int(transfer.lo[r]), int(transfer.hi[r])) for r in self.steps[k].ranks]
            add_all(self.last_comm, self.fields[k][:, 1:-1], bounds, fields[:, 1:-1])
        self._add_group(k)
        if new_share is not None:
            coarsest.restrict()
            self._find_mode(coarsest, new_share)
            sums = coarsest.smooth()
        else:
            sums = coarsest.sweep()
        if not is_whole:
            rows = np.arange(transfer.lo[transfer.rank], transfer.hi[transfer.rank])
            z = self.fields[k][0, 1:-1]
            np.take(fields[0, 1:-1], rows, axis=0, out=z, mode="wrap")
        return sums if self.last_comm.rank == 0 else nothing

    def _find_mode(self, coarsest: CoarsestLevels, share: float) -> None:
        """Set the gap mode, from t on the levels that a rank has alone; none if not wanted."""
        coarsest.mode = coarsest.mode[:0]
        level = self.gap_mode.level
        if level is not None and self.gap_mode.wanted(share):
            coarsest.mode_level = level - len(self.steps)
            coarsest.mode = self.gap_mode.find(coarsest.contact(coarsest.mode_level)).ravel()
