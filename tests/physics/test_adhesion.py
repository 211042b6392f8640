"""Adhesive contacts against closed forms, a minimiser of the energy, and conservation laws."""

import adhesive
import numpy as np
import pytest
from adhesive_forms import maugis_pull_off

import hpc_gfmd

LAWS = ["exponential", "cubic", "dugdale"]


# -- closed forms


def ball_retracted(tabor, forces, law="exponential", n=128, **more):
    """Retract a ball by forces over pi w R; return the solutions and the JKR theory."""
    ball, adhesion, jkr = adhesive.ball(n, tabor)
    solutions = hpc_gfmd.solve(
        ball,
        force=[float(force * np.pi * jkr.w) for force in forces],
        adhesion=adhesion | {"law": law},
        branch="retraction",
        fields=(),
        **more,
    )
    return solutions, jkr


@pytest.mark.parametrize(
    ("tabor", "law", "holds", "comes_off"),
    [
        (0.1, "exponential", 1.93, 1.98),  # DMT: 2
        (0.3, "exponential", 1.83, 1.88),
        (1.0, "exponential", 1.64, 1.68),
        (0.3 / 1.157, "dugdale", 0.97 * 1.8156, 1.03 * 1.8156),  # Maugis
        (1.0 / 1.157, "dugdale", 0.97 * 1.6007, 1.03 * 1.6007),
    ],
)
def test_pull_off_of_a_ball(tabor, law, holds, comes_off):
    """The pull-off force decreases from 2 to 3/2 pi w R as Tabor's parameter grows."""
    if law == "dugdale":
        assert maugis_pull_off(1.157 * tabor) == pytest.approx(-(holds + comes_off) / 2, rel=1e-3)
    solutions, _ = ball_retracted(tabor, [0.5, 0.0, -1.2, -1.5, -holds, -comes_off, -2.2], law)
    assert [solution.status for solution in solutions] == ["converged"] * 5 + ["separated"] * 2
    assert solutions[-1].a_r == 0
    assert solutions.pull_off == solutions[4].p
    assert solutions.pull_off_bracket == (solutions[4].p, solutions[5].p)
    sizes = solutions.result.surface["physical_sizes"]
    assert solutions.pull_off_force == pytest.approx(solutions.pull_off * np.prod(sizes))


def test_pull_off_is_bisected_on_request(tmp_path):
    """Without a load that pulls; the further loads stand where a finer sweep would have them."""
    lam = 0.3
    solutions, jkr = ball_retracted(
        lam / 1.157, [0.5, 0.0], "dugdale", pull_off_error=0.01, observables=["attraction"]
    )
    assert (np.diff(solutions.p) < 0).all()
    held, lost = solutions.pull_off_bracket
    assert held == solutions.pull_off
    assert lost < held < 0.99 * lost
    sizes = solutions.result.surface["physical_sizes"]
    assert solutions.pull_off_force == pytest.approx(held * np.prod(sizes))
    force_unit = np.pi * jkr.w
    assert solutions.pull_off_force / force_unit == pytest.approx(maugis_pull_off(lam), rel=0.03)
    assert "pull-off (held and lost): pressure" in solutions.table()
    read = hpc_gfmd.load(solutions.save(tmp_path / "pulled.h5"))
    assert read.pull_off_bracket == (held, lost)
    assert read.result.missing_loads == "all loads are finished"


NOT_BISECTED = [
    ({"pull_off_error": 2.0}, "found 2.0, allowed: a number from 1e-4"),
    ({"branch": "approach"}, 'found branch = "approach"'),
    ({"p_star": 0.05}, "found a single load"),
    ({"p_star": None, "gap_over_h_rms": [0.5, 1.0]}, "found gap_over_h_rms"),
]


def test_pull_off_that_cannot_be_bisected():
    for changes, found in NOT_BISECTED:
        how = {
            "p_star": [0.05, 0.0],
            "adhesion": adhesive.attraction(1.0, 0.1),
            "branch": "retraction",
            "pull_off_error": 0.01,
        }
        with pytest.raises(hpc_gfmd.SceneError, match=f"pull_off_error: {found}"):
            hpc_gfmd.solve(adhesive.wall(), **how | changes)


def test_contact_of_a_ball_with_a_short_range_is_that_of_jkr():
    solutions, jkr = ball_retracted(3.0, [2.0, 0.0], n=256)
    for solution, force in zip(solutions, [2.0, 0.0], strict=True):
        radius = np.sqrt(solution.a_r / np.pi)
        assert radius == pytest.approx(jkr.radius(force * np.pi * jkr.w), rel=0.05)


@pytest.mark.parametrize(
    ("ell", "holds", "comes_off", "area"),
    [(0.08, 0.090, 0.092, 0.448), (0.02, 0.0940, 0.0955, 0.476)],
)
def test_wave(ell, holds, comes_off, area):
    """The shorter the range, the closer the results are to Johnson's."""
    wave, exact = adhesive.wave(ell, 512)
    loads = np.pi * np.array([0.2, 0.0, -0.06, -0.08, -holds, -comes_off])
    solutions = hpc_gfmd.solve(**wave, pressure=loads.tolist(), branch="retraction")
    assert [solution.status for solution in solutions] == ["converged"] * 5 + ["separated"]
    assert solutions[0].a_r == pytest.approx(area, abs=0.006)
    assert solutions[0].a_r < exact.a_r(0.2 * exact.p_full)
    assert exact.pull_off / exact.p_full < -holds


# -- minimisers


@pytest.mark.parametrize("law", LAWS)
def test_energy_is_that_of_a_minimiser(law):
    """L-BFGS-B minimises the same energy from the same side."""
    wall = adhesive.wall(points=4, waves=4)
    adhesion = adhesive.attraction(0.3, 0.1, law)
    solution = hpc_gfmd.solve(wall, p_star=adhesive.LOAD, adhesion=adhesion, residual=1e-9)
    energy = adhesive.energy_of(wall, adhesion, adhesive.LOAD)
    best_gap = adhesive.minimum_near(solution.gap + 1e-3, energy)
    best, _ = energy(best_gap)
    solver_energy, _ = energy(solution.gap)
    assert solver_energy == pytest.approx(best, rel=1e-8)
    assert solver_energy <= best + 1e-10 * abs(solver_energy)
    assert solution.a_r == pytest.approx(np.mean(best_gap <= 0), abs=2 / best_gap.size)


# -- branches


LOADS = {"approach": [adhesive.LOAD], "retraction": [8.0, 1.0, 0.3, adhesive.LOAD]}


@pytest.mark.parametrize(
    ("kappa", "reach", "agree"), [(1.0, 0.02, 1), (1.0, 0.1, 1), (3.0, 0.1, 0)]
)
@pytest.mark.parametrize("branch", LOADS)
def test_the_other_branch_on_request(kappa, reach, agree, branch):
    """Its area is that of a solve on it. Where the branches differ, more points stay in contact on
    retraction, and on approach the gap is larger at every point."""
    wall = adhesive.wall()
    adhesion = adhesive.attraction(kappa, reach)
    plain = {
        name: hpc_gfmd.solve(wall, loads, adhesion=adhesion, branch=name)
        for name, loads in LOADS.items()
    }
    solutions = hpc_gfmd.solve(wall, LOADS[branch], adhesion=adhesion, branch=branch, unique=True)
    assert [solution.a_r for solution in solutions] == [x.a_r for x in plain[branch]]
    assert solutions[-1].fft_pairs > plain[branch][-1].fft_pairs + 3
    assert plain[branch][-1].value("unique") is None
    assert solutions[-1].value("unique") == agree
    assert ("not unique" in (solutions[-1].note or "")) == (not agree)
    approach, retraction = (loads[-1] for loads in plain.values())
    other = retraction if branch == "approach" else approach
    assert solutions[-1].value("a_r_other_branch") == pytest.approx(other.a_r, rel=2e-3)
    ratio = retraction.a_r / approach.a_r
    assert abs(ratio - 1) < 2e-3 if agree else ratio > 1.2
    assert (retraction.gap - approach.gap).max() < 1e-3 * approach.gap.max()
    assert min(retraction.value("stability"), approach.value("stability")) > 0


def test_the_branches_where_nothing_adheres():
    """A tensile load separates the bodies on approach; on retraction a small one does not."""
    wall = adhesive.wall(4, 4)
    adhesion = adhesive.attraction(1.0, 0.1)
    solutions = hpc_gfmd.solve(wall, [-0.005, -2.0], adhesion=adhesion, unique=True)
    assert [solution.status for solution in solutions] == ["separated", "separated"]
    assert [solution.value("unique") for solution in solutions] == [0, 1]
    assert solutions[0].value("a_r_other_branch") > 0
    assert solutions[1].value("a_r_other_branch") == 0
    assert solutions[0].a_r == solutions[0].pressure.max() == 0
    assert solutions[0].value("gap_mean") is None
    assert solutions[0].value("critical_gap_x") is None
    assert "separated" in solutions[0].note


# -- balances


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"boundary": "free"},
        {"boundary": ["free", "periodic"]},
        {"thickness": 0.5, "nu": 0.3},
        {"thickness": 0.5, "nu": 0.3, "base": "elastic", "base_E": 5.0, "base_nu": 0.3},
        {"precision": "single"},
        {"precision": "double"},
        {"accuracy": 1e-5},
        {"nested": False},
    ],
)
@pytest.mark.parametrize("law", LAWS)
def test_every_kind_of_contact(settings, law):
    """The contact carries the load and the attraction; results are those of a tight solve."""
    z = adhesive.wall(4, 4).heights
    adhesion = adhesive.attraction(0.5, 0.1, law)
    sizes = {"physical_sizes": (8.0, 8.0)}
    solution = hpc_gfmd.solve(z, 0.1, adhesion=adhesion, **sizes, **settings)
    assert solution.status == "converged"
    assert solution.pressure.mean() == pytest.approx(0.1 + solution.value("attraction"), rel=3e-3)
    exact_settings = {key: x for key, x in settings.items() if key not in ("accuracy", "precision")}
    exact_settings |= {"precision": "double", "residual": 1e-9}
    exact = hpc_gfmd.solve(z, 0.1, adhesion=adhesion, **sizes, **exact_settings)
    accuracy = settings.get("accuracy", 1e-3)
    assert solution.a_r == pytest.approx(exact.a_r, rel=accuracy)
    assert solution.gap.mean() == pytest.approx(exact.gap.mean(), rel=accuracy)
    error = np.linalg.norm(solution.pressure - exact.pressure) / np.linalg.norm(exact.pressure)
    assert error < accuracy


def test_work_is_the_integral_of_the_load_over_the_gap():
    """d(separation work) = p d(gap) along a branch."""
    wall = adhesive.wall()
    adhesion = adhesive.attraction(0.3, 0.05)
    loads = np.linspace(0.04, 0.06, 11)
    solutions = hpc_gfmd.solve(wall, list(loads), adhesion=adhesion, residual=1e-6, fields=())
    work = solutions.values("separation_work")
    gaps = solutions.values("gap_mean")
    integral = np.sum((loads[1:] + loads[:-1]) / 2 * np.diff(gaps))
    assert work[-1] - work[0] == pytest.approx(integral, rel=1e-2)


def test_a_range_that_the_grid_does_not_resolve_is_noted():
    wall = adhesive.wall(4, 4)
    solution = hpc_gfmd.solve(wall, adhesive.LOAD, adhesion=adhesive.attraction(3.0, 0.02))
    assert "not resolved" in solution.note
    assert "hysteresis is the grid's" in solution.note
    fine = hpc_gfmd.solve(wall, adhesive.LOAD, adhesion=adhesive.attraction(0.3, 0.1))
    assert "resolved" not in (fine.note or "")


def test_weak_attraction_changes_nothing():
    """Results tend to those without attraction; `stickiness` shows when."""
    wall = adhesive.wall()
    plain = hpc_gfmd.solve(wall, adhesive.LOAD)
    for kappa, low, high in ((1e-4, 0.0, 1e-3), (3.0, 0.03, 1.0)):
        adhesion = adhesive.attraction(kappa, 0.02)
        solution = hpc_gfmd.solve(
            wall, adhesive.LOAD, adhesion=adhesion, observables=["stickiness"]
        )
        assert low < solution.observable("stickiness") < high
        if kappa < 1e-3:
            assert solution.a_r == pytest.approx(plain.a_r, rel=2e-3)
            assert solution.value("stability") > 0.99
        else:
            assert solution.a_r > 1.03 * plain.a_r
