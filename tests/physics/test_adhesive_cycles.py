"""Cycles of adhesion: each load comes from the state before, on the branch of its direction."""

import adhesive
import numpy as np
import pytest
from oracle import solve as exact_contact
from refusal import refused

import hpc_gfmd

STICKY = adhesive.attraction(1.0, 0.1)


def solve(surface, loads, adhesion, **how):
    how = {"history": True, "fields": ()} | how
    return hpc_gfmd.solve(surface, loads, adhesion=adhesion, **how)


def test_descent_from_the_state_before():
    """On 24 x 24 points, with an inner loop, and up again once the bodies have come apart.

    Up it is the branch of approach, down that of retraction.
    """
    surface = adhesive.wall(6, 2, 1)
    h = surface.heights.max() - surface.heights
    adhesion = adhesive.attraction(2.0, 0.1)
    up = [0.02, 0.05, 0.1, 0.2, 0.3]
    loads = [*up, 0.2, 0.1, 0.05, 0.1, 0.05, 0.02, -0.2, 0.02, 0.05]
    cycle = solve(surface, loads, adhesion, residual=1e-8, fields=["gap"])
    apart = 11
    g = touching = exact_contact(surface.heights, loads[0], sizes=surface.sizes).gap
    for k, (load, solution) in enumerate(zip(loads, cycle, strict=True)):
        if k == apart:
            assert solution.status == "separated"
            g = touching
            continue
        g = adhesive.minimum_near(g, adhesive.energy_of(surface, adhesion, load))
        assert solution.status == "converged"
        assert np.abs(solution.gap - g).max() < 1e-6 * h.max()
        assert solution.a_r == np.mean(g <= 0)
    areas = np.array([solution.a_r for solution in cycle])
    assert areas[6] > 1.005 * areas[2]  # at 0.1, down and up
    assert areas[2] <= areas[8] <= areas[6]  # the inner loop
    assert areas[12:] == pytest.approx(areas[:2])
    how = {"adhesion": adhesion, "residual": 1e-8, "fields": ()}
    assert hpc_gfmd.solve(surface, up, **how).a_r == pytest.approx(areas[:5])
    down = hpc_gfmd.solve(surface, [0.3, 0.2, 0.1, 0.05], branch="retraction", **how)
    assert down.a_r == pytest.approx(areas[4:8])


def test_a_ball_that_comes_off_and_comes_back():
    """At one pull it is held or apart; without load it has the contact of the first time."""
    ball, adhesion, jkr = adhesive.ball(128)
    forces = np.pi * jkr.w * np.array([0.0, -1.2, -1.5, -1.2, 0.0, -1.2, -1.8, -1.2, 0.0, -1.2])
    cycle = solve(ball, None, adhesion, force=forces.tolist())
    statuses = [step["status"] for step in cycle.steps]
    assert statuses == ["converged"] * 6 + ["separated"] * 2 + ["converged"] * 2
    held = np.array([x for x, status in zip(cycle.a_r, statuses) if status == "converged"])
    assert held[[3, 5, 7]] == pytest.approx(held[1], rel=5e-3)
    assert held[[4, 6]] == pytest.approx(held[0], rel=5e-3)
    assert np.sqrt(held[0] / np.pi) == pytest.approx(jkr.radius(0.0), rel=0.1)
    assert cycle.pull_off == pytest.approx(forces[5])


def test_a_prescribed_gap_and_approach():
    """Apart they stay apart until undeformed bodies touch."""
    wave, _ = adhesive.wave(0.08, 128)
    gaps = [0.4, 0.9, 1.2, 0.9, 1.5, 1.2, 0.9]
    cycle = hpc_gfmd.solve(**wave, gap_mean=gaps, history=True)
    assert [step["status"] for step in cycle.steps] == [
        *["converged"] * 4,
        *["separated"] * 2,
        "converged",
    ]
    assert cycle.p[[3, 6]] == pytest.approx(cycle.p[1], rel=2e-2)
    assert cycle.p[2] < cycle.p[1] < 0


REFUSED = [
    ({"branch": "retraction"}, 'load.branch: found "retraction" with load.history'),
    ({"unique": True}, "load.unique: found true with load.history"),
    ({"fields": ["dent"]}, "output.fields: .* material.hardness"),
    ({"relaxation": [(0.5, 1.0)], "time": [0.0]}, "material.relaxation: .* material.adhesion"),
    ({"pull_off_error": 0.01}, 'pull_off_error: .* branch = "retraction"'),
]


def test_refused():
    for keys, words in REFUSED:
        with refused(words):
            solve(adhesive.wall(4, 4), [0.1], STICKY, **keys)
