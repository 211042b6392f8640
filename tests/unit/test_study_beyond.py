"""Studies beyond the paper: limits, thresholds, exponents and distributions are found where they
are known; pages are written."""

import json

import numpy as np
import pytest
from paper import catalogue, levels
from paper.case import Case
from paper.continuum import continuum
from paper.items import curves, distributions, limit, percolation, stiffness
from paper.publish import publish
from paper.store import Store
from study_runs import runs_of

from hpc_gfmd.util.errors import SceneError

BEYOND = ("curves", "distributions", "limit", "percolation", "stiffness")
GRIDS = (
    (8, 16, 2),
    (8, 16, 4),
    (8, 16, 8),
    (8, 16, 16),
    (2, 16, 2),
    (2, 64, 2),
    (2, 64, 4),
    (2, 64, 8),
    (2, 64, 16),
    (8, 64, 2),
)


def made_up(scatter, seed=0):
    """Runs whose kappa is (2 + H + eps_f) exp(0.1 eps_t + H eps_c + 0.3 eps_c^2) as counted, with
    half of that edge-corrected."""
    cases = [
        Case(H, *ratios, s, (0.1,))
        for H in (0.3, 0.5, 0.8)
        for ratios in GRIDS
        for s in (1, 2, 3, 4)
    ]

    def kappa(case):
        excess = case.hurst * case.eps_c + 0.3 * case.eps_c**2
        return [
            (2 + case.hurst + case.eps_f) * np.exp(0.1 * case.eps_t + share * excess)
            for share in (1, 0.5)
        ]

    return runs_of(cases, scatter=scatter, noise=scatter / 10, kappa=kappa, seed=seed)


@pytest.mark.parametrize("observable", ["kappa", "kappa_edge"])
@pytest.mark.parametrize("coarsest", [0.5, 0.25])
def test_continuum_without_scatter_is_exact(observable, coarsest):
    """Three grids tell fewer powers of eps_c apart; each eps_f is then known of one cell only,
    which stays in the value."""
    found = continuum([run for run in made_up(1e-7) if run["eps_c"] <= coarsest], observable)
    for (hurst, eps_f, _), value in found.value.items():
        cell = np.inf if coarsest == 0.5 else {1 / 16: 8, 1 / 64: 2}[eps_f]
        assert value == pytest.approx((2 + hurst + eps_f) * np.exp(0.1 / cell), rel=1e-5)
    assert len(found.value) == 6


def at_loads(loads, seed=0, jitter=3):
    """The same surfaces at several loads, on each of which a grid adds something of its own."""
    rng, names = np.random.default_rng(seed), ("kappa", "kappa_edge")
    return [
        run
        | {"p_star": p}
        | {
            name: run[name]
            * (1 + jitter * run["eps_t"] * run["eps_f"] * run["eps_c"] * rng.normal())
            for name in names
        }
        for p in loads
        for run in made_up(0.02, seed)
    ]


@pytest.mark.parametrize("loads", [(0.1,), (1e-4, 1e-3)])
def test_continuum_knows_its_errors(loads):
    pulls = []
    for seed in range(8):
        found = continuum(
            at_loads(loads, seed) if len(loads) > 1 else made_up(0.02, seed), "kappa_edge"
        )
        pulls += [
            (value / (2 + sum(key[:2])) - 1) / found.error[key]
            for key, value in found.value.items()
        ]
        assert max(found.error.values()) < 0.02
    assert 0.6 < np.std(pulls) < 1.6
    assert np.abs(pulls).max() < 4.5


def test_loads_together_know_more_of_the_grid():
    runs = at_loads((1e-4, 3e-4, 1e-3), jitter=20)
    for observable in ("kappa", "kappa_edge"):
        together = continuum(runs, observable).error
        assert {p for _, _, p in together} == {1e-4, 3e-4, 1e-3}
        alone = continuum([run for run in runs if run["p_star"] == 1e-4], observable).error
        share = {key: together[key] / error for key, error in alone.items()}
        assert max(share.values()) < 1
        assert (
            max(x for (_, eps_f, _), x in share.items() if eps_f == 1 / 64) < 0.9
        )  # most of their error is the grid's


def test_light_loads_leave_the_coarsest_grid_out():
    """One that does not resolve single contacts tells nothing of them."""
    runs = runs_of(
        curves.series("quick"), kappa=lambda case: (1 + case.eps_c, 1 + 0.2 * case.eps_c)
    )
    spoilt = [
        run
        | (
            {"kappa": 3 * run["kappa"]}
            if run["lam_s_over_a"] == 2 and run["p_star"] in curves.LIGHT
            else {}
        )
        for run in runs
    ]
    light, other = (
        [row["kappa"] for row in curves.limits(some, "quick") if row["p_star"] in curves.LIGHT]
        for some in (runs, spoilt)
    )
    assert len(light) == 8
    assert light == other


def test_continuum_refuses_what_it_cannot_tell():
    runs = made_up(0.01)
    with pytest.raises(SceneError, match="too few grids"):
        continuum([run for run in runs if run["eps_c"] == 0.5], "kappa_edge")
    with pytest.raises(SceneError, match="at least two"):
        continuum([run for run in runs if run["seed"] == 1], "kappa_edge")
    with pytest.raises(SceneError, match="zeros"):
        continuum([run | {"gap_over_h_rms": 0.0} for run in runs], "gap_over_h_rms")


LATE = {"": 0.032, "_8": -0.016}  # by how much a grid delays percolation, times a/lam_s


def sweeps(thresholds, hurst=0.5, size=2, grid=8, waves=16):
    """Runs of surfaces that percolate along x and y where their area exceeds the thresholds, shape
    (surfaces, 2), and LATE; fluids pass to areas 0.01 above."""
    loads = np.linspace(0.1, 0.4, 12)
    return [
        {
            "hurst": hurst,
            "L_over_lam_l": size,
            "lam_l_over_lam_s": waves,
            "lam_s_over_a": grid,
            "seed": seed,
            "p_star": p,
            "a_r_edge": 1.75 * p,
            "a_r": 1.75 * p * (1 + 1 / grid),
        }
        | {
            f"contact_percolates_{axis}{end}": 1.75 * p > at + LATE[end] / grid
            for axis, at in zip("xy", pair, strict=True)
            for end in ("", "_8")
        }
        | {f"gap_spans_{axis}": 1.75 * p < at + 0.01 for axis, at in zip("xy", pair, strict=True)}
        for seed, pair in enumerate(thresholds)
        for p in loads[::-1]
    ]


def test_critical_area_between_loads():
    rng = np.random.default_rng(1)
    runs = [
        run
        for size in (1, 2, 4)
        for run in sweeps(rng.normal(0.42, 0.06 * size**-0.75, (60, 2)), size=size)
    ]
    rows = percolation.thresholds(runs, "quick")
    assert [row["surfaces"] for row in rows] == [60, 60, 60]
    for row in rows:
        assert row["width"] == pytest.approx(0.06 * row["L_over_lam_l"] ** -0.75, rel=0.25)
        assert abs(row["a_c"] - 0.421 - 0.053 * row["width"]) < 4 * row["a_c_se"] < 0.04
        assert 0.001 < row["a_c_sides"] - row["a_c_corners"] < 0.009
        assert row["a_c_counted"] == pytest.approx(1.125 * row["a_c"], abs=0.002)
        assert abs(row["half_sealed"] - 0.43) < 4 * row["half_sealed_se"] < 0.05
        assert row["half_sealed"] - row["a_c_sealed"] == pytest.approx(
            0.349 * row["width"], rel=0.15
        )
        assert row["shift"] is row["more_waves"] is None
    large = percolation.large(rows)[0.5]
    assert large["at_grid"] == pytest.approx(0.423, abs=4 * large["at_grid_se"])
    assert large["a_c"] is None
    assert large["exponent"] == pytest.approx(-0.75, abs=0.2)


def test_critical_area_on_fine_grids():
    """Counted and edge-corrected, sides and corners meet where the grids did not matter; more waves
    are seen on the same seeds."""
    rng = np.random.default_rng(3)
    of = rng.normal(0.4, 0.03, (100, 2))
    runs = [run for grid in (4, 8, 16) for run in sweeps(of[: 400 // grid], grid=grid)] + sweeps(
        of[:60] + 0.02, grid=8, waves=64
    )
    rows = {
        (row["lam_l_over_lam_s"], row["lam_s_over_a"]): row
        for row in percolation.thresholds(runs, "quick")
    }
    for grid in (4, 8, 16):
        assert abs(rows[16, grid]["shift"] + 0.008 / grid) < 4 * rows[16, grid]["shift_se"] < 0.02
    assert rows[64, 8]["shift"] is None
    assert abs(rows[64, 8]["more_waves"] - 0.02) < 4 * rows[64, 8]["more_waves_se"] < 0.02
    large = percolation.large(list(rows.values()))[0.5]
    assert abs(large["a_c"] - 0.4 - 0.053 * 0.03) < 4 * large["a_c_se"] < 0.04
    assert abs(large["sealed"] - 0.41 + 0.349 * 0.03) < 4 * large["sealed_se"] < 0.04


def test_surfaces_beyond_the_loads_count():
    rows = percolation.thresholds(
        sweeps([(0.1, 0.9), (0.3, 0.4), (0.4, 0.5), (0.9, 0.35)]), "quick"
    )
    assert 0.2 < rows[0]["a_c"] < 0.75


def test_stiffness_of_a_power_law_that_ends():
    def stiffness_at(p):
        return p**0.6 if p < 0.004 else 0.004**0.6 * (p / 0.004) ** 1.4

    rng = np.random.default_rng(2)
    system = {
        "hurst": 0.5,
        "L_over_lam_l": 1,
        "lam_l_over_lam_s": 256,
        "lam_s_over_a": 2,
        "h_rms": 2.0,
        "g_rms": 1.0,
    }
    runs = [
        system
        | {
            "seed": seed,
            "p_star": p,
            "stiffness": 3 * stiffness_at(p) * factor * (1 + 0.02 * rng.normal()),
        }
        for seed, factor in enumerate(rng.uniform(0.5, 2, 20))
        for p in stiffness.LOADS
    ]
    rows = stiffness.means(runs, "desk")
    (law,) = stiffness.power_laws(rows)
    assert law["exponent"] == pytest.approx(0.6, abs=0.02)
    assert 0.002 < law["ends"] < law["linear"] < 0.008
    assert 0 < law["ends_se"] < 0.1 * law["ends"]
    of_sizes = [
        law | {"L_over_lam_l": size, "ends": 0.004 * size**-1.7, "ends_se": 2e-4 * size**-1.7}
        for size in (1, 2, 4)
    ]
    (size,) = stiffness.ends_with_size(of_sizes)
    assert size["power"] == pytest.approx(-1.7)
    assert size["power_se"] == pytest.approx(0.05 / 2**0.5 / np.log(2))
    assert rows[-1]["exponent"] == pytest.approx(1.4, abs=0.05)
    assert rows[0]["stiffness"] == pytest.approx(6 * stiffness_at(1e-4) * 1.2, rel=0.35)


@pytest.mark.parametrize(
    ("kappa", "alpha", "verdicts"),
    [
        ((2.16, 1.93), 0.6, ["survives"] * 4),
        ((2.10, 2.31), 0.36, ["does not survive"] * 4),
    ],
)
def test_what_survives_of_the_paper(kappa, alpha, verdicts):
    found = [
        {
            "hurst": hurst,
            "p_star": levels.P_LOW,
            "kappa_tfc": value,
            "kappa_tfc_se": 0.02,
            "alpha_f": alpha,
            "alpha_f_se": 0.1,
        }
        for hurst, value in zip((0.0, 0.8), kappa, strict=True)
    ]
    assert [line["why"].partition(":")[0] for line in limit.of_the_paper(found)] == verdicts


def test_distributions_keep_their_integral_and_mean():
    edges = np.linspace(0, 2, 33)
    density = np.exp(-edges[:-1])
    density /= np.sum(density * np.diff(edges))
    run = {
        "pressure_distribution": {"edges": (3 * edges).tolist(), "density": (density / 3).tolist()}
    }
    new = np.linspace(0, 2.5, 41)
    found = distributions._binned(run, "pressure", 3.0, new)
    middle, old = (new[1:] + new[:-1]) / 2, (edges[1:] + edges[:-1]) / 2
    assert np.sum(found * np.diff(new)) == pytest.approx(1, rel=1e-12)
    assert np.sum(found * middle * np.diff(new)) == pytest.approx(
        np.sum(density * old * np.diff(edges)), rel=2e-3
    )


def test_theory_and_exponent_of_patches():
    edges = distributions.KINDS["pressure"][1]
    inside = distributions.theory(0.3, edges[:-1], edges[1:])
    assert np.sum(inside * np.diff(edges)) == pytest.approx(1, abs=1e-3)
    rows = [
        {"low": x, "high": 2 * x, "density": x**-1.7, "density_se": 0.01 * x**-1.7}
        for x in 2.0 ** np.arange(-3, 8)
    ]
    assert distributions.patch_exponent(rows) == pytest.approx((1.7, 0), abs=1e-6)


@pytest.fixture(scope="module")
def long_series():
    """Cases of levels.tfc_series at one H with all octaves that a limit needs."""
    return [case for case in levels.tfc_series("quick") if case.hurst == 0.5]


@pytest.mark.parametrize(("alpha", "agrees"), [(1.0, True), (0.5, False)])
def test_the_limit_and_its_exponent(long_series, alpha, agrees):
    def kappa(case):
        grids = [0.9 * case.eps_c, 0.1 * case.eps_c**2]
        return [
            2.1 + 1.5 * case.eps_f**alpha * (1 + case.eps_c) + grid + 0.01 * case.eps_t
            for grid in grids
        ]

    rows = limit.limits(runs_of(long_series, scatter=0.002, kappa=kappa), "quick")
    found = limit.conclusions(rows)
    assert len(found) == 2
    for row in found:
        assert row["agrees"] is agrees
        assert abs(row["kappa_tfc"] - 2.1) < 4 * row["kappa_tfc_se"] < (0.15 if agrees else 0.5)
    assert {row["exponent"] for row in rows} == {"free", "2 - 2H"}


def test_pages(tmp_path, cli):
    """From nothing, by one command; those of many surfaces from made-up runs."""
    names = [name for name in BEYOND if name not in ("limit", "curves")]
    cli.prints("study", *names, "--level", "quick", "-o", tmp_path)
    store = Store(tmp_path)
    with open(store.path, "a") as file:
        file.writelines(
            json.dumps(run) + "\n"
            for name in ("limit", "curves")
            for run in runs_of(catalogue.study(name).cases("quick"))
        )
    for name in ("limit", "curves"):
        assert publish(catalogue.study(name), store, "quick")
    for name in BEYOND:
        page, rows = (
            (tmp_path / f"{name}.md").read_text(),
            json.loads((tmp_path / f"{name}.json").read_text())["rows"],
        )
        assert rows
        assert catalogue.study(name).question in page
        assert f"]({name}.png)" in page
        assert f"python scripts/paper {name} --level quick" in page
        assert page.count("\n- ") >= 2
        assert "nan" not in page
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000
    assert all(
        row["kappa"] > 1
        for row in json.loads((tmp_path / "curves.json").read_text())["rows"]
        if row["p_star"] < 0.3
    )
