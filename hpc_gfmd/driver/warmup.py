"""Compile every kernel on one rank, once per installation; the other ranks then find them in the
cache."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from ..bodies import body_of
from ..bodies.halfspace import HALF_SPACE
from ..contact import default_observables, observables_named
from ..contact.contact import Contact
from ..kernels.cache import on_first_compile, retry_without_cache
from ..operators.multilevel import Multilevel
from ..parallel.comm import Comm, SerialComm
from ..parallel.guard import collective_errors
from ..scene import Material, Scene, Solver
from ..surface import build_surface
from .precision import first_precision
from .sweep import Sweep

Observable = Callable[[Contact], Any]
TINY = {
    "kind": "self-affine",
    "hurst": 0.8,
    "L_over_lam_l": 1,
    "lam_l_over_lam_s": 8,
    "lam_s_over_a": 10,
    "seed": 1,
}


def compile_once(
    comm: Comm,
    settings: Solver,
    boundary: str | tuple[str, str] = "periodic",
    material: Material | None = None,
    observe: Iterable[Observable] | None = None,
    say: Callable[[str], object] | None = None,
) -> None:
    """Solve and evaluate a tiny contact with the same solver, precision, boundary and material,
    first on rank 0, then on the others.

    observe: the functions of a Contact that will be called; default: the observables that a result
    has where the scene names none. say: function of a text, called on rank 0 before something is
    compiled that has not been kept. Collective.
    """
    observe = observables_named(default_observables()).values() if observe is None else observe

    def solve() -> None:
        _tiny_contact(settings, boundary, material or Material(), observe)

    with collective_errors(comm, "compiling"):
        if comm.rank == 0:
            with on_first_compile(say):
                retry_without_cache(solve)
    with collective_errors(comm, "compiling"):
        if comm.rank != 0:
            retry_without_cache(solve)


def _tiny_contact(
    settings: Solver,
    boundary: str | tuple[str, str],
    material: Material,
    observe: Iterable[Observable],
) -> None:
    """Solve a tiny contact in every precision that the run may use."""
    scene = Scene.from_dict({"surface": TINY | {"boundary": boundary}, "load": {"p_star": 0.05}})
    first = "single" if first_precision(settings) == np.float32 else "double"
    for precision in {first, "double"} if settings.precision == "auto" else {first}:
        sweep = Sweep(
            lambda dtype: build_surface(scene.surface, SerialComm(), dtype),
            settings.model_copy(update={"max_iterations": 3, "precision": precision}),
            body=body_of(material, scene.surface.free),
            hardness=material.hardness and 1.0,
        )
        contact = sweep.solve(0.05)
        # a contact that is less accurate than asked may not have called it
        sweep.solver.expected_area(1.0)
        for function in observe:
            function(contact)
        grid, dtype = sweep.surface.grid, sweep.dtype
        # for the levels that only larger grids distribute
        Multilevel(grid, HALF_SPACE, dtype, grid.n[0], coarsest_points=0).sweep()
