"""Dents that stay: loads that follow from each other with a hardness."""

import numpy as np
import pytest
from contacts import random_heights, relative, rough_wall
from oracle import solve_history
from refusal import refused

import hpc_gfmd

H = 0.5
TOP = 0.1  # the largest pressure
BODIES = {
    "half-space": {},
    "compressible layer": {"nu": 0.49, "thickness": 0.05},
    "nearly incompressible layer": {"nu": 0.499, "thickness": 0.05},
    "incompressible layer": {"nu": 0.5, "thickness": 0.05, "base": "frictionless"},
}


def wall(n=64):
    return rough_wall((2, n // 8, 4))


def solve(surface, loads, hardness=H, **how):
    how = {"accuracy": 1e-5, "fields": ["pressure", "gap", "dent"]} | how
    return hpc_gfmd.solve(surface, loads, hardness=hardness, history=True, **how)


@pytest.mark.parametrize(
    ("n", "body", "share"),
    [
        (64, "half-space", 0.2),
        pytest.param(128, "half-space", 0.9, marks=pytest.mark.slow),
        *(pytest.param(128, body, 0.2, marks=pytest.mark.slow) for body in BODIES),
    ],
)
def test_rising_loads_are_path_independent(n, body, share):
    """share: the last load over the hardness."""
    surface = wall(n)
    top = share * H
    (one,) = solve(surface, [top], **BODIES[body])
    last = solve(surface, np.linspace(top / 10, top, 10), **BODIES[body])[-1]
    assert last.gap_mean == pytest.approx(one.gap_mean, rel=1e-5)
    assert relative(last.pressure, one.pressure) < 1e-5
    assert relative(last.dent, one.dent) < 1e-5
    assert last.value("a_plastic") == pytest.approx(one.value("a_plastic"), abs=1e-3)


@pytest.mark.parametrize(("n", "m"), [(32, 13), pytest.param(128, 25, marks=pytest.mark.slow)])
def test_cycles(n, m):
    """Reloading repeats unloading, shakedown in one cycle, and work is stored or dissipated."""
    up = np.linspace(0.02, 1, m) * TOP
    path = np.concatenate([up, up[-2::-1], up[1:], up[-2::-1]])
    cycles = solve(wall(n), path)
    depth, gap, energy, lost = (
        cycles.values(name) for name in ("dent_mean", "gap_mean", "energy", "dissipated_work")
    )
    assert depth[-1] == pytest.approx(cycles[-1].dent.mean(), rel=1e-6)
    assert depth[-1] == pytest.approx(depth[m - 1], rel=1e-5)
    assert lost == pytest.approx(H * depth)
    again = cycles[3 * m - 3]
    assert relative(again.pressure, cycles[m - 1].pressure) < 1e-5
    assert again.value("a_plastic") == cycles[m - 1].value("a_plastic") > 0.1
    reloading = gap[2 * m - 2 : 3 * m - 2][::-1]
    assert reloading == pytest.approx(gap[m - 1 : 2 * m - 1], rel=1e-5)
    for part in (slice(0, m), slice(m - 1, 2 * m - 1)):
        work = np.trapezoid(path[part], (depth - gap)[part])
        spent = np.ptp(lost[part]) + energy[part][-1] - energy[part][0]
        assert spent == pytest.approx(work, rel=0.005 * (24 / (m - 1)) ** 2)


def test_unloading_has_another_curve():
    """Dented asperities touch at more points, and the gap between them is smaller."""
    for share in (0.5, 0.2):
        dented = solve(wall(), [TOP, share * TOP], observables=["critical_gap"])[-1]
        plain = hpc_gfmd.solve(wall(), share * TOP, hardness=H, observables=["critical_gap"])
        assert dented.a_r > 1.1 * plain.a_r
        assert dented.value("critical_gap_x") < 0.95 * plain.value("critical_gap_x")


def test_many_coarsely_solved_loads_do_not_deepen_the_dents():
    """The errors of each load contain those that the loads before have left."""
    loads = TOP * np.array([1.0, *[0.3, 1.0] * 30])
    coarse = solve(wall(), loads, accuracy=1e-2)
    exact = solve(wall(), loads[:2], accuracy=1e-6)
    assert coarse.values("dent_mean")[::2] == pytest.approx(exact[0].value("dent_mean"), rel=1e-2)
    for k, solution in enumerate(coarse):
        right = exact[k % 2]
        assert abs(solution.gap_mean / right.gap_mean - 1) <= solution.gap_error
        assert relative(solution.pressure, right.pressure) <= solution.pressure_error
        assert abs(solution.a_r / right.a_r - 1) <= solution.a_r_error
    inherited = exact[1].pressure_error
    assert (coarse.pressure_error[1::2] > 10 * inherited).all()
    assert (coarse.pressure_error <= 1e-2).all()


def test_a_load_that_is_not_solved_is_said_at_all_later_ones():
    with pytest.warns(hpc_gfmd.NotConverged):
        loads = solve(wall(), [TOP, TOP / 4], max_iterations=1, nested=False)
    assert {step["status"] for step in loads.steps} == {"max_iterations"}


@pytest.mark.parametrize("seed", [1, 2])
def test_small_walls_against_dense_steps(seed):
    surface = np.random.default_rng(seed).standard_normal((12, 10)) * 0.05
    loads = [0.3, 0.1, 0.5, 0.05]
    solutions = hpc_gfmd.solve(
        surface,
        loads,
        hardness=1.0,
        history=True,
        accuracy=1e-6,
        boundary="periodic",
        fields=["pressure", "gap", "dent"],
    )
    history = solve_history(surface, loads, times=[0] * 4, hardness=1.0)
    for (exact, dents), solution in zip(history, solutions, strict=True):
        assert relative(solution.pressure, exact.pressure) < 1e-5
        assert relative(solution.gap, np.maximum(exact.gap, 0)) < 1e-5
        assert np.abs(solution.dent - dents).max() < 1e-5 * dents.max()


def test_unloaded_bodies():
    """No load: the undeformed body touches the dented wall. Wider: it is apart from it."""
    surface = wall(32)
    loads = solve(surface, [TOP, 0, TOP], observables=["stiffness"])
    unloaded = loads[1]
    dented = surface.heights - loads[0].dent
    assert unloaded.a_r == unloaded.pressure.max() == 0
    assert unloaded.note == "no load: nothing touches"
    assert unloaded.gap == pytest.approx(dented.max() - dented, abs=1e-6)
    assert loads[2].gap_mean == pytest.approx(loads[0].gap_mean, rel=1e-5)
    touching = unloaded.gap_mean
    apart = hpc_gfmd.solve(
        surface, gap_mean=[loads[0].gap_mean, 1.1 * touching], hardness=H, history=True
    )[1]
    assert apart.p == apart.a_r == 0
    assert apart.gap_mean == pytest.approx(1.1 * touching, rel=1e-5)


def test_a_flat_plate_that_is_unloaded():
    loads = hpc_gfmd.solve(
        np.zeros((8, 8)), [0.01, 0.05, 0.0], history=True, hardness=0.1, boundary="periodic"
    )
    assert [step.a_r for step in loads] == [1, 1, 0]


def test_a_ball_comes_back_to_its_dent():
    """The approach is that from the first touch of the undeformed bodies."""
    x = (np.arange(32) + 0.5) / 16 - 1
    z = -(x[:, None] ** 2 + x**2) / 20
    how = {"physical_sizes": (2, 2), "boundary": "free", "hardness": 0.03, "history": True}
    deep, back, apart, again = hpc_gfmd.solve(z, approach=[0.05, 0.03, 0.0, 0.05], **how)
    assert back.p < 0.9 * hpc_gfmd.solve(z, approach=0.03, **how).p
    assert back.value("approach") == pytest.approx(0.03, rel=1e-3)
    assert apart.p == 0
    assert apart.value("approach") == pytest.approx(0, abs=1e-15)
    assert again.p == pytest.approx(deep.p, rel=2e-3)


HARD = {"hardness": H, "history": True}


REFUSED = [
    ({"history": True}, "load.history: .* material.hardness or material.adhesion"),
    (HARD | {"pressure": [TOP, -TOP]}, "load.pressure: found -0.1"),
    ({"hardness": H, "pressure": 0.0}, "load.pressure: .* load.history"),
    ({"hardness": H, "fields": ["dent"]}, "dent.* load.history"),
    (HARD | {"observables": ["error_bounds"]}, "error_bounds.* load.history"),
    (HARD | {"adhesion": {"work": 1e-3, "range": 1e-2}}, "material.adhesion"),
    (HARD | {"gap_mean": 0.0, "pressure": None}, "full contact"),
    (HARD | {"low_memory": True}, "solver.low_memory"),
]


def test_refused():
    for keys, words in REFUSED:
        with refused(words):
            hpc_gfmd.solve(wall(32), **({"pressure": TOP} | keys))


def test_a_light_load_with_the_errors_of_a_heavy_one_has_stagnated_by_itself():
    """Single precision does not solve the heavy load more accurately for its sake."""
    how = {"boundary": "periodic", "hardness": 0.9, "history": True, "precision": "single"}
    with pytest.warns(hpc_gfmd.NotConverged, match="load 2"):
        found = hpc_gfmd.solve(random_heights((32, 32), 3), [0.3, 0.003, 0.3, 0.2], **how)
    assert [load.status for load in found] == ["converged", "stagnated", "converged", "converged"]
    assert found[1].pressure_error > 1e-3
    assert "the pressure is known to" in found[1].note
    assert max(found[k].pressure_error for k in (0, 2, 3)) < 1e-3


@pytest.mark.parametrize("seed", range(3))
def test_areas_of_mirror_images_after_a_heavier_load(seed):
    """Images touch at one load, which the errors of the load before leave open: it stagnated there.
    Either side is within the error, and the nearer is taken.
    """
    z = 0.02 * np.random.default_rng(seed).normal(size=(16, 16))
    keys = {"hardness": 0.3, "boundary": "mirror", "physical_sizes": (1.0, 1.0), "fields": ()}
    light = hpc_gfmd.solve(z, a_r=[0.3, 0.15], history=True, **keys)[1]
    assert light.converged
    assert light.a_r_error < 1e-3
    assert abs(light.a_r * 1024 - 0.15 * 1024) < 4
