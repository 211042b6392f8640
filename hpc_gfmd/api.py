"""The contact of a NumPy array of heights, on one process, without files."""

import warnings
from dataclasses import dataclass, field

import numpy as np

from .contact import FIELDS
from .driver.sweep import Sweep
from .errors import NotConverged, SceneError
from .parallel.comm import SerialComm
from .registry import all_observables
from .scene import Load, Solver
from .surface.build import surface_from_rows


@dataclass(frozen=True)
class Solution:
    """a_r, kappa, gap_mean; pressure and gap: fields (n_x, n_y) in the units of E_star and of the heights; status; iterations;
    fft_pairs: everything counted; errors: estimated relative errors of (a_r, gap_mean, pressure field); p_star; note: what limits the
    meaning of the numbers, such as too few points that touch, or None; observables: those that were asked for, by name."""

    a_r: float
    kappa: float
    gap_mean: float
    pressure: np.ndarray
    gap: np.ndarray
    displacement: np.ndarray
    status: str
    iterations: int
    fft_pairs: float
    errors: tuple[float, float, float]
    p_star: float
    note: str | None = None
    observables: dict[str, float | None] = field(default_factory=dict)


def solve(heights, pressure, E_star=1.0, physical_sizes=(1.0, 1.0), accuracy=1e-3, observables=(), **solver):
    """Press an elastic half-space of modulus E_star against rigid heights with a mean pressure.

    heights: (n_x, n_y), peaks up, in the unit of physical_sizes; pressure: in the unit of E_star; accuracy: wanted relative accuracy
    of a_r, gap_mean and pressure field; observables: names as in the scene's [output], such as "stiffness"; solver: further keys of
    the scene's [solver] (name, precision, residual, ...), and threads.
    Returns a Solution; warns (errors.NotConverged) if its status is not "converged". Raises SceneError for input that makes no sense.
    """
    threads = solver.pop("threads", 1)
    if not isinstance(threads, int) or threads < 1:
        raise SceneError(f"threads: found {threads!r}, allowed: a whole number from 1")
    if np.ma.is_masked(heights):
        raise SceneError("heights: found masked points, allowed: a complete height map")
    heights = np.asarray(heights)
    if heights.ndim != 2 or heights.size == 0 or heights.dtype.kind not in "fiu":
        raise SceneError(f"heights: found shape {heights.shape} of {heights.dtype}, allowed: a real array with two axes, not empty")
    settings = _validated(Solver, "solver", solver if "residual" in solver else {"accuracy": accuracy} | solver)
    known = all_observables()
    if isinstance(observables, str) or not set(observables) <= set(known):
        raise SceneError(f"observables: found {observables!r}, allowed: a list of {', '.join(known)}")
    load = _validated(Load, "pressure", {"pressure": [pressure]})
    try:
        E_star, sizes = float(E_star), tuple(float(s) for s in physical_sizes)
    except (TypeError, ValueError):
        raise SceneError(f"found E_star = {E_star!r}, physical_sizes = {physical_sizes!r}, allowed: positive numbers") from None
    if not (E_star > 0 and np.isfinite(E_star) and len(sizes) == 2 and min(sizes) > 0 and np.isfinite(sizes).all()):
        raise SceneError(f"found E_star = {E_star:g}, physical_sizes = {sizes}, allowed: positive numbers")

    def make_surface(dtype):
        def rows(start, stop):
            return np.asarray(heights[start:stop], dtype=np.float64)

        return surface_from_rows(heights.shape, sizes, rows, SerialComm(), dtype, threads)

    sweep = Sweep(make_surface, settings, E_star, duality="duality_gap" in observables)
    step = sweep.solve(load.pressure[0])
    contact = step.contact
    if contact.outcome.status != "converged":
        errors = ", ".join(f"{error:.1e}" for error in contact.outcome.errors)
        warnings.warn(f"not converged ({contact.outcome.status}): estimated errors of area, mean gap, pressure: {errors}",
                      NotConverged, stacklevel=3)  # where the caller of hpc_gfmd.solve is
    asked = {name: known[name](contact) for name in observables}
    a_r = contact.contact_points / contact.N
    return Solution(a_r, a_r / contact.p_star if contact.g_rms > 0 else float("nan"), contact.gap_mean,
                    *(np.asarray(contact.field(name)) for name in FIELDS), contact.outcome.status,
                    step.iterations, step.fft_pairs, contact.outcome.errors, contact.p_star, contact.note, asked)


def _validated(table, key, values):
    from pydantic import ValidationError

    from .registry import solver_names

    try:
        checked = table(**values)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"][:1])
        raise SceneError(f"{where or key}: found {first.get('input')!r}: {first['msg']}") from None
    if table is Solver and checked.name not in ("auto", *solver_names()):
        raise SceneError(f"name: found {checked.name!r}, allowed: auto, {', '.join(solver_names())}")
    return checked
