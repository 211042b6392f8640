"""Compile every kernel on one rank, once per installation; the other ranks then find them in the cache."""


from ..parallel.comm import SerialComm
from ..scene import Scene
from ..surface import build_surface
from .sweep import Sweep

TINY = {"kind": "self-affine", "hurst": 0.8, "L_over_lam_l": 1, "lam_l_over_lam_s": 8, "lam_s_over_a": 5, "seed": 1}


def compile_once(comm, settings):
    """Solve a tiny contact with the same solver and precision on rank 0 while the others wait. Collective."""
    if comm.size == 1:
        return
    if comm.rank == 0:
        scene = Scene.from_dict({"surface": TINY, "load": {"p_star": 0.05},
                                 "solver": settings.model_dump(exclude_none=True) | {"max_iterations": 3}})
        sweep = Sweep(lambda dtype: build_surface(scene.surface, SerialComm(), dtype), scene.solver)
        sweep.solve(0.05)
    comm.barrier()


