"""The contacts that are measured: self-affine surfaces of the paper's kind, one seed each, periodic
or with free edges."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from hpc_gfmd.bodies import body_of
from hpc_gfmd.bodies.base import Body
from hpc_gfmd.driver.sweep import Sweep
from hpc_gfmd.parallel.comm import Comm, SerialComm
from hpc_gfmd.scene import Material, Scene, Solver
from hpc_gfmd.surface import Surface, build_surface

from .cells import Cells

L_OVER_LAM_L, LAM_S_OVER_A = 2, 2
DTYPES = {"single": np.float32, "double": np.float64}


@dataclass(frozen=True)
class Case:
    """n x n points, Hurst exponent, p* = p0/(E* g_rms). E* = 1, g_rms = 1, a cell of size 1 x 1.

    by_cells: with free edges the pressure is constant on the cells of grid points, as other codes
    have it; ours is band-limited. On a periodic surface all have the same.
    """

    n: int
    hurst: float
    p_star: float
    seed: int = 1
    boundary: str = "periodic"
    by_cells: bool = False

    def _scene(self, **load: float) -> Scene:
        surface = {
            "kind": "self-affine",
            "hurst": self.hurst,
            "L_over_lam_l": L_OVER_LAM_L,
            "lam_s_over_a": LAM_S_OVER_A,
            "lam_l_over_lam_s": self.n / (L_OVER_LAM_L * LAM_S_OVER_A),
            "seed": self.seed,
            "g_rms": 1.0,
            "boundary": self.boundary,
        }
        return Scene.from_dict({"surface": surface, "load": load})

    @cached_property
    def spec(self) -> Any:
        """scene.surface of this case."""
        return self._scene(p_star=self.p_star).surface

    @property
    def body(self) -> Body:
        """The elastic body, see bodies/."""
        free = self.spec.free
        return Cells(free) if self.by_cells and any(free) else body_of(Material(), free)

    @property
    def of_others(self) -> Case:
        """The same contact as the other codes discretise it."""
        return replace(self, by_cells=True)

    def at_area(self, a_r: float) -> Case:
        """The same surface at the load at which about a share a_r of it touches."""
        sweep = Sweep(self.surface, Solver(accuracy=1e-3), body=self.body)
        found = sweep.solve(sweep.pressures(self._scene(a_r=a_r).load)[0]).p_mean
        return replace(self, p_star=float(f"{found:.3g}"))

    def surface(self, dtype: DTypeLike, comm: Comm | None = None, threads: int = 1) -> Surface:
        """surface.Surface in one precision."""
        return build_surface(self.spec, comm or SerialComm(), dtype, threads)

    def gap(self) -> np.ndarray:
        """The gap under zero load, (n, n) float64, in units of the cell's size; peaks touch at
        0."""
        surface = self.surface(np.float64)
        assert surface.h is not None
        return surface.h * surface.height_unit

    @property
    def label(self) -> dict[str, Any]:
        """What tells it from others, as part of a row."""
        return {
            "n": self.n,
            "hurst": self.hurst,
            "p_star": self.p_star,
            "seed": self.seed,
            "boundary": self.boundary,
        }
