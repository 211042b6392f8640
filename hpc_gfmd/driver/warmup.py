"""Compile the kernels of a scene on one rank, once per installation, while others wait asleep.

A tiny contact with the body, hardness, attraction and precision of the scene calls every kernel
that its loads will call. The other ranks then find the code in the cache (kernels/cache.py).
"""

from collections.abc import Callable

import numpy as np

from ..bodies import body_of
from ..bodies.halfspace import HALF_SPACE
from ..certificate.error_estimates import Estimate
from ..contact.contact import Contact
from ..kernels.cache import on_first_compile
from ..laws import law_named
from ..laws.base import Law
from ..operators.multilevel import Multilevel
from ..parallel.comm import Comm, SerialComm
from ..parallel.guard import collective_errors
from ..scene import Material, Scene
from ..surface import build_surface
from .contact_model import ContactModel
from .load import Load
from .precision_forecast import first_of_scene
from .sweep import Sweep

TINY_ATTRACTION = 1e-3, 0.1  # work and range
TINY = {  # 128 x 128 points, from which on M has a gap mode
    "kind": "self-affine",
    "hurst": 0.8,
    "L_over_lam_l": 1,
    "lam_l_over_lam_s": 8,
    "lam_s_over_a": 16,
    "seed": 1,
}


def compile_once(
    comm: Comm,
    scene: Scene,
    observe: Callable[[Contact], object],
    say: Callable[[str], object] | None = None,
) -> None:
    """Compile the kernels of a scene by a tiny contact on rank 0; others load them, or compile, one
    a machine, where they do not see the cache. Collective. observe(contact): observables;
    say(text): on rank 0.
    """

    def solve() -> None:
        _tiny_contact(scene, observe, on_ranks=comm.size > 1)

    # ranks of a machine without the cache of rank 0 have another one in common
    leads_machine = comm.machine.rank == 0  # collective: on every rank
    my_turn = 0 if comm.rank == 0 else 1 if leads_machine else 2
    for turn in range(3):
        with collective_errors(comm, "compiling"):
            if turn == my_turn:
                with on_first_compile(say if turn == 0 else None):
                    solve()


def _tiny_attraction(material: Material) -> Law | None:
    """Return a weak attraction by the material's law; None without adhesion."""
    adhesion = material.adhesion
    return None if adhesion is None else law_named(adhesion.law, *TINY_ATTRACTION)


def _tiny_contact(scene: Scene, observe: Callable[[Contact], object], on_ranks: bool) -> None:
    """Solve a tiny contact of 3 iterations on this rank, and observe it; on_ranks: levels as over
    ranks, and double, too, if a load may need it.
    """
    settings = scene.solver
    material = scene.material
    sides = ["free" if ends else "periodic" for ends in scene.surface.free]
    surface = TINY | {"boundary": sides}
    tiny = Scene.from_dict({"surface": surface, "load": {"p_star": 0.05}}).surface
    usual = "single" if first_of_scene(scene) == np.float32 else "double"
    model = ContactModel(
        body=body_of(material, tiny.free),
        hardness=material.hardness and 1.0,
        attraction=_tiny_attraction(material),
    )
    may_need_double = on_ranks and settings.precision == "auto"
    for precision in {usual, "double"} if may_need_double else {usual}:
        sweep = Sweep(
            lambda dtype: build_surface(tiny, SerialComm(), dtype),
            settings.model_copy(update={"max_iterations": 3, "precision": precision}),
            model,
        )
        contact = sweep.solve(Load("pressure", 0.05))
        # a contact that is less accurate than asked may not have called it
        solver = sweep.starter.solver
        if solver is not None:
            solver.expected_area(Estimate(squares=1.0))
        observe(contact)
        if solver is not None and solver.goes_ahead:
            solver.step_ahead()
        if on_ranks:  # for the levels that only larger grids distribute
            grid = sweep.surface.grid
            Multilevel(grid, HALF_SPACE, sweep.dtype, grid.n[0], coarsest_points=0).sweep()
