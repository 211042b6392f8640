"""Steps of the solver with an attraction never raise the energy."""

import adhesive
import numpy as np
import pytest
from contacts import wave_numbers

from hpc_gfmd.laws import law_named, law_names
from hpc_gfmd.operators.problem import Problem
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.solvers.bpx import Bpx


def elastic_pressure(problem, g):
    """Return K u, the pressure of the body beyond its mean."""
    K = wave_numbers(problem.grid.n, problem.grid.n) / 2
    return np.fft.ifft2(K * np.fft.fft2(g - problem.heights)).real


def elastic_product(problem, g):
    """Return the mean of u K u."""
    return np.mean((g - problem.heights) * elastic_pressure(problem, g))


def energy(problem, g):
    """Return the mean energy of a gap, including a spring that is relaxed at no displacement."""
    u = g - problem.heights
    elastic = 0.5 * elastic_product(problem, g)
    spring = 0.5 * problem.spring * u.mean() ** 2
    return elastic + spring + problem.p0 * g.mean() + problem.attraction.energy(g).mean()


@pytest.mark.parametrize("law", law_names())
@pytest.mark.parametrize("kappa", [0.1, 1.0, 3.0, 30.0])
@pytest.mark.parametrize(("closed", "spring"), [(False, 0.0), (True, 0.0), (True, 0.3)])
def test_the_energy_never_rises(law, kappa, closed, spring):
    wall = adhesive.wall(8, 4)
    a = 1 / 8
    table = adhesive.attraction(kappa, 0.05)
    attraction = law_named(law, table["work"] / a, table["range"] / a)
    h = (wall.heights.max() - wall.heights) / a
    problem = Problem(Grid(h.shape, (8.0, 8.0)), h, 0.05, attraction=attraction, spring=spring)
    solver = Bpx(problem)
    solver.state.p0 -= spring * h.mean() * closed  # the mean displacement at the start
    solver.start(np.zeros_like(h) if closed else np.maximum(h - h.mean() + h.std(), 0))
    energies = [energy(problem, solver.state.g)]
    for _ in range(150):
        solver.step()
        energies.append(energy(problem, solver.state.g))
        if solver.progress().residual < 1e-8:
            break
    assert np.diff(energies).max() <= 1e-12 * abs(energies[0])
    assert energies[-1] < energies[0] or solver.progress().residual < 1e-8
    state = solver.state
    load = 0.05 + spring * (state.g - h).mean()
    assert state.p0 == pytest.approx(load)
    assert state.wall_load == pytest.approx(load + attraction.traction(state.g).mean())
    product = elastic_product(problem, state.g) * solver.N
    assert state.uKu == pytest.approx(product, rel=1e-6)


@pytest.mark.parametrize("law", law_names())
def test_a_lifted_body_is_lowered_onto_the_wall(law):
    """Its whole gap shrinks until the highest point touches, which costs no elastic energy, and its
    pressure follows the stronger attraction there."""
    wall = adhesive.wall(8, 4)
    a = 1 / 8
    table = adhesive.attraction(1.0, 0.05)
    attraction = law_named(law, table["work"] / a, table["range"] / a)
    h = (wall.heights.max() - wall.heights) / a
    problem = Problem(Grid(h.shape, (8.0, 8.0)), h, 0.05, attraction=attraction)
    solver = Bpx(problem)
    lift = 0.1 * attraction.range
    solver.start(h + lift)
    before = energy(problem, solver.state.g)
    solver.wall.lower(solver.state)
    g = solver.state.g
    assert g == pytest.approx(h, abs=1e-12 * h.max())
    gained = problem.p0 * lift + np.mean(attraction.energy(h + lift) - attraction.energy(h))
    assert before - energy(problem, g) == pytest.approx(gained)
    expected = problem.p0 + elastic_pressure(problem, g) + attraction.traction(g)
    assert solver.state.p == pytest.approx(expected, abs=1e-9 * expected.max())
    assert solver.state.attracted == pytest.approx(attraction.traction(g).sum())
