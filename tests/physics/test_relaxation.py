"""Solids that relax: exact histories of waves, held gaps, creeping and retracting contacts."""

import numpy as np
import pytest
from contacts import relative, rough_wall
from oracle import solve_history
from refusal import refused
from scipy.optimize import brentq

import hpc_gfmd

PRONY = [(0.6, 1.0), (0.3, 10.0)]
P0 = 0.02


def wall(n=64):
    return rough_wall((2, n // 8, 4))


def modulus(prony, time):
    """E*(t)/E*(0)."""
    r, tau = np.array(prony, float).T
    return 1 - r.sum() + (r * np.exp(-np.asarray(time, float)[..., None] / tau)).sum(-1)


def test_full_contact_of_a_wave():
    n, amplitude, times = 64, 0.01, [0, 0.3, 1, 3, 30]
    wave = amplitude * np.cos(2 * np.pi * np.arange(n) / n)[:, None] * np.ones(n)
    load = 2 * np.pi * amplitude
    for keys in ({}, {"pressure": None, "a_r": 1.0}):
        how = {"pressure": load, "time": times, "relaxation": PRONY, "accuracy": 1e-6} | keys
        solutions = hpc_gfmd.solve(wave, **how)
        swings = np.array([np.ptp(solution.pressure) / 2 for solution in solutions])
        assert swings == pytest.approx(np.pi * amplitude * modulus(PRONY, times), rel=1e-12)


def test_a_held_gap():
    """The contact stays as it is, and all pressures relax alike."""
    surface, times = wall(), [0, 0.3, 1, 3, 30]
    held = hpc_gfmd.solve(
        surface, gap_mean=0.6 * surface.h_rms, time=times, relaxation=PRONY, accuracy=1e-5
    )
    assert held.p / held.p[0] == pytest.approx(modulus(PRONY, times), rel=5e-5)
    for solution in held:
        assert relative(solution.pressure, held[0].pressure * solution.p / held.p[0]) < 1e-4
    assert np.ptp(held.a_r) <= 2 / 64**2
    assert held.steps[2]["time"] == 1.0


def creep(time, elements):
    """J(t)/J(0), by the poles of 1/(s R(s)), R(s) = 1 - sum r + sum r s/(s + 1/tau)."""
    shares, taus = np.transpose(elements)
    whole = np.poly(-1 / taus)
    relaxing = [r * np.poly([0, *np.delete(-1 / taus, k)]) for k, r in enumerate(shares)]
    modulus = (1 - shares.sum()) * whole + np.sum(relaxing, axis=0)
    poles = np.roots(modulus)
    factors = np.polyval(whole, poles) / (poles * np.polyval(np.polyder(modulus), poles))
    return 1 / (1 - shares.sum()) + np.exp(np.multiply.outer(time, poles)) @ factors


@pytest.mark.parametrize(
    ("n", "steps", "tolerance"),
    [(32, 16, 8e-3), (32, 32, 2.2e-3), pytest.param(128, 64, 6e-4, marks=pytest.mark.slow)],
)
def test_creep_is_of_second_order(n, steps, tolerance):
    """Against the elastic contact under the load times J(t)/J(0) (Lee, Radok)."""
    r, end = 0.9, 20.0
    times = end * (np.arange(steps + 1) / steps) ** 2
    how = {"accuracy": 1e-6, "fields": ()}
    elastic = hpc_gfmd.solve(wall(n), P0 * creep(end, [(r, 1.0)]), **how)
    crept = hpc_gfmd.solve(wall(n), P0, time=times, relaxation=[(r, 1.0)], **how)[-1]
    assert crept.gap_mean == pytest.approx(elastic.gap_mean, rel=tolerance)
    assert crept.a_r == pytest.approx(elastic.a_r, rel=tolerance + 3 / n**2 / elastic.a_r)


@pytest.mark.parametrize(
    ("steps", "tolerance"),
    [(16, 6e-2), (32, 2.2e-2), pytest.param(64, 8e-3, marks=pytest.mark.slow)],
)
def test_creep_over_decades(steps, tolerance):
    """Three elements and logarithmic steps."""
    elements = [(0.3, 0.01), (0.3, 1.0), (0.3, 100.0)]
    times = [0, *np.geomspace(1e-3, 1e3, steps)]
    elastic = hpc_gfmd.solve(wall(32), P0 * creep(times[-1], elements), fields=())
    crept = hpc_gfmd.solve(wall(32), P0, time=times, relaxation=elements, fields=())[-1]
    assert crept.gap_mean == pytest.approx(elastic.gap_mean, rel=tolerance)


@pytest.mark.slow
def test_the_pressure_of_lee_and_radok():
    """An integral over the elastic pressures under the rising load."""
    r, end, steps = 0.9, 20.0, 64
    times = end * (np.arange(2 * steps + 1) / (2 * steps)) ** 2
    elastic = hpc_gfmd.solve(wall(128), P0 * creep(times, [(r, 1.0)]), accuracy=1e-5)
    p = [solution.pressure.astype(float) for solution in elastic]
    left = modulus([(r, 1)], end - (times[1:] + times[:-1]) / 2)
    exact = modulus([(r, 1)], end) * p[0]
    exact = exact + sum(m * (b - a) for m, a, b in zip(left, p, p[1:]))
    crept = hpc_gfmd.solve(wall(128), P0, time=times[::2], relaxation=[(r, 1.0)], accuracy=1e-6)[-1]
    assert relative(crept.pressure, exact) < 2e-3


def test_a_layer_comes_to_its_soft_limit():
    how = {"nu": 0.3, "thickness": 0.1, "accuracy": 1e-5, "fields": ()}
    times = 40 * (np.arange(17) / 16) ** 2
    layer = hpc_gfmd.solve(wall(32), P0, time=times, relaxation=[(0.8, 1.0)], **how)
    soft = hpc_gfmd.solve(wall(32), P0, 0.2, **how)
    assert layer[-1].value("approach") == pytest.approx(soft.value("approach"), rel=1e-3)


@pytest.mark.parametrize(
    ("n", "steps", "tolerance"),
    [(32, 10, 2e-3), pytest.param(128, 20, 5e-4, marks=pytest.mark.slow)],
)
def test_a_ball_that_indents_and_retracts(n, steps, tolerance):
    """The approach is top min(t, 2 - t) (Ting 1966); steps: of a unit of time."""
    r, R, top = 0.7, 10.0, 0.045
    x = (np.arange(n) + 0.5) / n * 2 - 1
    z = -(x[:, None] ** 2 + x**2) / 2 / R
    how = {"physical_sizes": (2, 2), "boundary": "free", "accuracy": 1e-5, "fields": ()}

    def relaxed(a, b):
        """Integral of the relaxation from a to b."""
        return (1 - r) * (b - a) + r * (np.exp(-a) - np.exp(-b))

    nodes, weights = np.polynomial.legendre.leggauss(200)

    def force(t):
        t1 = t
        if t > 1:
            t1 = brentq(lambda a: relaxed(t - 1, t - a) - relaxed(0, t - 1), 0, 1)
        y = t1 * ((nodes + 1) / 2) ** 2
        dy = weights * t1 * (nodes + 1) / 2
        return 2 * np.sqrt(R) * top**1.5 * (dy * modulus([(r, 1)], t - y) * np.sqrt(y)).sum()

    grid = hpc_gfmd.solve(z, approach=top, **how).p * 4 / (4 / 3 * np.sqrt(R) * top**1.5)
    times = np.arange(0, round(1.4 * steps) + 1) / steps
    path = top * np.minimum(times, 2 - times)
    ball = hpc_gfmd.solve(z, approach=path, time=times, relaxation=[(r, 1.0)], **how)
    for t in (1.0, 1.2, 1.4):
        got = ball[round(t * steps)].p * 4 / grid
        assert got == pytest.approx(force(t), rel=tolerance)


def test_recovery_without_load():
    """Unloaded at a jump the body keeps its shape, u = -c, and comes back to a plane."""
    surface = wall(32)
    loads = hpc_gfmd.solve(
        surface, [P0, P0, *[0] * 4], time=[0, 5, 5, 6, 500, 1000], relaxation=[(0.8, 1.0)]
    )
    assert loads.status == "converged"
    assert loads.p[2:] == pytest.approx(0)
    gaps = loads.gap_mean
    assert loads[1].gap_mean < gaps[2] < gaps[3] < gaps[4]
    assert gaps[5] == pytest.approx(surface.heights.max() - surface.heights.mean(), rel=1e-4)


@pytest.mark.parametrize("hardness", [None, 1.0])
def test_small_walls_against_dense_steps(hardness):
    """A Maxwell element, and with a hardness dents."""
    z = np.random.default_rng(3).standard_normal((12, 10)) * 0.05
    loads, times, element = [0.3, 0.3, 0.1, 0.4], [0.0, 1.0, 1.5, 1.5], (0.7, 2.0)
    history = {} if hardness is None else {"hardness": hardness, "history": True}
    solutions = hpc_gfmd.solve(
        z, loads, time=times, relaxation=[element], accuracy=1e-6, boundary="periodic", **history
    )
    exact_history = solve_history(z, loads, times, element, hardness)
    for (exact, _), solution in zip(exact_history, solutions, strict=True):
        assert relative(solution.pressure, exact.pressure) < 1e-5
        assert relative(solution.gap, np.maximum(exact.gap, 0)) < 1e-5


def test_errors_do_not_add_up():
    """The same steps, coarsely and finely."""
    times = 20 * (np.arange(17) / 16) ** 2
    how = {"time": times, "relaxation": [(0.9, 1.0)]}
    fine = hpc_gfmd.solve(wall(32), P0, accuracy=1e-7, **how)
    for accuracy in (1e-2, 1e-4):
        coarse = hpc_gfmd.solve(wall(32), P0, accuracy=accuracy, **how)
        wrong = [relative(a.pressure, b.pressure) for a, b in zip(coarse, fine, strict=True)]
        assert (np.abs(coarse.gap_mean / fine.gap_mean - 1) <= coarse.gap_error).all()
        assert (wrong <= coarse.pressure_error).all()


RELAXING = {"relaxation": [(0.6, "1 s"), (0.3, "10 s")], "time": ["0 s", "1 s"]}


REFUSED = [
    ({"relaxation": [(0.6, "1 s"), (0.4, "9 s")]}, "found shares that add up to 1"),
    ({"time": ["1 s", "0 s"]}, "load.time: found 0 s after 1 s"),
    ({"time": [0.0, 1.0]}, "all times with units, or none"),
    ({"time": None}, "material.relaxation: found alone"),
    ({"relaxation": None}, "load.time: found alone"),
    ({"time": ["0 s", "1 s", "2 s"], "pressure": [P0, P0]}, "load.time: found 3 times for 2"),
    ({"time": ["0 s", "1 m"]}, "unit of length, not of time"),
    ({"E_star": None, "E1": 1.0, "nu": 0.3, "E2": 1.0, "nu2": 0.3}, "beside E2"),
    (
        {"thickness": 0.1, "nu": 0.3, "base": "elastic", "base_E": 1.0, "base_nu": 0.3},
        "beside base_E",
    ),
    ({"adhesion": {"work": 1e-3, "range": 1e-2}}, "beside material.adhesion"),
    ({"hardness": 1.0}, "load.history: found false"),
    ({"observables": ["error_bounds"]}, "error_bounds"),
]


def test_refused():
    for keys, words in REFUSED:
        with refused(words):
            hpc_gfmd.solve(wall(32), **({"pressure": P0, "E_star": 1.0} | RELAXING | keys))
