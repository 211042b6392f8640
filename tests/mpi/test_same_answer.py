"""Areas, gaps, pressures, surfaces and files do not depend on the number of ranks."""

from functools import partial
from math import inf

import numpy as np
import pytest
from contacts import random_heights, rough, sweep_of, sweep_over
from mpi.same import Alone, assert_same, assert_same_fields, compare, save, solve_twice, sweeps

import hpc_gfmd
from hpc_gfmd.certificate.error_estimates import Estimate
from hpc_gfmd.certificate.misclassified import misclassified_points
from hpc_gfmd.driver import box, decimation
from hpc_gfmd.driver.load import Load
from hpc_gfmd.operators.problem import Problem
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.solvers import solver_names
from hpc_gfmd.surface import topography

pytestmark = pytest.mark.mpi


@pytest.mark.parametrize(
    "n", [(3, 16), (5, 12), (7, 11), (2, 40), (40, 2), (40, 3), (67, 71), (130, 128)]
)
def test_any_grid(comm, n):
    """Grids with ranks without rows or columns, odd and prime sizes, a rectangular cell."""
    z = random_heights(n, seed=4)
    sweep = sweep_over(z, (1.0, 1.3), comm=comm)
    alone = Alone(comm, lambda: sweep_over(z, (1.0, 1.3)))
    assert_same(comm, *[each.solve(0.1 * each.surface.g_rms) for each in (sweep, alone)])


@pytest.mark.parametrize(
    ("quantity", "value", "low_memory", "hardness"),
    [
        ("gap_mean", 0.02, False, None),
        ("a_r", 0.3, True, None),
        ("a_r", 0.3, True, 0.5),
        ("approach", 0.05, False, 0.5),
    ],
)
def test_prescribed(comm, quantity, value, low_memory, hardness):
    """The search for a load takes the same steps on any number of ranks."""
    surface = rough(
        (2, 16, 2), boundary="free" if quantity == "approach" else "periodic", h_rms=0.05
    )
    solver = {"accuracy": 1e-3, "precision": "double", "low_memory": low_memory}
    pair = sweeps(comm, surface, layer={"hardness": hardness}, **solver)
    for factor in (1.0, 0.8):
        steps = [sweep.solve(Load(quantity, factor * value)) for sweep in pair]
        assert steps[0].p_mean == pytest.approx(steps[1].p_mean, rel=1e-6)
        assert_same(comm, *steps, tolerance=1e-5)


@pytest.mark.parametrize("centre", [(0.0, 0.0), (0.5, -0.3)])
def test_a_light_contact_in_a_box(comm, centre, monkeypatch):
    """The box is on the ranks of a coarser grid; its rows come from those of the surface."""
    monkeypatch.setattr(box, "SMALLEST", 0)
    monkeypatch.setattr(decimation, "RANK_POINTS", 2**8)
    x, y = ((np.arange(300) / 299 - 0.5 - c)[:, None] for c in centre)
    z = -(x**2 + y.T**2) / 2
    make = partial(sweep_over, z, free=(True, True), accuracy=1e-6)
    contact = make(comm=comm).solve(3e-5)
    assert contact.iterations == 0
    assert_same(comm, contact, Alone(comm, make).solve(3e-5), tolerance=1e-5)


@pytest.mark.parametrize("n", [(96, 80), (3, 200), (64, 64)])
@pytest.mark.parametrize("free", [False, True])
def test_a_light_contact_on_few_points(comm, n, free):
    """Rank 0 solves for all; some ranks have none of the points, or no rows."""
    z = random_heights(n, seed=3)
    make = partial(sweep_over, z, free=(free, free), accuracy=1e-3)
    contact = make(comm=comm).solve(1e-2)
    assert contact.iterations == 0
    assert_same(comm, contact, Alone(comm, make).solve(1e-2), tolerance=1e-10)


with_edges = pytest.mark.parametrize(
    "boundary", ["free", ["free", "periodic"], ["periodic", "free"]]
)


def test_dents_that_stay(comm):
    """Also after an unloaded step, and on walls that vary along one axis only."""
    ridges = hpc_gfmd.make_surface("wave", n=[16, 12], periods=[2, 0], amplitude=0.05)
    for wall in (hpc_gfmd.make_surface(**rough((2, 16, 2))), ridges):
        how = {"hardness": 0.4, "history": True, "residual": 1e-11, "precision": "double"}
        how |= {"fields": ["pressure", "gap", "dent"]}
        loads = [0.1, 0.02, 0.0, 0.15]
        spread, alone = solve_twice(comm, wall, loads, **how)
        for mine, whole in zip(spread, alone, strict=True):
            assert_same_fields(mine, whole, ["pressure", "gap", "dent"], 1e-10)
            assert mine.value("dissipated_work") == pytest.approx(
                whole.value("dissipated_work"), rel=1e-10
            )


@with_edges
def test_a_gap_that_closes(comm, boundary):
    pair = sweeps(comm, rough(boundary=boundary), accuracy=1e-6)
    steps = [sweep.solve(Load("a_r", 1.0)) for sweep in pair]
    assert steps[0].contact_points == steps[0].N
    assert steps[0].p_mean == pytest.approx(steps[1].p_mean, rel=1e-6)
    assert_same(comm, *steps, tolerance=1e-5)


@with_edges
@pytest.mark.parametrize(
    "surface",
    [
        rough(),
        rough((1, 31, 2.0), seed=3, radius=3.0),
        {"kind": "sphere", "radius": 3.0, "n": [5, 33]},
    ],
)
def test_free_edges(comm, surface, boundary):
    """Some ranks have only points outside of the surface, or only a few rows of it."""
    if "radius" in surface:
        sides = boundary if isinstance(boundary, list) else [boundary] * 2
        surface = surface | {"radius": [3.0 if side == "free" else inf for side in sides]}
    compare(comm, surface | {"boundary": boundary}, 0.1)


@pytest.mark.parametrize(
    "solver",
    [{"precision": "single"}, {"precision": "single", "low_memory": True}, {"nested": False}],
)
def test_solver_settings_with_free_edges(comm, solver):
    # large enough for coarse grids that are spread over the ranks
    pair = sweeps(comm, rough((2, 32, 4), boundary="free"), accuracy=1e-3, **solver)
    on_ranks, alone = (sweep.solve(0.1) for sweep in pair)
    assert on_ranks.status == "converged"
    assert on_ranks.contact_points == pytest.approx(alone.contact_points, rel=1e-3)
    assert on_ranks.gap_mean == pytest.approx(alone.gap_mean, rel=1e-3)
    assert on_ranks.approach == pytest.approx(alone.approach, rel=1e-4)


@pytest.mark.parametrize("name", solver_names())
def test_every_solver(comm, name):
    compare(comm, rough((1, 16, 2), seed=2), 0.1, 1e-8, name=name, residual=1e-8)


@pytest.mark.parametrize(
    "surface",
    [
        {"kind": "wave", "amplitude": 0.1, "n": [48, 30]},
        {"kind": "wave", "amplitude": 0.1, "n": [30, 48], "periods": [0, 2]},
        {"kind": "sphere", "radius": 1.0, "n": [33, 32]},
        {"kind": "wave", "amplitude": 0.0, "n": [9, 8]},
    ],
)
def test_analytic_surfaces(comm, surface):
    compare(comm, surface, 0.01)


def test_height_map_is_read_slab_by_slab(comm, monkeypatch):
    save(comm, z=random_heights((300, 8)))
    rows_read = []
    monkeypatch.setattr(
        topography,
        "require_finite",
        lambda z, start, *_, **__: rows_read.append((start, start + len(z))),
    )
    table = {"kind": "file", "path": "z.npy", "physical_sizes": [1, 1]}
    surface = sweep_of(table, comm=comm).surface
    assert rows_read[-1][1] == surface.rows[1]
    assert max(stop - start for start, stop in rows_read) <= 66  # with neighbours


def test_a_contact_that_slips_as_a_whole(comm):
    """Its shift is that of all since the first touch, with the heights of all ranks."""
    z = np.add.outer(np.linspace(0, 0.3, 16), random_heights((16, 12), seed=3)[0])
    path = hpc_gfmd.slip(0.5, 0.1, [0.02, 0.05])
    keys = {"boundary": "periodic", "accuracy": 1e-6}
    of_ranks = path.of(hpc_gfmd.solve(z, path.loads, comm=comm.mpi, **keys))
    solutions = hpc_gfmd.solve(z, path.loads, **keys)
    alone = path.of(solutions)
    assert of_ranks.shift == pytest.approx(alone.shift, rel=1e-5)
    assert of_ranks.slip_area == pytest.approx(alone.slip_area)
    fallen = (z.max() - z).mean() - solutions[-1].gap_mean
    assert of_ranks.shift[-1] == pytest.approx(0.5 * fallen, rel=1e-5)


@pytest.mark.parametrize("side", [7, 17])
def test_uncertain_points_of_slabs(comm, side):
    """The same points are uncertain whatever the slabs."""
    n = (2 * side, 2 * side)
    x, y = np.divmod(np.arange(n[0] * n[1]).reshape(n), n[1])
    g = np.where((x < side) == (y < side), 0.0, 3.0)
    p = np.where(g > 0, 0.0, np.random.default_rng(1).uniform(0.5, 1.5, n))
    results = []
    for world in (comm, SerialComm()):
        grid = Grid(n, (1.0, 1.0), world)
        mine = slice(*grid.rows)
        results.append(
            misclassified_points(
                Problem(grid, g[mine], 0.1),
                g[mine],
                p[mine],
                Estimate(squares=float(side**2)),
                float(side**2),
                float(np.sum(g <= 0)),
            )
        )
    assert results[0] == results[1] > 0
