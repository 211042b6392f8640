"""A solved contact at one load: fields and the sums that observables are made of, in the scene's units."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .bodies.halfspace import HALF_SPACE
from .errors import SceneError
from .units import field_dtype

FIELDS = ("pressure", "gap", "displacement")
LAZY_ROWS = 64  # of a field that are computed at a time
FEW_POINTS = 100  # fewer contact points than this say little about a rough contact
ROUNDING = 16  # times the rounding error of the heights: a mean gap below that is nothing else


@dataclass(frozen=True)
class Contact:
    """surface: surface.Surface; g, q: gap and pressure of the solution in the program's units, local slabs; p: mean pressure in the
    unit of E_star; outcome: see driver/; accuracy: relative, of what observables still have to solve for; lam_s: or None."""

    surface: object
    E_star: float
    p: float
    g: np.ndarray
    q: np.ndarray
    outcome: object
    accuracy: float
    lam_s: float | None = None
    body: object = HALF_SPACE

    @property
    def certificate(self):
        """The judgement of this solution."""
        return self.outcome.certificate

    @property
    def N(self):
        """Number of points of the grid that was solved."""
        return self.surface.grid.N

    @property
    def g_rms(self):
        """Realised rms gradient."""
        return self.surface.g_rms

    @property
    def h_rms(self):
        """Realised rms height."""
        return self.surface.h_rms

    @property
    def pressure_unit(self):
        """What one unit of q is in the unit of E_star."""
        return self.E_star * self.g_rms if self.g_rms > 0 else self.p

    @property
    def p_star(self):
        """p/(E* g_rms); nan on a flat surface."""
        return self.p / self.pressure_unit if self.g_rms > 0 else float("nan")

    @property
    def contact_points(self):
        """Number of points in contact."""
        return self.certificate.contact

    @property
    def gap_mean(self):
        """Mean gap."""
        return self.certificate.gap_mean * self.surface.height_unit

    @property
    def energy(self):
        """Elastic energy per area."""
        return self.certificate.energy * self.pressure_unit * self.surface.height_unit

    @property
    def note(self):
        """What a reader should know before the numbers, one line; None if there is nothing."""
        return "; ".join(filter(None, [self._doubt, *self.surface.notes])) or None

    @property
    def _doubt(self):
        """Why a solution that is converged may yet say little."""
        points = self.contact_points
        if self.g_rms == 0:
            return "flat surface: every point touches at any load"
        if points == self.N:
            return "full contact: every point touches, the gap is zero"
        if points < FEW_POINTS:
            touch = "touches" if points == 1 else "touch"
            return f"only {points} point{'s' * (points != 1)} {touch}: the area is known to {100 / max(points, 1):.0f} % at best"
        if self.gap_mean < ROUNDING * float(np.finfo(self.g.dtype).eps) * self.h_rms:
            precision = "single" if self.g.dtype == np.float32 else "double"
            return f"the gap is all rounding at this load in {precision} precision"
        return None

    @cached_property
    def tangent(self):
        """The operators.tangent.Tangent of this contact. Collective; some FFT pairs."""
        from .operators.tangent import tangent

        return tangent(self.surface.grid, self.body, (self.g <= 0) & (self.q > 0), self.g.dtype, self.accuracy)

    @property
    def pairs(self):
        """FFT pairs that observables of this contact took so far."""
        return self.tangent.pairs if "tangent" in vars(self) else 0.0

    @cached_property
    def boundary_segments(self):
        """Grid-cell sides between a point in contact and one that is not."""
        from .kernels.certify import contact_edges
        from .parallel import halo

        grid = self.surface.grid
        if grid.N == 1:
            return 0
        below = halo.next_row(grid.comm, np.stack([self.g[:1], self.q[:1]]))
        return int(grid.comm.sum([contact_edges(self.g, self.q, below[0], below[1])])[0])

    def field(self, name):
        """One of FIELDS as a local slab of the whole grid, computed as it is read.

        In the precision of the solution, or in double precision where single cannot hold it in the scene's units.

        It refers to the solver's own arrays: the next load of a sweep overwrites them.

        pressure: >= 0 and 0 out of contact; gap: >= 0; displacement: u >= -h, positive away from the wall.
        Raises SceneError for an unknown name.
        """
        if name not in FIELDS:
            raise SceneError(f"output.fields: found {name!r}, allowed: {', '.join(FIELDS)}")
        start, stop = self.surface.rows
        dtype = field_dtype(name, self.g.dtype, self.p, self.surface)
        return LazyField(lambda i0, i1: self._field_rows(name, i0, i1, dtype.type), (stop - start, self.surface.n[1]), dtype)

    def _field_rows(self, name, i0, i1, real):
        left_out = self.surface.reduced_axis
        if left_out == 0:
            take = slice(0, 1)
        else:  # with the other axis left out every rank has all rows
            first = self.surface.rows[0] if left_out == 1 else 0
            take = slice(first + i0, first + i1)
        g, q = self.g[take], self.q[take]
        if name == "pressure":
            values = np.where((g <= 0) & (q > 0), q, 0) * real(self.pressure_unit)
        else:
            values = (g if name == "gap" else g - self.surface.h[take]) * real(self.surface.height_unit)
        return values if left_out is None else np.broadcast_to(values, (i1 - i0, self.surface.n[1]))


class LazyField:
    """A local slab that is computed a few rows at a time when it is sliced; np.asarray makes all of it."""

    ndim = 2

    def __init__(self, rows, shape, dtype):
        self.rows, self.shape, self.dtype = rows, shape, np.dtype(dtype)

    def __len__(self):
        return self.shape[0]

    def __getitem__(self, rows):
        i0, i1, _ = rows.indices(self.shape[0])
        out = np.empty((max(i1 - i0, 0), self.shape[1]), self.dtype)
        for i in range(i0, i1, LAZY_ROWS):
            j = min(i + LAZY_ROWS, i1)
            out[i - i0:j - i0] = self.rows(i, j)
        return out

    def __array__(self, dtype=None, copy=None):
        return np.array(self[:], dtype=dtype)
