"""Shortcuts for tests: surfaces, scenes and sweeps from a few keys, and comparisons of fields."""

import numpy as np
import tomli_w

import hpc_gfmd
from hpc_gfmd.bodies import body_of
from hpc_gfmd.driver.contact_model import ContactModel
from hpc_gfmd.driver.load import Load
from hpc_gfmd.driver.nested import cold_gap
from hpc_gfmd.driver.sweep import Sweep
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.runs import loads
from hpc_gfmd.scene import File, Material, Scene, SolverTable
from hpc_gfmd.solvers import solver_class
from hpc_gfmd.surface import build_surface
from hpc_gfmd.surface.build import surface_of
from hpc_gfmd.surface.topography import Topography, open_topography

EXACT = {"residual": 1e-11, "precision": "double"}
WAVE = {"kind": "wave", "amplitude": 0.1, "n": [8, 8]}
WAVE_SCENE = tomli_w.dumps({"surface": WAVE, "load": {"pressure": 0.1}})  # solved at once


def rough(n_over=(2, 16, 2), hurst=0.8, seed=1, **keys):
    """The [surface] table of a self-affine wall; n_over: (L/lam_l, lam_l/lam_s, lam_s/a)."""
    names = ("L_over_lam_l", "lam_l_over_lam_s", "lam_s_over_a")
    return (
        {"kind": "self-affine", "hurst": hurst, "seed": seed}
        | dict(zip(names, n_over, strict=True))
        | keys
    )


def rough_wall(n_over=(2, 16, 2), **keys):
    """The surface of `rough`, made."""
    return hpc_gfmd.make_surface(**rough(n_over, **keys))


def scene_text(n_over=(2, 8, 2), p_star=(0.05, 0.1), **tables):
    """The scene file of a self-affine wall; tables: further tables, and the title."""
    return tomli_w.dumps({"surface": rough(n_over), "load": {"p_star": list(p_star)}, **tables})


class Pressing:
    """A Sweep whose `solve` also accepts a mean pressure instead of a Load."""

    def __init__(self, sweep):
        self.sweep = sweep

    def solve(self, load, *args, **options):
        load = load if isinstance(load, Load) else Load("pressure", float(load))
        return self.sweep.solve(load, *args, **options)

    def __getattr__(self, name):
        return getattr(self.sweep, name)


def sweep_of(surface, E_star=1.0, comm=None, duality=False, layer=None, **solver):
    """A Pressing of a [surface] table.

    Parameters
    ----------
    surface : dict
        Keys of [surface].
    E_star : float
    comm
        Communicator; this process alone by default.
    duality : bool
        Whether certificates have a duality gap.
    layer : dict
        Further keys of [material].
    **solver
        Keys of [solver]; EXACT by default.
    """
    scene = Scene.from_dict(
        {
            "surface": surface,
            # not light: single precision first, where that is enough
            "load": {"pressure": 1e3 * E_star},
            "material": {"E_star": E_star} | (layer or {}),
            "solver": solver or EXACT,
            "output": {"observables": ["duality_gap"]} if duality else {},
        }
    )
    made = loads.sweep_of(
        scene,
        lambda dtype: build_surface(
            scene.surface, comm or SerialComm(), dtype, low_memory=scene.solver.low_memory
        ),
    )
    return Pressing(made)


def surface_over(z, sizes=(1.0, 1.0), dtype=np.float64, comm=None, free=(False, False)):
    """The Surface of an array of heights z (peaks up)."""
    topography = Topography(z.shape, sizes, lambda a, b: z[a:b])
    return surface_of(topography, comm or SerialComm(), dtype, 1, free)


def sweep_over(
    z, sizes=(1.0, 1.0), free=(False, False), body=None, comm=None, E_star=1.0, **solver
):
    """A Pressing of an array of heights.

    Parameters
    ----------
    z : array (n_x, n_y)
        Heights, peaks up.
    sizes
        Of the surface.
    free : (bool, bool)
        Whether edges along x, along y are free.
    body
        Elastic body; a half-space by default.
    comm
        Communicator; this process alone by default.
    E_star : float
    **solver
        Keys of [solver]; EXACT by default.
    """
    made = Sweep(
        lambda dtype: surface_over(z, sizes, dtype, comm, free),
        SolverTable(**solver or EXACT),
        ContactModel(E_star, body or body_of(Material(), free)),
    )
    return Pressing(made)


def solve_scene(surface, p_star, E_star=1.0, comm=None, **solver):
    """The contact of a [surface] table at one load p*; solver: keys of [solver]."""
    sweep = sweep_of(surface, E_star, comm, **solver)
    return sweep.solve(p_star * E_star * sweep.surface.g_rms)


def started_cold(name, problem, options=()):
    """The solver `name` at its start without any knowledge."""
    solver = solver_class(name)(problem, dict(options))
    solver.start(cold_gap(problem))
    return solver


def field(step, name):
    """A copy of a field of a solved load, which the next load does not overwrite."""
    return np.array(step.field(name))


def heights_of(surface):
    """Heights (peaks up) of a [surface] table, in the units of the scene."""
    made = sweep_of(surface).surface
    return -made.h * made.height_unit


def opened(path, **keys):
    """The Topography of a height map; keys: of [surface]."""
    return open_topography(File(kind="file", path=str(path), **keys))


def random_heights(n, seed=0, correlated=True):
    """Random heights of order one, slightly smoothed so that patches have several points."""
    z = np.random.default_rng(seed).standard_normal(n)
    if correlated:
        for axis in (0, 1):
            if n[axis] > 4:
                z = z + 0.5 * (np.roll(z, 1, axis) + np.roll(z, -1, axis))
    return z


def wave_numbers(n, sizes=(1.0, 1.0)):
    """|q| of the modes of a discrete Fourier transform."""
    q_x, q_y = (2 * np.pi * np.fft.fftfreq(k, L / k) for k, L in zip(n, sizes, strict=True))
    return np.hypot(q_x[:, None], q_y)


def relative(field_values, wanted):
    """Relative L2 distance of a field from the wanted one."""
    return np.linalg.norm(np.asarray(field_values, float) - wanted) / np.linalg.norm(wanted)


def order(n, errors):
    """The order of convergence: slope of log error over log 1/n."""
    return -np.polyfit(np.log(n), np.log(errors), 1)[0]
