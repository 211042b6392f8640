"""A solved contact at one load, and the sums that observables are made of, in the scene's units."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..bodies.base import Body
from ..bodies.halfspace import HALF_SPACE
from ..certificate.certificate import Certificate
from ..kernels.pressure import contact_pressure
from ..laws.base import Law
from ..operators.tangent import Tangent, tangent
from ..output.fields import LazyField
from ..parallel.clusters import Clusters, find_clusters
from ..parallel.grid import Grid
from ..parallel.threads import added
from ..surface import Surface
from ..surface.number_range import field_dtype
from .edges import EdgeSides, edge_sides
from .fields import field_of_surface
from .notes import notes_on
from .peak import Peak, peak_of

ROUNDING = 16  # times the rounding error of the heights: a mean gap below that is nothing else


class OtherBranch(NamedTuple):
    """Contact area of the same load from the other side, and whether both equilibria agree."""

    a_r: float
    agrees: bool


@dataclass(frozen=True)
class Contact:
    """The solution of one load. Observables are functions of it.

    Its numbers are in the scene's units and the same on all ranks; its fields are local slabs.

    Attributes
    ----------
    surface : Surface
        The rigid surface, and the grid that the load was solved on.
    E_star : float
        Effective modulus; other pressures are in its unit.
    p_mean : float
        Mean pressure over the nominal area.
    g, p : array, local slabs of the grid
        Gap and pressure as the solver left them, in the program's units (operators/problem.py),
        padding of the grid included. Where a point yields, g < 0 is minus the depth of the dent.
        Out of contact p need not be 0; `pressure_rows` and `gap_rows` return the results. The next
        load of a sweep overwrites g and p.
    status : str
        "converged", "stagnated", "max_iterations", "nonfinite", "interrupted", or "separated" if
        the load pulls more than the attraction holds. Separated bodies have no contact, and the
        fields are those of undeformed bodies.
    certificate : Certificate
        The independent check of this solution, with its errors.
    accuracy : float
        Relative accuracy that was required of the solution; observables that solve further
        equations, such as the stiffness, have to reach it, too.
    lam_s : float or None
        Shortest wavelength of the surface; None if unknown.
    body : Body
        The elastic body.
    remark : str or None
        Note on how the pressure of this load was found; None if it was prescribed or there is
        nothing to say.
    iterations : int
        Iterations on the finest grid.
    pairs : float
        FFT pairs that the solution took; those of coarser grids count by their share of the points.
    hardness : float or None
        The largest pressure, in the unit of E_star; None if unlimited.
    attraction : Law or None
        Law of attraction, in the unit of E_star and that of lengths; None without attraction.
    other_branch : OtherBranch or None
        What the same load gives on the other branch; None if that was not requested or not solved.
    gap_discretisation : float or None
        Estimated relative error of the mean gap by the grid spacing; None if no coarser grid was
        solved.
    dents : ndarray or None
        Depth of the dents that this load and those before have left, in the program's unit, local
        slab of the surface; None unless dents stay (load.history).
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
    gap_discretisation: float | None = None
    dents: np.ndarray | None = None

    @property
    def grid(self) -> Grid:
        """The grid that the load was solved on."""
        return self.surface.grid

    @property
    def N(self) -> int:
        """Number of points of the surface, without padding of the grid."""
        return self.grid.N

    @property
    def g_rms(self) -> float:
        """Rms gradient of the heights as they are on the grid."""
        return self.surface.g_rms

    @property
    def h_rms(self) -> float:
        """Rms height of the surface as it is on the grid."""
        return self.surface.h_rms

    @property
    def pressure_unit(self) -> float:
        """The program's unit of pressure, in the unit of E_star: E_star times `surface.slope`."""
        return self.E_star * self.surface.slope

    @property
    def p_star(self) -> float:
        """p_mean/(E* g_rms); nan on a flat surface."""
        return self.p_mean / self.pressure_unit if self.g_rms > 0 else float("nan")

    @property
    def wall_pressure(self) -> float:
        """Mean pressure on the wall in the unit of E_star: p_mean plus the mean attraction."""
        return self.p_mean + self.certificate.attraction * self.pressure_unit

    @property
    def approach(self) -> float:
        """Length by which the bodies have approached since they touched; nan if unbounded."""
        return self.certificate.approach * self.surface.height_unit

    @property
    def is_separated(self) -> bool:
        """Whether the load pulls more than the attraction holds, so that there is no contact."""
        return self.status == "separated"

    @property
    def contact_points(self) -> int:
        """Number of points in contact."""
        return self.certificate.contact

    @property
    def gap_mean(self) -> float:
        """Mean gap over the nominal area; points in contact and dents count as 0."""
        return self.certificate.gap_mean * self.surface.height_unit

    @property
    def energy(self) -> float:
        """Elastic energy per nominal area; nan if undefined (`Certificate.energy`)."""
        return self.certificate.energy * self.pressure_unit * self.surface.height_unit

    @property
    def note(self) -> str | None:
        """All notes on this contact in one line; None if there are none."""
        return "; ".join(notes_on(self)) or None

    @property
    def gap_is_rounding(self) -> bool:
        """Whether the gap is open somewhere, but its mean is below rounding errors of heights."""
        rounding_errors = ROUNDING * float(np.finfo(self.g.dtype).eps) * self.h_rms
        return self.contact_points < self.N and self.gap_mean < rounding_errors

    @cached_property
    def tangent(self) -> Tangent:
        """Response to a small load change at fixed contact points. Collective at first use."""
        rows, points = self.grid.inside
        touching = np.zeros(self.g.shape, dtype=bool)
        touching[:rows, :points] = self.touching(0, rows)
        solved = tangent(self.grid, self.body, touching, self.g.dtype, self.accuracy)
        self.asked_pairs.append(solved.pairs)
        return solved

    @cached_property
    def asked_pairs(self) -> list[float]:
        """FFT pairs of each observable computed so far; observables append to this list."""
        return []

    @property
    def fft_pairs(self) -> float:
        """All FFT pairs so far: those of the solution and those of observables."""
        return self.pairs + sum(self.asked_pairs)

    @property
    def periodic(self) -> tuple[bool, bool]:
        """Whether the surface is periodic along x, along y; False if it has free edges there."""
        nominal = self.grid.nominal
        n = self.grid.n
        return nominal[0] == n[0], nominal[1] == n[1]

    def touching(self, i0: int, i1: int) -> np.ndarray:
        """Return a mask of the points in contact, in some rows of this rank.

        Parameters
        ----------
        i0, i1 : int
            First row and the one behind the last, counted from the first row of this rank, within
            the surface.

        Returns
        -------
        ndarray of bool, shape (i1 - i0, n_y)
            n_y is that of the surface, without padding.
        """
        points = self.grid.nominal[1]
        return (self.g[i0:i1, :points] <= 0) & (self.p[i0:i1, :points] > 0)

    def pressure_rows(self, i0: int, i1: int) -> np.ndarray:
        """Return the pressure in some rows of this rank as a new array.

        Parameters
        ----------
        i0, i1 : int
            As for `touching`.

        Returns
        -------
        ndarray, shape (i1 - i0, n_y)
            In the program's units (`pressure_unit`): 0 out of contact, the hardness where a point
            yields.
        """
        p = self.p[i0:i1]
        p_yield = None
        if self.hardness is not None:
            p_yield = p.dtype.type(self.hardness / self.pressure_unit)
        pressure = np.empty((len(p), self.grid.nominal[1]), p.dtype)
        contact_pressure(self.g[i0:i1], p, p_yield, pressure)
        return pressure

    def gap_rows(self, i0: int, i1: int) -> np.ndarray:
        """Return the gap in some rows of this rank, with 0 where there is a dent.

        Parameters
        ----------
        i0, i1 : int
            As for `touching`.

        Returns
        -------
        ndarray, shape (i1 - i0, n_y)
            In the program's units (`surface.height_unit`). Without a hardness it is a view of `g`;
            do not change it.
        """
        g = self.g[i0:i1, : self.grid.nominal[1]]
        return g if self.hardness is None else np.maximum(g, 0)

    def dent_rows(self, i0: int, i1: int) -> np.ndarray:
        """Return the depth of dents in some rows, of this load and, where dents stay, of all
        before.

        Parameters
        ----------
        i0, i1 : int
            As for `touching`.

        Returns
        -------
        ndarray, shape (i1 - i0, n_y)
            In the program's units (`surface.height_unit`).
        """
        if self.dents is not None:
            return self.dents[i0:i1]
        return np.maximum(-self.g[i0:i1, : self.grid.nominal[1]], 0)

    @cached_property
    def dent_sums(self) -> tuple[int, float]:
        """Number of points with a dent, and mean depth over all points, a length. Collective."""
        grid = self.grid

        def sums(i0: int, i1: int) -> tuple[float, float]:
            depth = self.dent_rows(i0, i1)
            return float(np.count_nonzero(depth)), float(depth.sum(dtype=float))

        points, depth = grid.comm.sum(added(grid.by_rows(sums, grid.inside[0]), 2))
        return int(points), float(depth) / self.N * self.surface.height_unit

    def clusters(
        self, of_contact: bool = True, corners: bool = False, open_axis: int | None = None
    ) -> Clusters:
        """Return the connected clusters of the points in contact, or of the points that are open.

        Computed once for each choice of arguments. Collective.

        Parameters
        ----------
        of_contact : bool
            True: clusters of points in contact; False: of open points.
        corners : bool
            Whether points that share only a corner are connected.
        open_axis : int, optional
            Axis along which the surface is treated as not periodic: a cluster percolates along it
            if it reaches from the first point to the last.

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
        """Return the connected clusters of the points of a mask. Collective; nothing is kept.

        Parameters
        ----------
        mask : callable
            mask(i0, i1) returns rows of the mask, as `touching` does.
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
        """Results of `clusters` so far, by its arguments."""
        return {}

    @cached_property
    def edges(self) -> EdgeSides:
        """The edge of the contact, in sides of grid cells. Collective at first use."""
        return edge_sides(self)

    @cached_property
    def peak(self) -> Peak:
        """The largest pressure and those beside it. Collective at first use."""
        return peak_of(self)

    @property
    def boundary_segments(self) -> int:
        """Number of grid-cell sides between contact and open points. Collective at first use."""
        return self.edges.along_x + self.edges.along_y

    def field(self, name: str) -> LazyField:
        """Return a field as a local slab that is computed when it is sliced, a few rows at a time.

        Parameters
        ----------
        name : str
            "pressure" (>= 0, and 0 out of contact), "gap" (>= 0), "displacement" (positive away
            from the rigid surface, dents included; only if `surface.h` is not None), "plastic"
            (depth by which this load has deepened dents, >= 0) or "dent" (depth of the dents that
            stay, >= 0; only with `dents`).

        Returns
        -------
        LazyField
            This rank's rows of the surface, in the scene's units. The precision is that of the
            solution, or double if single cannot hold such values. It reads the solver's own arrays,
            which the next load of a sweep overwrites.
        """
        dtype = field_dtype(name, self.g.dtype, self.wall_pressure, self.surface)
        real = dtype.type

        def values(i0: int, i1: int) -> np.ndarray:
            if name == "pressure":
                return self.pressure_rows(i0, i1) * real(self.pressure_unit)
            if name == "dent":
                assert self.dents is not None  # refused beforehand without load.history
                return (self.dents[i0:i1] * self.surface.height_unit).astype(dtype)
            g = self.gap_rows(i0, i1)
            if name == "displacement":
                assert self.surface.h is not None  # refused beforehand with solver.low_memory
                g = g - self.surface.h[i0:i1]
            elif name == "plastic":
                g = g - self.g[i0:i1, : g.shape[1]]
            return g * real(self.surface.height_unit)

        return field_of_surface(self.surface, values, dtype)
