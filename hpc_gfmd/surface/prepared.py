"""A measured surface for a notebook: read and prepared as a scene would, on one process."""

from dataclasses import dataclass

import numpy as np

from ..parallel.comm import SerialComm
from ..scene import Scene
from .prepare import prepare
from .topography import open_topography


@dataclass(frozen=True)
class PreparedSurface:
    """heights: (n_x, n_y), peaks up; sizes: (L_x, L_y), both in m where `unit` is "m", otherwise ("") in a unit that nobody named;
    prepared: what was done to the heights, and notes: what to know of them before the numbers, a line each; free: whether it ends
    along x, along y."""

    heights: np.ndarray
    sizes: tuple[float, float]
    unit: str
    prepared: tuple[str, ...]
    notes: tuple[str, ...]
    free: tuple[bool, bool]


def read_surface(path, **keys):
    """See hpc_gfmd.read_surface."""
    surface = {"kind": "file", "path": str(path)} | {key: _plain(value) for key, value in keys.items()}
    spec = Scene.from_dict({"surface": surface, "load": {"p_star": 1.0}}, "hpc_gfmd.read_surface").surface
    found, done, notes = prepare(open_topography(spec), spec, SerialComm())
    return PreparedSurface(found.rows(0, found.n[0]), found.sizes, found.unit, done, notes, spec.free)


def _plain(value):
    return list(value) if isinstance(value, tuple) else value.tolist() if isinstance(value, np.ndarray | np.generic) else value
