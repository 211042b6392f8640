"""The coarse levels of the preconditioner that one rank sweeps alone, in two compiled calls."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..kernels.multilevel import restrict_levels, smooth_levels
from ..parallel.coarsening import Level, axis_mode, axis_tables

DAMPING = 4.0  # of a level by the contact on it, over its stiffness


class CoarsestLevels:
    """Consecutive levels, down to a single point, that one rank sweeps alone, with their memory.

    A sweep applies the coarse part of the preconditioner: from r, the pressure out of contact, and
    t, the share of contact, it makes z (kernels/multilevel.py). No method is collective.

    Parameters
    ----------
    levels : list of Level
        Finest first.
    weights : array
        Stiffness of each level, in the precision of the fields.
    softness : array of float64
        Weight of each level in the sums that `smooth` returns.
    fields : int
        Number of fields of the first level: 2 (r, t) or 3 (r, t and another field x); all others
        have r and t.
    nominal : list of (s_x, s_y), optional
        The two factors of s, the indicator of the surface, on each level; default: 1 everywhere.

    Attributes
    ----------
    fields : array (fields, rows + 2, n)
        Fields of the first level with a halo row before and after. The caller writes r, t and
        perhaps x; a sweep replaces r by z.
    mode : flat array
        The gap mode (deflation.py), which the caller sets and `smooth` applies; empty: none.
    mode_level : int
        The level of the gap mode.
    """

    def __init__(
        self,
        levels: Sequence[Level],
        weights: np.ndarray,
        softness: ArrayLike,
        fields: int = 2,
        nominal: Sequence[Sequence[np.ndarray]] | None = None,
    ):
        dtype = weights.dtype
        shapes = [level.n for level in levels]
        coarser = [*shapes[1:], shapes[-1]]
        counts = [fields] + [2] * (len(levels) - 1) + [1]
        sizes = [
            count * (n_x + 2) * n_y for count, (n_x, n_y) in zip(counts, [*shapes, shapes[-1]])
        ]
        begins = np.cumsum([0, *sizes])
        rows_before = np.cumsum([0, *(n_x for n_x, _ in shapes)])
        columns_before = np.cumsum([0, *(n_y for _, n_y in shapes)])
        along = [axis_mode(n[1], m[1]) for n, m in zip(shapes, coarser)] + [0]
        shapes.append(shapes[-1])  # the level of zeros
        self._levels = np.array(
            [
                (begin, count, n_x, n_y, mode, at_x, at_y)
                for begin, count, (n_x, n_y), mode, at_x, at_y in zip(
                    begins, counts, shapes, along, rows_before, columns_before
                )
            ],
            np.int64,
        )
        rows, columns = (
            [axis_tables(n[axis], m[axis], dtype) for n, m in zip(shapes, coarser)]
            for axis in (0, 1)
        )
        if nominal is None:
            nominal = [[np.ones(n_x), np.ones(n_y)] for n_x, n_y in shapes[:-1]]
        self._tables = (
            np.concatenate([J_x + np.int32(1) for J_x, _ in rows]),
            np.concatenate([f_x for _, f_x in rows]),
            np.concatenate([J_y for J_y, _ in columns]),
            np.concatenate([f_y for _, f_y in columns]),
            np.concatenate([s_x for s_x, _ in nominal]).astype(dtype),
            np.concatenate([s_y for _, s_y in nominal]).astype(dtype),
        )
        factors = [m[0] / n[0] * m[1] / n[1] for n, m in zip(shapes, coarser)]
        self._numbers = np.array([weights, factors], dtype).T.copy()
        self._softness = np.asarray(softness, np.float64)
        self._damping = dtype.type(DAMPING)
        self._memory = np.zeros(begins[-1], dtype)
        self._scratch = np.empty((2, max(n_y for _, n_y in shapes)), dtype)
        self.fields = self._fields_of(0)
        self.mode = np.zeros(0, dtype)
        self.mode_level = 0

    def sweep(self) -> tuple[float, ...]:
        """Restrict r and t of `fields` to all levels and replace r by z; return `smooth`'s sums."""
        self.restrict()
        return self.smooth()

    def restrict(self) -> None:
        """Restrict r and t of the first level to all coarser ones, in the memory of this object."""
        restrict_levels(self._memory, self._levels, self._tables, self._numbers, self._scratch)

    def smooth(self) -> tuple[float, ...]:
        """Replace r by z on every level, from the coarsest one to the first, after `restrict`.

        Returns
        -------
        tuple
            <r, z> and <x, z> on the first level; <r, r>, <t, t>, <r, t>, <t, s> and <r, s>, summed
            over levels times their softness; the mean of r.
        """
        return smooth_levels(
            self._memory,
            self._levels,
            self._tables,
            self._numbers,
            self._softness,
            self._damping,
            self.mode,
            self.mode_level,
            self._scratch,
        )

    def apply(self, r: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Copy r and t into `fields`, sweep, and return z on the first level.

        Parameters
        ----------
        r, t : array (rows, n)
            Fields of the first level; they stay as they are.

        Returns
        -------
        array (rows, n)
            z, a view of `fields`: the next sweep overwrites it.
        """
        self.fields[0, 1:-1] = r
        self.fields[1, 1:-1] = t
        self.sweep()
        return self.fields[0, 1:-1]

    def contact(self, k: int) -> np.ndarray:
        """Return t of level k as `restrict` left it, (rows, n), a view."""
        return self._fields_of(k)[1, 1:-1]

    def _fields_of(self, k: int) -> np.ndarray:
        """Return the fields of level k with their halo rows, (fields, rows + 2, n), a view."""
        begin, count, rows, n = self._levels[k, :4].tolist()
        return self._memory[begin : begin + count * (rows + 2) * n].reshape(count, rows + 2, n)
