"""Cycles of adhesion: each load comes from the state before, on the branch of its direction."""

import adhesive
import numpy as np
import pytest
from adhesive_forms import JohnsonKendallRoberts
from oracle import solve as exact_contact
from refusal import refused
from scipy.optimize import minimize

import hpc_gfmd
from hpc_gfmd.laws import law_named

STICKY = adhesive.attraction(1.0, 0.1)


def solve(surface, loads, adhesion, **how):
    how = {"history": True, "fields": ()} | how
    return hpc_gfmd.solve(surface, loads, adhesion=adhesion, **how)


def minimum_near(g, h, load, phi, size):
    """The gap of the nearest minimum of the energy that descent from a gap comes to."""
    q_x, q_y = (2 * np.pi * np.fft.fftfreq(n, size / n) for n in h.shape)
    K = np.hypot(q_x[:, None], q_y) / 2

    def energy(flat):
        gap = flat.reshape(h.shape)
        w = np.fft.ifft2(K * np.fft.fft2(gap - h)).real
        total = 0.5 * np.sum((gap - h) * w) + load * np.sum(gap) + np.sum(phi.energy(gap))
        return total, (w + load + phi.traction(gap)).ravel()

    options = {"maxiter": 20000, "maxfun": 40000, "ftol": 1e-16, "gtol": 1e-11, "maxcor": 30}
    best = minimize(
        energy, g.ravel(), jac=True, method="L-BFGS-B", bounds=[(0, None)] * g.size, options=options
    )
    return best.x.reshape(h.shape)


def test_descent_from_the_state_before():
    """On 24 x 24 points, with an inner loop, and up again once the bodies have come apart.

    Up it is the branch of approach, down that of retraction.
    """
    surface = adhesive.wall(6, 2, 1)
    h = surface.heights.max() - surface.heights
    adhesion = adhesive.attraction(2.0, 0.1)
    phi = law_named("exponential", adhesion["work"], adhesion["range"])
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
        g = minimum_near(g, h, load, phi, surface.sizes[0])
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
    w = 0.12**3 * 2 / (9 * np.pi)
    jkr = JohnsonKendallRoberts(1.0, w)
    ball = hpc_gfmd.make_surface(
        "sphere", radius=1.0, n=(128, 128), physical_sizes=(1.0, 1.0), boundary="free"
    )
    forces = np.array([0.0, -1.2, -1.5, -1.2, 0.0, -1.2, -1.8, -1.2, 0.0, -1.2]) * np.pi * w
    adhesion = {"work": w, "range": float(np.cbrt(w**2))}
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
    n = 128
    z = np.cos(2 * np.pi * np.arange(n) / n)[:, None]
    work = (0.3 * np.pi) ** 2 / 2
    adhesion = {"work": work, "range": float(np.sqrt(0.08 * work))}
    gaps = [0.4, 0.9, 1.2, 0.9, 1.5, 1.2, 0.9]
    cycle = solve(z, None, adhesion, gap_mean=gaps, physical_sizes=(1.0, 1 / n))
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
