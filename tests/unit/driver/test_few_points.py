"""Light contacts on few points: the same answers as by iterations on the whole grid."""

import numpy as np
import pytest
from contacts import field, random_heights, relative, rough, sweep_of, sweep_over

import hpc_gfmd
from hpc_gfmd.bodies.coating import Coating
from hpc_gfmd.bodies.free import Free
from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.bodies.layer import Layer
from hpc_gfmd.driver import few_points as module
from hpc_gfmd.driver import starter
from hpc_gfmd.driver.few_points import FewPoints
from hpc_gfmd.operators.elastic import Elastic, reader
from hpc_gfmd.operators.influence import between, influence
from hpc_gfmd.parallel.grid import Grid

ACCURACY = 1e-6
EDGES = {"periodic": (False, False), "free": (True, True), "free along x": (True, False)}


@pytest.mark.parametrize(
    ("body", "n", "nominal"),
    [
        (HALF_SPACE, (12, 9), None),
        (HALF_SPACE, (16, 1), None),
        (Layer(0.1, 0.3, "bonded"), (9, 12), None),
        (Coating.examples()[0], (12, 12), None),
        (Free((True, True)), (96, 90), (30, 24)),
        (Free((False, True)), (12, 96), (12, 30)),
    ],
    ids=lambda value: getattr(value, "name", str(value)),
)
def test_the_matrix_is_the_response_to_each_point(body, n, nominal):
    """Up to a constant, which a given load does not see."""
    grid = Grid(n, (1.0, 1.3), nominal=nominal)
    i, j = (np.random.default_rng(1).integers(0, m, 8) for m in grid.nominal)
    matrix = between(grid, influence(grid, body, np.float64), i, j)
    elastic = Elastic(grid, body, np.float64)
    response = np.empty_like(matrix)
    for k in range(len(i)):
        unit = np.zeros(n)
        unit[i[k], j[k]] = 1.0
        u = np.empty(n)
        elastic.pressure_rows(reader(unit))
        elastic.columns(inverse=True)
        elastic.use_rows(lambda i0, i1, x, u=u: np.copyto(u[i0:i1], x[: i1 - i0]))
        response[:, k] = u[i, j]
    difference = matrix - response
    assert np.ptp(difference) < 2e-6 * np.ptp(response)


@pytest.fixture
def parts(monkeypatch):
    """The parts of few points that were solved, or None."""
    solved = []
    solve = FewPoints.solved

    def noted(problem, g):
        solved.append(solve(problem, g))
        return solved[-1]

    monkeypatch.setattr(FewPoints, "solved", noted)
    return solved


def compare(z, p, monkeypatch, free=(False, False), body=None):
    """Compare a contact on few points with that of iterations; return the former."""

    def solved():
        sweep = sweep_over(z, (1.0, 1.3), free=free, body=body, accuracy=ACCURACY)
        return sweep.solve(p)

    contact = solved()
    with monkeypatch.context() as patch:
        patch.setattr(module, "MOST", 0.0)
        iterated = solved()
    assert contact.status == iterated.status == "converged"
    assert iterated.iterations > 0
    for name in ("pressure", "gap"):
        assert relative(field(contact, name), field(iterated, name)) < 2 * ACCURACY
    assert contact.contact_points == iterated.contact_points
    assert contact.energy == pytest.approx(iterated.energy, rel=10 * ACCURACY, nan_ok=True)
    assert contact.gap_discretisation == pytest.approx(iterated.gap_discretisation, rel=1e-3)
    return contact


@pytest.mark.parametrize("edges", EDGES)
@pytest.mark.parametrize("n", [(96, 80), (33, 128)])
def test_few_points_give_the_contact_of_the_whole_grid(parts, monkeypatch, n, edges):
    contact = compare(random_heights(n, seed=3), 2e-2, monkeypatch, EDGES[edges])
    assert parts[0] is not None
    assert contact.iterations == 0
    assert contact.pairs < 6


@pytest.mark.parametrize("body", [Layer(0.05, 0.3, "bonded"), Coating.examples()[0]])
def test_few_points_on_layers(parts, monkeypatch, body):
    contact = compare(random_heights((64, 64), seed=2), 2e-2, monkeypatch, body=body)
    assert contact.iterations == 0


def test_a_profile(parts, monkeypatch):
    contact = compare(random_heights((400, 1), seed=5), 1e-2, monkeypatch)
    assert contact.iterations == 0


def test_points_that_penetrate_are_added(parts, monkeypatch):
    """The start knows nothing of the highest point."""
    z = random_heights((80, 80), seed=4)
    prolonged = starter.Nested.candidate

    def without_highest(*arguments, **keys):
        candidate = prolonged(*arguments, **keys)
        if candidate.gap.shape == z.shape:
            candidate.gap[np.unravel_index(z.argmax(), z.shape)] = 1.0
        return candidate

    monkeypatch.setattr(starter.Nested, "candidate", without_highest)
    contact = compare(z, 2e-2, monkeypatch)
    assert sum(part is not None for part in parts) == 2
    assert contact.iterations == 0


def test_equal_tops(monkeypatch):
    """Points that only just touch, all at once."""
    z = np.minimum(random_heights((64, 64), seed=6), 2.0)
    compare(z, 1e-3, monkeypatch)
    bumps = np.zeros((64, 64))
    bumps[::16, ::16] = 1.0
    compare(bumps, 1e-3, monkeypatch)


def test_a_set_that_does_not_settle_is_left_to_iterations(parts, monkeypatch):
    monkeypatch.setattr(module, "CHANGES", 1)
    contact = hpc_gfmd.solve(random_heights((64, 64)), 2e-2, boundary="periodic")
    assert parts == [None]
    assert contact.status == "converged"
    assert contact.iterations > 0


@pytest.mark.parametrize(
    "load",
    [
        {"pressure": 20.0},
        {"a_r": 2e-3},
        {"pressure": 2e-2, "hardness": 1e3},
        {"pressure": 2e-2, "nested": False},
    ],
)
def test_other_contacts_are_solved_on_the_whole_grid(parts, load):
    contact = hpc_gfmd.solve(random_heights((64, 64)), **load, boundary="periodic")
    assert contact.status == "converged"
    assert not any(parts)


def test_low_memory_does_without(parts):
    contact = sweep_of(rough((2, 32, 2)), accuracy=1e-3, low_memory=True).solve(1e-3)
    assert contact.status == "converged"
    assert not any(parts)


def test_near_loads(parts):
    """They start from the points of the load before."""
    sweep = sweep_over(random_heights((96, 80), seed=3), accuracy=ACCURACY)
    alone = sweep_over(random_heights((96, 80), seed=3), accuracy=ACCURACY)
    for load in (1e-2, 1.1e-2, 1.2e-2, 1.05e-2):
        contact = sweep.solve(load)
        assert contact.iterations == 0
        exact = alone.solve(load)
        alone.starter.forget()
        assert relative(field(contact, "pressure"), field(exact, "pressure")) < 1e-12
    assert contact.pairs == 1
    assert len(parts) == 8


def test_a_pressure_of_another_load_is_not_accepted(parts, monkeypatch):
    """One point in contact: its gap is 0 at any load, and so is every violation but the load's."""
    pressure = module._pressure
    monkeypatch.setattr(module, "_pressure", lambda *arguments: 1.1 * pressure(*arguments))
    contact = sweep_over(random_heights((64, 64)), accuracy=1e-3).solve(1e-5)
    assert contact.status == "converged"
    assert contact.contact_points == 1
    assert field(contact, "pressure").mean() == pytest.approx(1e-5, rel=1e-3)
