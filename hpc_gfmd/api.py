"""The contact of a NumPy array of heights, on one process, without files."""

import warnings
from dataclasses import dataclass, field, replace

import numpy as np

from .contact import FIELDS
from .driver.sweep import Sweep
from .errors import NotConverged, SceneError, one_line
from .kernels.cache import sound
from .observables.area import a_r_discretisation
from .parallel.comm import SerialComm, threads_of
from .registry import body_of, distribution_names, distributions_named, observable_names, observables_named, solver_names
from .scene import ArrayScene, check_names
from .surface.build import surface_from_rows
from .surface.prepared import PreparedSurface


@dataclass(frozen=True)
class Solution:
    """a_r, kappa, gap_mean; pressure and gap: fields (n_x, n_y) in the units of E_star and of the heights; status; iterations;
    fft_pairs: everything counted; errors: the solver's estimated relative errors of (a_r, gap_mean, pressure field) on this grid;
    a_r_discretisation: estimated relative error of a_r by the size of a grid point (see observables.area); p_star; precision: in which
    it was solved; note: what limits the meaning of the numbers, such as too few points that touch, or None; observables: those that
    were asked for, by name; distributions: arrays of those that were asked for, by name, such as "edges" and "density" of
    distributions["pressure"]."""

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
    a_r_discretisation: float
    precision: str
    note: str | None = None
    observables: dict[str, float | None] = field(default_factory=dict)
    distributions: dict[str, dict[str, np.ndarray]] = field(default_factory=dict)


def solve(heights, pressure, E_star=1.0, physical_sizes=(1.0, 1.0), accuracy=None, observables=(), threads=1, distributions=(),
          **solver):
    """Press an elastic half-space of modulus E_star against rigid heights with a mean pressure.

    heights: (n_x, n_y), peaks up, in the unit of physical_sizes (m where these are texts such as "10 um"), or what
    hpc_gfmd.read_surface gives, which knows its sizes; pressure: in the unit of E_star; accuracy: wanted relative accuracy
    of a_r, gap_mean and pressure field (1e-3 where no residual is given instead); observables: names as in the scene's [output], such
    as "stiffness" or "patches"; threads: a whole number or "auto"; distributions: names, too, such as "pressure"; solver: further keys
    of the scene's [solver] (name, precision, residual, ...).
    All are checked as those of a scene are.
    Returns a Solution; warns (errors.NotConverged) if its status is not "converged". Raises SceneError for input that makes no sense.
    """
    doubts, free = (), (False, False)
    if isinstance(heights, PreparedSurface):
        if tuple(np.ravel(physical_sizes)) != (1.0, 1.0):
            raise SceneError(f"physical_sizes: found {physical_sizes} beside a surface that knows its sizes, allowed: "
                             "hpc_gfmd.read_surface(path, physical_sizes=...)")
        heights, physical_sizes, doubts, free = heights.heights, heights.sizes, heights.notes, heights.free
    given = {"residual": None, "accuracy": accuracy} | solver
    scene = ArrayScene.from_dict(
        {"surface": {"physical_sizes": _plain(physical_sizes)}, "material": {"E_star": _plain(E_star)},
         "load": {"pressure": [_plain(pressure)]}, "machine": {"threads": _plain(threads)},
         "output": {"observables": _plain(observables), "distributions": _plain(distributions)},
         "solver": {key: _plain(value) for key, value in given.items() if value is not None or key not in ("accuracy", "residual")}},
        "hpc_gfmd.solve")
    check_names(scene, solver_names(), observable_names(), (), distribution_names(scene.surface.free))
    heights, asked, comm = _checked(heights), scene.output.observables or (), SerialComm()
    sizes, threads = scene.surface.physical_sizes, threads_of(comm, scene.machine.threads)

    def make_surface(dtype):
        def rows(start, stop):
            return np.asarray(heights[start:stop], dtype=np.float64)

        return replace(surface_from_rows(heights.shape, sizes, rows, comm, dtype, threads, free), doubts=doubts)

    def pressed():
        sweep = Sweep(make_surface, scene.solver, scene.material.E_star, duality="duality_gap" in asked,
                      body=body_of(scene.material, free))
        return sweep.solve(sweep.pressures(scene.load)[0])

    step = sound(pressed)
    contact = step.contact
    if contact.outcome.status != "converged":
        errors = ", ".join(f"{error:.1e}" for error in contact.outcome.errors)
        warnings.warn(f"not converged ({contact.outcome.status}): estimated errors of area, mean gap, pressure: {errors}",
                      NotConverged, stacklevel=3)  # where the caller of hpc_gfmd.solve is
    observed = {name: f(contact) for name, f in observables_named(asked).items()}
    counted = distributions_named(scene.output.distributions, contact)
    a_r = contact.contact_points / contact.N
    return Solution(a_r, a_r / contact.p_star if contact.g_rms > 0 else float("nan"), contact.gap_mean,
                    *(np.asarray(contact.field(name)) for name in FIELDS), contact.outcome.status,
                    step.iterations, step.fft_pairs, contact.outcome.errors, contact.p_star, float(a_r_discretisation(contact)),
                    contact.g.dtype.name, contact.note, observed, counted)


def _checked(heights):
    """The array as it is. Raises SceneError for what is no complete height map."""
    if np.ma.is_masked(heights):
        raise SceneError("heights: found masked points, allowed: a complete height map")
    try:
        heights = np.asarray(heights)
    except (TypeError, ValueError) as error:
        raise SceneError(f"heights: found {one_line(str(error))}, allowed: a real array with two axes, not empty") from None
    if heights.ndim != 2 or heights.size == 0 or heights.dtype.kind not in "fiu":
        found = f"shape {heights.shape} of {one_line(str(heights.dtype), 80)}"
        raise SceneError(f"heights: found {found}, allowed: a real array with two axes, not empty")
    return heights


def _plain(value):
    """NumPy's numbers and arrays, alone or in a list, as those of Python, which a scene is made of."""
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
