"""A solved contact at one load: fields and the sums that observables are made of, in the scene's
units."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..bodies.base import Body
from ..bodies.halfspace import HALF_SPACE
from ..certificate.certificate import Certificate
from ..laws.base import Law
from ..operators.tangent import Tangent, tangent
from ..output.fields import LazyField
from ..parallel.clusters import Clusters, find_clusters
from ..parallel.grid import Grid
from ..parallel.halo import next_row
from ..parallel.threads import added
from ..surface import Surface
from ..surface.number_range import field_dtype
from .notes import notes_on
from .other_branch import OtherBranch

ROUNDING = 16  # times the rounding error of the heights: a mean gap below that is nothing else


@dataclass(frozen=True)
class Contact:
    """Result of one load; observables are functions of it. Its numbers are in the scene's
    units, the same on all ranks.

    Attributes
    ----------
    surface : Surface
        The rigid surface, and the grid it was solved on.
    E_star : float
        Effective modulus; pressures are in its unit.
    p_mean : float
        Mean pressure over the nominal area.
    g, p : array, local slabs of the grid
        Gap and pressure of the solution, in the program's units (operators/problem.py); the next
        load of a sweep overwrites them.
    status : str
        "converged", "stagnated", "max_iterations", "nonfinite", "interrupted", or "separated",
        where the load pulls more than the attraction: there is no contact then, and the fields are
        those of undeformed bodies.
    certificate : Certificate
        The independent check of this solution, with its errors.
    accuracy : float
        Relative, of what observables still have to solve for.
    lam_s : float or None
        Shortest wavelength of the surface, where that is known.
    body : Body
        What is pressed.
    remark : str or None
        On how the load was found, where it was not given.
    iterations : int
        On the fine grid.
    pairs : float
        FFT pairs of the solve, as many of the fine grid.
    hardness : float or None
        The largest pressure, in the unit of E_star; None: there is none.
    attraction : Law or None
        Law of attraction, in the unit of E_star and that of lengths; None: there is none.
    other_branch : OtherBranch or None
        What the load has come to on the other branch, where that was asked for and found.
    """

    surface: Surface
    E_star: float
    p_mean: float
    g: np.ndarray
    p: np.ndarray
    status: str
    certificate: Certificate
    accuracy: float
    lam_s: float | None = None
    body: Body = HALF_SPACE
    remark: str | None = None
    iterations: int = 0
    pairs: float = 0.0
    hardness: float | None = None
    attraction: Law | None = None
    other_branch: OtherBranch | None = None

    @property
    def grid(self) -> Grid:
        """The grid that was solved."""
        return self.surface.grid

    @property
    def N(self) -> int:
        """Number of points of the surface."""
        return self.grid.N

    @property
    def g_rms(self) -> float:
        """Realised rms gradient."""
        return self.surface.g_rms

    @property
    def h_rms(self) -> float:
        """Realised rms height."""
        return self.surface.h_rms

    @property
    def pressure_unit(self) -> float:
        """What one unit of p is in the unit of E_star."""
        return self.E_star * self.surface.slope

    @property
    def p_star(self) -> float:
        """p_mean/(E* g_rms); nan on a flat surface."""
        return self.p_mean / self.pressure_unit if self.g_rms > 0 else float("nan")

    @property
    def wall_pressure(self) -> float:
        """Mean pressure that the wall bears, in the unit of E_star: p_mean, and the attraction."""
        return self.p_mean + self.certificate.attraction * self.pressure_unit

    @property
    def approach(self) -> float:
        """How far the bodies have come together since they touched undeformed; nan for a
        periodic half-space, whose displacement is unbounded."""
        return self.certificate.approach * self.surface.height_unit

    @property
    def is_separated(self) -> bool:
        """Whether the load has pulled the bodies apart."""
        return self.status == "separated"

    @property
    def contact_points(self) -> int:
        """Number of points in contact."""
        return self.certificate.contact

    @property
    def gap_mean(self) -> float:
        """Mean gap over the nominal area."""
        return self.certificate.gap_mean * self.surface.height_unit

    @property
    def energy(self) -> float:
        """Elastic energy per area."""
        return self.certificate.energy * self.pressure_unit * self.surface.height_unit

    @property
    def note(self) -> str | None:
        """What a reader should know before the numbers, one line; None if there is nothing."""
        return "; ".join(notes_on(self)) or None

    @property
    def gap_is_rounding(self) -> bool:
        """Whether the points that are open are so by less than rounding errors of the heights."""
        rounding_errors = ROUNDING * float(np.finfo(self.g.dtype).eps) * self.h_rms
        return self.contact_points < self.N and self.gap_mean < rounding_errors

    @cached_property
    def tangent(self) -> Tangent:
        """The operators.tangent.Tangent of this contact. Collective; some FFT pairs."""
        rows, points = self.grid.inside
        touching = np.zeros(self.g.shape, dtype=bool)
        touching[:rows, :points] = self.touching(0, rows)
        solved = tangent(self.grid, self.body, touching, self.g.dtype, self.accuracy)
        self.asked_pairs.append(solved.pairs)
        return solved

    @cached_property
    def asked_pairs(self) -> list[float]:
        """FFT pairs of the observables that were asked for so far."""
        return []

    @property
    def fft_pairs(self) -> float:
        """Everything counted: `pairs` and `asked_pairs`."""
        return self.pairs + sum(self.asked_pairs)

    @property
    def periodic(self) -> tuple[bool, bool]:
        """Whether opposite edges of the surface touch, along x and along y."""
        nominal = self.grid.nominal
        n = self.grid.n
        return nominal[0] == n[0], nominal[1] == n[1]

    def touching(self, i0: int, i1: int) -> np.ndarray:
        """Return which points touch in some rows of this rank.

        Parameters
        ----------
        i0, i1 : int
            First row and the one behind the last, counted within this rank's part of the surface.

        Returns
        -------
        ndarray of bool, shape (i1 - i0, n_y)
        """
        points = self.grid.nominal[1]
        return (self.g[i0:i1, :points] <= 0) & (self.p[i0:i1, :points] > 0)

    def pressure_rows(self, i0: int, i1: int) -> np.ndarray:
        """Return the pressure in some rows of this rank.

        Parameters
        ----------
        i0, i1 : int
            As for `touching`.

        Returns
        -------
        ndarray, shape (i1 - i0, n_y)
            In units of E* g_rms: 0 out of contact, the hardness where a point yields.
        """
        points = self.grid.nominal[1]
        g = self.g[i0:i1, :points]
        p = self.p[i0:i1, :points]
        p = np.where((g <= 0) & (p > 0), p, 0)
        if self.hardness is not None:
            p_yield = p.dtype.type(self.hardness / self.pressure_unit)
            p = np.where(g < 0, p_yield, np.minimum(p, p_yield))
        return p

    def gap_rows(self, i0: int, i1: int) -> np.ndarray:
        """Return the gap in some rows of this rank.

        Parameters
        ----------
        i0, i1 : int
            As for `touching`.

        Returns
        -------
        ndarray, shape (i1 - i0, n_y)
            In units of g_rms a: 0 where there is a dent.
        """
        g = self.g[i0:i1, : self.grid.nominal[1]]
        return g if self.hardness is None else np.maximum(g, 0)

    def clusters(
        self, of_contact: bool = True, corners: bool = False, open_axis: int | None = None
    ) -> Clusters:
        """Return the connected clusters of the points that touch, or of those that do not.

        Found once. Collective.

        Parameters
        ----------
        of_contact : bool
            Whether of the points that touch.
        corners : bool
            Whether points that share only a corner belong together.
        open_axis : int, optional
            Axis along which no cluster goes around the cell, though it may be periodic.

        Returns
        -------
        Clusters
        """
        key = of_contact, corners, open_axis
        if key not in self._clusters:
            self._clusters[key] = self.clusters_of(
                lambda i0, i1: self.touching(i0, i1) == of_contact, corners, open_axis
            )
        return self._clusters[key]

    def clusters_of(
        self,
        mask: Callable[[int, int], np.ndarray],
        corners: bool = False,
        open_axis: int | None = None,
    ) -> Clusters:
        """Return the connected clusters of the points of a mask. Collective.

        Parameters
        ----------
        mask : callable
            Of rows (i0, i1), as `touching`.
        corners, open_axis
            As for `clusters`.

        Returns
        -------
        Clusters
        """
        grid = self.grid
        periodic_x, periodic_y = self.periodic
        periodic = (periodic_x and open_axis != 0, periodic_y and open_axis != 1)
        return find_clusters(grid.comm, mask, grid.nominal_rows, grid.nominal, periodic, corners)

    @cached_property
    def _clusters(self) -> dict[tuple[bool, bool, int | None], Clusters]:
        """Connected areas that were found so far, by the arguments of `clusters`."""
        return {}

    @cached_property
    def edges(self) -> tuple[int, int]:
        """Grid-cell sides between a point in contact and one that is not: how many of them run
        along x, and how many along y.

        The edge of a surface that ends is none.
        """
        grid = self.grid
        rows, points = grid.inside
        starts = np.minimum(grid.starts, grid.nominal[0])
        g, p = (next_row(grid.comm, field[:rows], starts) for field in (self.g, self.p))
        below = ((g <= 0) & (p > 0))[None, :points]
        around_x, around_y = self.periodic
        if not around_x and grid.nominal_rows[1] == grid.nominal[0]:
            below = below[:0]

        def edges(i0: int, i1: int) -> tuple[int, int]:
            touching = self.touching(i0, min(i1 + 1, rows))  # with the row below
            touching = np.concatenate([touching, below]) if i1 == rows else touching
            along_y = np.count_nonzero(touching[1:] != touching[:-1])
            touching = touching[: i1 - i0]
            along_x = np.count_nonzero(touching[:, 1:] != touching[:, :-1])
            along_x += around_y * np.count_nonzero(touching[:, 0] != touching[:, -1])
            return int(along_x), int(along_y)

        along_x, along_y = grid.comm.sum(added(grid.by_rows(edges, rows), 2))
        return int(along_x), int(along_y)

    @property
    def boundary_segments(self) -> int:
        """The same, of either direction."""
        return sum(self.edges)

    def field(self, name: str) -> LazyField:
        """Return one of output.fields.FIELDS as a local slab of the whole grid, computed as it is
        read.

        In the precision of the solution, or in double precision where single cannot hold it in the
        scene's units.

        It refers to the solver's own arrays: the next load of a sweep overwrites them.

        pressure: >= 0 and 0 out of contact; gap: >= 0; displacement: >= -h, positive away from
        the rigid surface, dents included; plastic: the depth of dents.
        """
        dtype = field_dtype(name, self.g.dtype, self.wall_pressure, self.surface)
        real = dtype.type

        def values(i0: int, i1: int) -> np.ndarray:
            if name == "pressure":
                return self.pressure_rows(i0, i1) * real(self.pressure_unit)
            g = self.gap_rows(i0, i1)
            if name == "displacement":
                assert self.surface.h is not None  # refused beforehand with solver.low_memory
                g = g - self.surface.h[i0:i1]
            elif name == "plastic":
                g = g - self.g[i0:i1, : g.shape[1]]
            return g * real(self.surface.height_unit)

        return _on_the_whole_grid(self.surface, values, dtype)


def heights_of(surface: Surface) -> LazyField:
    """Return the heights of a surface.Surface in the scene's unit, peaks up, <= 0 with the highest
    at 0: as Contact.field."""
    h = surface.h
    assert h is not None  # asked for before a sweep in low memory gives them away
    dtype = field_dtype("heights", h.dtype, 0.0, surface)
    return _on_the_whole_grid(
        surface, lambda i0, i1: h[i0:i1] * -dtype.type(surface.height_unit), dtype
    )


def _on_the_whole_grid(
    surface: Surface, values: Callable[[int, int], np.ndarray], dtype: np.dtype
) -> LazyField:
    """Make the local slab, with an axis that was left out, of what values(rows of the arrays)
    gives."""
    left_out = surface.reduced_axis

    def rows(i0: int, i1: int) -> np.ndarray:
        # with the second axis left out every rank has all rows
        start = surface.rows[0] if left_out == 1 else 0
        of_arrays = values(0, 1) if left_out == 0 else values(start + i0, start + i1)
        if left_out is None:
            return of_arrays
        return np.broadcast_to(of_arrays, (i1 - i0, surface.n[1]))

    shape = surface.rows[1] - surface.rows[0], surface.n[1]
    return LazyField(rows, shape, dtype, surface.grid.by_rows)
