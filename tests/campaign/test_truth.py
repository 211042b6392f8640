"""The truths of the campaign agree with dense linear algebra."""

from dataclasses import replace

import numpy as np
import oracle
import pytest
from campaign import families
from campaign.histories import Steps
from campaign.truth import Contact

WALLS = [
    "self_affine",
    "white_noise",
    "thin_pixels",
    "spike",
    "punch_square",
    "lattice",
    "minus_exponential",
    "pits",
    "tiny",
]
TOLERANCE = 1e-10


def small(name, index):
    """Return a part of a wall of at most 21 x 21 points, its size and its p*."""
    wall = families.make(name, 5, index)
    z = wall.heights[:21, :20]
    width = wall.physical_sizes[1] / wall.physical_sizes[0] * z.shape[1] / z.shape[0]
    return z, (1.0, width), wall.loads[0]


@pytest.mark.parametrize("name", WALLS)
def test_it_agrees_with_dense_linear_algebra(name):
    for index in range(4):
        z, sizes, p_star = small(name, index)
        if np.ptp(z) == 0:
            continue
        contact = Contact(z, sizes)
        truth = contact.solve(p_star)
        exact = oracle.solve(z, p_star * contact.g_rms, 1.0, sizes)
        assert truth.kkt < TOLERANCE
        points = round(exact.a_r * z.size)
        gap_mean = exact.gap_mean / contact.height_unit
        errors = truth.errors(points, gap_mean, exact.pressure / contact.g_rms)
        assert errors[0] == 0
        scale = max(truth.gap_mean, 1e-3 * contact.h.max())
        assert abs(gap_mean - truth.gap_mean) < TOLERANCE * scale
        assert errors[2] < TOLERANCE
        if index == 0:
            hardness = max(0.3 * truth.pressure.max(), 1.1 * p_star)
            hard = contact.solve(p_star, hardness=hardness)
            load = p_star * contact.g_rms
            limit = hardness * contact.g_rms
            exact = oracle.solve_yielding(z, load, limit, 1.0, sizes)
            assert max(hard.kkt, abs(hard.contact / z.size - exact.a_r)) < TOLERANCE
            assert np.abs(hard.pressure * contact.g_rms - exact.pressure).max() < TOLERANCE * limit


def test_steps_of_a_history_agree_with_dense_linear_algebra():
    """An element that relaxes, and dents."""
    wall = families.make("history_dents", 5, 1)
    z = np.random.default_rng(1).standard_normal((7, 9))
    steps = Steps(replace(wall, heights=z, physical_sizes=(1.0, 1.0), E_star=2.0), [(0.7, 2.0)])
    loads, times = [5.0, 3.0, 8.0], [0.0, 1.0, 2.0]
    history = list(oracle.solve_history(z, loads, times, (0.7, 2.0), 20.0, 2.0))
    for load, dt, (exact, _) in zip(loads, (0.0, 1.0, 1.0), history, strict=True):
        contact, truth, modulus = steps.solve(load, dt, 20.0)
        assert truth.gap * contact.height_unit == pytest.approx(exact.gap, abs=1e-9)
        pressure = truth.pressure * modulus * contact.g_rms
        assert pressure == pytest.approx(exact.pressure, abs=1e-8)
    _, dents = history[-1]
    assert dents.max() > 0


def test_errors_are_those_of_the_definition():
    contact = Contact(families.make("self_affine", 5, 0).heights, (1.0, 1.0))
    truth = contact.solve(0.05)
    area, gap, pressure = truth.errors(
        truth.contact + truth.ties_out + 3, 1.5 * truth.gap_mean, 0.75 * truth.pressure
    )
    assert area == pytest.approx(3 / truth.contact)
    assert gap == pytest.approx(0.5)
    assert pressure == pytest.approx(0.25)
    assert truth.errors(truth.contact, truth.gap_mean, np.full(contact.n, np.inf))[2] == np.inf


def test_the_start_does_not_matter():
    contact = Contact(families.make("ridges", 5, 1).heights, (1.0, 1.0))
    cold = contact.solve(0.1)
    warm = contact.solve(0.11, cold.pressure)
    again = contact.solve(0.11)
    assert warm.contact == again.contact
    assert np.abs(warm.pressure - again.pressure).max() < TOLERANCE * again.pressure.max()
    assert cold.contact < warm.contact


def test_a_pressure_that_is_no_solution_violates_the_conditions():
    contact = Contact(families.make("self_affine", 5, 0).heights, (1.0, 1.0))
    truth = contact.solve(0.05)
    p = contact.on_cell(truth.pressure)
    touching = p > 0
    gap = contact.times(contact.S, p) + contact.h
    gap = np.where(touching, 0, gap - gap[touching].mean())
    nothing_yields = np.zeros_like(touching)
    assert contact._violation(p, gap, touching, nothing_yields, 0.05) < TOLERANCE
    for wrong in (1.001 * p, np.where(p > 0.5 * p.max(), p, 0)):
        assert contact._violation(wrong, gap, touching, nothing_yields, 0.05) > 1e-4
