"""Contacts whose surfaces attract each other: against closed forms, minimisers, and themselves."""

import adhesive
import numpy as np
import pytest
from scipy.optimize import minimize

import hpc_gfmd
from hpc_gfmd.theory.adhesion import AdhesiveWave, JohnsonKendallRoberts, maugis_pull_off

LAWS = ["exponential", "cubic", "dugdale"]


# -- closed forms


def ball_retracted(tabor, forces, law="exponential", n=128):
    """A ball of radius 1 in a cell of size 1; forces over pi w R; JKR's contact without load has a
    radius of 0.12."""
    w = 0.12**3 * 2 / (9 * np.pi)
    reach = np.cbrt(w**2) / tabor
    ball = hpc_gfmd.make_surface(
        "sphere", radius=1.0, n=(n, n), physical_sizes=(1.0, 1.0), boundary="free"
    )
    found = hpc_gfmd.solve(
        ball,
        force=[float(force * np.pi * w) for force in forces],
        adhesion={"work": w, "range": float(reach), "law": law},
        branch="retraction",
        fields=(),
    )
    return found, JohnsonKendallRoberts(1.0, w)


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
    """From 2 to 3/2 pi w R, by Tabor's parameter."""
    if law == "dugdale":
        assert maugis_pull_off(1.157 * tabor) == pytest.approx(-(holds + comes_off) / 2, rel=1e-3)
    found, _ = ball_retracted(tabor, [0.5, 0.0, -1.2, -1.5, -holds, -comes_off, -2.2], law)
    assert [one.status for one in found] == ["converged"] * 5 + ["separated"] * 2
    assert found[-1].a_r == 0
    assert found.pull_off == found[4].p


def test_contact_of_a_ball_is_that_of_jkr_where_the_range_is_short():
    found, jkr = ball_retracted(3.0, [2.0, 0.0], n=256)
    for solution, force in zip(found, [2.0, 0.0], strict=True):
        radius = np.sqrt(solution.a_r / np.pi)
        assert radius == pytest.approx(jkr.radius(force * np.pi * jkr.w), rel=0.05)


def wave_retracted(loads, ell, n=512):
    """Johnson's wave with alpha = 0.3; loads over p_full; ell: process zone over the wavelength."""
    work = (0.3 * np.pi) ** 2 / 2
    z = np.cos(2 * np.pi * np.arange(n) / n)[:, None]
    adhesion = {"work": work, "range": float(np.sqrt(ell * work))}
    found = hpc_gfmd.solve(
        z,
        [float(load * np.pi) for load in loads],
        physical_sizes=(1.0, 1.0 / n),
        adhesion=adhesion,
        branch="retraction",
        fields=(),
    )
    return found, AdhesiveWave(work)


@pytest.mark.parametrize(
    ("ell", "holds", "comes_off", "area"),
    [(0.08, 0.090, 0.092, 0.448), (0.02, 0.0940, 0.0955, 0.476)],
)
def test_wave(ell, holds, comes_off, area):
    """The shorter the range, the nearer to Johnson's."""
    found, exact = wave_retracted([0.2, 0.0, -0.06, -0.08, -holds, -comes_off], ell)
    assert [one.status for one in found] == ["converged"] * 5 + ["separated"]
    assert found[0].a_r == pytest.approx(area, abs=0.006)
    assert found[0].a_r < exact.a_r(0.2 * exact.p_full)
    assert exact.pull_off / exact.p_full < -holds


# -- minimisers


@pytest.mark.parametrize("law", LAWS)
def test_energy_is_that_of_a_minimiser(law):
    """L-BFGS-B on the same energy, from the same side."""
    wall = adhesive.wall(points=4, waves=4)
    adhesion = adhesive.attraction(0.3, 0.1, law)
    found = hpc_gfmd.solve(wall, p_star=adhesive.LOAD, adhesion=adhesion, residual=1e-9)
    n = wall.heights.shape
    q = [2 * np.pi * np.fft.fftfreq(k, 8.0 / k) for k in n]
    K = np.hypot(q[0][:, None], q[1]) / 2
    h = wall.heights.max() - wall.heights
    from hpc_gfmd.laws import law_named

    phi = law_named(law, adhesion["work"], adhesion["range"])

    def energy(g):
        g = g.reshape(n)
        w = np.fft.ifft2(K * np.fft.fft2(g - h)).real
        total = 0.5 * np.mean((g - h) * w) + adhesive.LOAD * np.mean(g) + np.mean(phi.energy(g))
        return total, ((w + adhesive.LOAD + phi.traction(g)) / g.size).ravel()

    start = found.gap.ravel() + 1e-3
    best = minimize(
        lambda g: [1e4 * x for x in energy(g)],
        start,
        jac=True,
        method="L-BFGS-B",
        bounds=[(0, None)] * start.size,
        options={"maxiter": 20000, "maxfun": 40000, "ftol": 1e-16, "gtol": 1e-12, "maxcor": 30},
    )
    own, _ = energy(found.gap.ravel())
    assert own == pytest.approx(best.fun / 1e4, rel=1e-8)
    assert own <= best.fun / 1e4 + 1e-10 * abs(own)
    assert found.a_r == pytest.approx(np.mean(best.x <= 0), abs=2 / start.size)


# -- branches


def test_the_branches_agree_where_the_contact_is_unique():
    wall, adhesion = adhesive.wall(), adhesive.attraction(1.0, 0.02)
    approach = hpc_gfmd.solve(wall, adhesive.LOAD, adhesion=adhesion, residual=1e-7)
    retraction = adhesive.retracted(wall, adhesion, residual=1e-7)
    assert retraction.a_r == approach.a_r
    assert np.abs(retraction.gap - approach.gap).max() < 1e-5 * approach.gap.max()
    assert 0.1 < approach.value("stability") < 1


def test_the_branches_differ_where_it_is_not():
    """What is pulled apart holds on; the gap is larger on approach, at every point."""
    wall, adhesion = adhesive.wall(), adhesive.attraction(3.0, 0.1)
    approach = hpc_gfmd.solve(wall, adhesive.LOAD, adhesion=adhesion)
    retraction = adhesive.retracted(wall, adhesion)
    assert retraction.a_r > 1.2 * approach.a_r
    assert (retraction.gap - approach.gap).max() < 1e-3 * approach.gap.max()
    for solution in (approach, retraction):
        assert solution.status == "converged"
        assert solution.value("stability") > 0


@pytest.mark.parametrize(
    ("kappa", "reach", "agree"), [(1.0, 0.02, 1), (1.0, 0.1, 1), (3.0, 0.1, 0)]
)
@pytest.mark.parametrize("branch", ["approach", "retraction"])
def test_the_other_branch_on_request(kappa, reach, agree, branch):
    wall, adhesion = adhesive.wall(), adhesive.attraction(kappa, reach)
    loads = [adhesive.LOAD] if branch == "approach" else [8.0, 1.0, 0.3, adhesive.LOAD]
    plain = hpc_gfmd.solve(wall, loads, adhesion=adhesion, branch=branch, fields=())
    found = hpc_gfmd.solve(wall, loads, adhesion=adhesion, branch=branch, fields=(), unique=True)
    assert [one.a_r for one in found] == [one.a_r for one in plain]
    assert found[-1].fft_pairs > plain[-1].fft_pairs + 3
    last, other = found[-1], found[-1].value("a_r_other_branch")
    assert last.value("unique") == agree
    assert ("not unique" in (last.note or "")) == (not agree)
    if agree:
        assert other == pytest.approx(last.a_r, rel=2e-3)
    elif branch == "approach":
        assert other > 1.2 * last.a_r
    else:
        assert other < last.a_r / 1.2
    assert plain[-1].value("unique") is None


def test_where_nothing_is_held_the_branches_agree_too():
    wall, adhesion = adhesive.wall(4, 4), adhesive.attraction(1.0, 0.1)
    found = hpc_gfmd.solve(wall, [-0.005, -2.0], adhesion=adhesion, unique=True)
    assert [one.status for one in found] == ["separated", "separated"]
    assert [one.value("unique") for one in found] == [0, 1]
    assert found[0].value("a_r_other_branch") > 0
    assert found[1].value("a_r_other_branch") == 0


def test_a_load_that_pulls_on_approach_separates():
    found = hpc_gfmd.solve(adhesive.wall(4, 4), -0.01, adhesion=adhesive.attraction(1.0, 0.1))
    assert found.status == "separated"
    assert found.a_r == 0
    assert found.pressure.max() == 0
    assert found.value("gap_mean") is None
    assert "separated" in found.note


def test_no_load_at_all():
    """Attraction alone pulls the bodies together."""
    found = hpc_gfmd.solve(adhesive.wall(4, 4), 0.0, adhesion=adhesive.attraction(1.0, 0.1))
    assert found.status == "converged"
    assert found.a_r > 0
    assert found.pressure.mean() == pytest.approx(found.value("attraction"), rel=1e-3)


# -- balances


@pytest.mark.parametrize(
    "how",
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
def test_every_kind_of_contact(how, law):
    """The wall bears the load and the attraction; the numbers are those of an exact solution."""
    z = adhesive.wall(4, 4).heights
    adhesion = adhesive.attraction(0.5, 0.1, law)
    sizes = {"physical_sizes": (8.0, 8.0)}
    found = hpc_gfmd.solve(z, 0.1, adhesion=adhesion, **sizes, **how)
    assert found.status == "converged"
    assert found.pressure.mean() == pytest.approx(0.1 + found.value("attraction"), rel=3e-3)
    exact_how = {"precision": "double", "residual": 1e-9}
    others = {key: x for key, x in how.items() if key not in ("accuracy", "precision")}
    exact = hpc_gfmd.solve(z, 0.1, adhesion=adhesion, **sizes, **others, **exact_how)
    accuracy = how.get("accuracy", 1e-3)
    assert found.a_r == pytest.approx(exact.a_r, rel=accuracy)
    assert found.gap.mean() == pytest.approx(exact.gap.mean(), rel=accuracy)
    error = np.linalg.norm(found.pressure - exact.pressure) / np.linalg.norm(exact.pressure)
    assert error < accuracy


def test_work_is_the_integral_of_the_load_over_the_gap():
    """d(separation work) = p d(gap) along a branch."""
    wall, adhesion = adhesive.wall(), adhesive.attraction(0.3, 0.05)
    loads = np.linspace(0.04, 0.06, 11)
    found = hpc_gfmd.solve(wall, list(loads), adhesion=adhesion, residual=1e-6, fields=())
    work = found.values("separation_work")
    gaps = found.values("gap_mean")
    done = np.sum((loads[1:] + loads[:-1]) / 2 * np.diff(gaps))
    assert work[-1] - work[0] == pytest.approx(done, rel=1e-2)


def test_range_that_the_grid_does_not_resolve_is_said():
    wall = adhesive.wall(4, 4)
    found = hpc_gfmd.solve(wall, adhesive.LOAD, adhesion=adhesive.attraction(3.0, 0.02))
    assert "not resolved" in found.note
    assert "hysteresis is the grid's" in found.note
    fine = hpc_gfmd.solve(wall, adhesive.LOAD, adhesion=adhesive.attraction(0.3, 0.1))
    assert "resolved" not in (fine.note or "")


def test_weak_attraction_is_none():
    """Numbers go over into those without; `stickiness` says when."""
    wall = adhesive.wall()
    plain = hpc_gfmd.solve(wall, adhesive.LOAD)
    for kappa, least, most in ((1e-4, 0.0, 1e-3), (3.0, 0.03, 1.0)):
        adhesion = adhesive.attraction(kappa, 0.02)
        found = hpc_gfmd.solve(wall, adhesive.LOAD, adhesion=adhesion, observables=["stickiness"])
        assert least < found.observable("stickiness") < most
        if kappa < 1e-3:
            assert found.a_r == pytest.approx(plain.a_r, rel=2e-3)
            assert found.value("stability") > 0.99
        else:
            assert found.a_r > 1.03 * plain.a_r
