"""Several threads per rank give the results of one to the bit, also where coarse grids and levels
are on fewer ranks."""

import numpy as np
import pytest
from contacts import field, rough

from hpc_gfmd.contact import all_observables
from hpc_gfmd.driver import decimation
from hpc_gfmd.operators import hierarchy
from hpc_gfmd.parallel import layout
from hpc_gfmd.parallel import threads as pieces
from hpc_gfmd.runs.loads import sweep_of
from hpc_gfmd.scene import Scene
from hpc_gfmd.solvers import solver_names
from hpc_gfmd.surface import build_surface

pytestmark = pytest.mark.mpi
CASES = {
    "single": (
        rough((2, 16, 4)),
        {"p_star": [0.05, 0.3]},
        {"accuracy": 1e-3, "precision": "single"},
    ),
    "odd": (
        rough((1, 31, 3.0), physical_sizes=[1.0, 2.0]),
        {"p_star": [0.1]},
        {"residual": 1e-10, "precision": "double"},
    ),
    "free": (rough(boundary="free"), {"p_star": [0.05]}, {"accuracy": 1e-3}),
    "free, one axis": (rough(boundary=["free", "periodic"]), {"force": [0.02]}, {"accuracy": 1e-3}),
    "prescribed gap": (rough(), {"gap_over_h_rms": [1.0, 0.5]}, {"accuracy": 1e-3}),
    "prescribed area": (rough(), {"a_r": [0.1]}, {"accuracy": 1e-3}),
    "single, then double": (rough(), {"p_star": [0.05, 0.06, 0.4]}, {"accuracy": 1e-3}),
    "low memory": (
        rough((2, 32, 4)),
        {"p_star": [0.05, 0.06, 0.4]},
        {"accuracy": 1e-3, "precision": "single", "low_memory": True},
    ),
    **{
        name: (
            rough(seed=2),
            {"p_star": [0.03, 0.2]},
            {"name": name, "residual": 1e-9, "precision": "double"},
        )
        for name in solver_names()
    },
}
WITHOUT_GRIDS = ("low memory",)  # coarse grids are not kept


@pytest.fixture
def small(monkeypatch):
    """Lower the limits, so that small grids have several passes and blocks, and levels and grids
    on some ranks only."""
    for module, name, value in (
        (hierarchy, "COARSEST_POINTS", 64),
        (hierarchy, "UNGATHERED_POINTS", 64),
        (hierarchy, "FEWEST_ROWS", 4),
        (pieces, "PIECE_POINTS", 2**9),
        (decimation, "RANK_POINTS", 1024),
        (decimation, "COARSEST", 8),
        (layout, "ROW_BYTES", 2**12),
        (layout, "COLUMN_BYTES", 2**12),
    ):
        monkeypatch.setattr(module, name, value)


def solve(comm, case, threads):
    """Return all numbers and fields of every load, and the smallest number of ranks of a grid."""
    surface, load, solver = CASES[case]
    scene = Scene.from_dict(
        {"surface": surface, "load": load, "solver": solver, "machine": {"threads": threads}}
    )
    sweep = sweep_of(
        scene,
        lambda dtype: build_surface(scene.surface, comm, dtype, threads, scene.solver.low_memory),
    )
    steps = []
    for load in sweep.loads(scene.load):
        step = sweep.solve(load)
        assert step.status == "converged"
        fft = step.surface.grid.fft(step.g.dtype)
        assert len(fft.rows) == threads
        assert min(len(fft.passes()), fft.blocks_per_rank) > 1
        numbers = {name: f(step) for name, f in all_observables().items()}
        steps.append((numbers, [field(step, name) for name in ("pressure", "gap")]))
    grids = [] if case in WITHOUT_GRIDS else sweep.working.nested().grids
    return steps, min((grid.comm.size for grid in grids), default=0)


@pytest.mark.parametrize("case", CASES)
def test_same_with_threads(comm, case, small):
    if comm.size > 2:  # nothing new, and too many threads for a small machine
        return
    (on_one_thread, fewest_ranks), (on_several, _) = (
        solve(comm, case, threads) for threads in (1, 4 - comm.size)
    )
    # rank 0 is alone with the coarsest grid
    assert comm.rank > 0 or fewest_ranks == (case not in WITHOUT_GRIDS)
    for (numbers, fields), (threaded_numbers, threaded_fields) in zip(
        on_one_thread, on_several, strict=True
    ):
        assert threaded_numbers == numbers
        for one_thread_field, threaded_field in zip(fields, threaded_fields, strict=True):
            assert np.array_equal(threaded_field, one_thread_field)
