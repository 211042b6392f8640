"""Estimates recover planted coefficients, exponents, limits and thresholds within their errors."""

from dataclasses import replace

import numpy as np
import pytest
from paper import estimates
from paper.cases import Case, series
from paper.estimates import Scatter, continuum, fit_observable
from paper.items import distributions, percolation, stiffness
from paper.rows import PRESSURES
from paper_runs import GAP, LAW, runs_of

from hpc_gfmd import SceneError

pytestmark = pytest.mark.slow
LOW = PRESSURES["low"]


def ratios(level, hurst):
    """The cases of the series in eps_c, eps_f and eps_t at one Hurst exponent."""
    cases = [case for name in ("eps_c", "eps_f", "eps_t") for case in series(name, level, [hurst])]
    return list(dict.fromkeys(cases))


def desk(hurst=0.8, **options):
    """Made-up runs of the desk level at one Hurst exponent and the low pressure."""
    return runs_of([replace(case, p_star=(LOW,)) for case in ratios("desk", hurst)], **options)


def matching(runs, **wanted):
    """The runs with these values."""
    return [run for run in runs if wanted.items() <= run.items()]


def test_scatter_is_estimated_and_shared_between_grids():
    runs = desk(scatter=0.06, noise=4e-4)
    scatter = Scatter.of(runs, "kappa")
    for eps_t in (0.5, 0.25):
        sigma_relative = scatter.relative({"eps_t": eps_t, "eps_f": 1 / 64})
        assert sigma_relative == pytest.approx(0.06 * eps_t, rel=0.25)
    assert abs(scatter.law[1]) < 0.15  # independent of eps_f
    pair = matching(runs, seed=1, lam_l_over_lam_s=128, L_over_lam_l=2)[:2]
    covariance = scatter.covariance([*pair, matching(runs, seed=2)[0]], "kappa")
    sigma = np.sqrt(np.diag(covariance))
    assert covariance[0, 1] / sigma[0] / sigma[1] > 0.99
    assert covariance[0, 2] == 0
    with pytest.raises(SceneError, match="one realisation"):
        fit_observable(matching(runs, seed=1), "kappa", "desk")


def test_fit_recovers_planted_coefficients():
    fit = fit_observable(desk(), "kappa", "desk")
    fitted = fit.parameters
    for name, sigma in fit.sigma.items():
        assert abs(fitted[name] - LAW[name]) < 4 * sigma + 1e-9, name
    assert 0 < fit.sigma["C_f"] < 0.5
    assert fit.sigma["alpha_c"] < 0.01  # from pairs of grids: the scatter of realisations cancels
    assert fit.sigma["C_c"] < 0.02
    gap = fit_observable(desk(scatter=0.01), "gap_over_h_rms", "desk")
    fitted = gap.parameters
    assert (fitted["limit"], "limit" in gap.names) == (0, False)
    assert abs(fitted["C_f"] - GAP["C_f"] / (1 + LOW)) < 4 * gap.sigma["C_f"]
    assert abs(fitted["alpha_f"] - GAP["alpha_f"]) < 4 * gap.sigma["alpha_f"]


@pytest.mark.parametrize(("alpha", "agrees"), [(1.0, True), (0.5, False)])
def test_limit_and_its_exponent(alpha, agrees):
    """Counted and edge-corrected areas have one limit if the exponent is 2 - 2H."""

    def kappa(case, eps_t, eps_f, eps_c):
        common = 2.1 + 0.01 * eps_t + 1.5 * eps_f**alpha * (1 + eps_c)
        return common + 0.9 * eps_c, common + 0.1 * eps_c**2

    runs = runs_of(ratios("quick", 0.5), scatter=0.002, kappa=kappa)
    rows = estimates.limits(runs)
    assert len(rows) == 2
    for row in rows:
        assert row["agrees"] is agrees
        assert abs(row["kappa_tfc"] - 2.1) < 4 * row["kappa_tfc_se"] < (0.15 if agrees else 0.5)
    for few in (
        matching(runs, lam_l_over_lam_s=32),
        matching(runs, seed=1),
        matching(runs, lam_s_over_a=2),
    ):
        assert estimates.limits(few) == []


def made_up(scatter, seed=0, loads=(0.1,), jitter=0):
    """Runs with kappa = (2 + H + eps_f) exp(0.1 eps_t + e), e = H eps_c + 0.3 eps_c^2 as counted
    and half of it edge-corrected. jitter: independent noise of every grid and load."""
    rng = np.random.default_rng(seed)
    grids = [(8, 16, 2), (8, 16, 4), (8, 16, 8), (8, 16, 16), (2, 16, 2), (2, 64, 2), (2, 64, 4)]
    grids += [(2, 64, 8), (2, 64, 16), (8, 64, 2)]
    cases = [
        Case(H, *ratios, s, loads)
        for H in (0.3, 0.5, 0.8)
        for ratios in grids
        for s in (1, 2, 3, 4)
    ]

    def kappa(case, eps_t, eps_f, eps_c):
        excess = case.hurst * eps_c + 0.3 * eps_c**2
        noise = 1 + jitter * eps_t * eps_f * eps_c * rng.normal()
        limit = (2 + case.hurst + eps_f) * np.exp(0.1 * eps_t) * noise
        return limit * np.exp(excess), limit * np.exp(excess / 2)

    return runs_of(cases, scatter=scatter, noise=scatter / 10, kappa=kappa, seed=seed)


@pytest.mark.parametrize("observable", ["kappa", "kappa_edge"])
@pytest.mark.parametrize("coarsest", [0.5, 0.25])
def test_continuum_without_scatter_is_exact(observable, coarsest):
    """With three grids only, each eps_f is known for one cell size, whose effect stays in the
    value."""
    runs = [run for run in made_up(1e-7) if run["eps_c"] <= coarsest]
    limits = continuum(runs, observable)
    assert len(limits) == 6
    for (hurst, eps_f, _), (value, _) in limits.items():
        cell = np.inf if coarsest == 0.5 else {1 / 16: 8, 1 / 64: 2}[eps_f]
        assert value == pytest.approx((2 + hurst + eps_f) * np.exp(0.1 / cell), rel=1e-5)


@pytest.mark.parametrize(("loads", "jitter"), [((0.1,), 0), ((1e-4, 1e-3), 3)])
def test_continuum_errors_match_the_scatter(loads, jitter):
    pulls = []
    for seed in range(8):
        limits = continuum(made_up(0.02, seed, loads, jitter), "kappa_edge")
        pulls += [(value - 2 - sum(key[:2])) / sigma for key, (value, sigma) in limits.items()]
        assert max(sigma / value for value, sigma in limits.values()) < 0.02
    assert 0.6 < np.std(pulls) < 1.6
    assert np.abs(pulls).max() < 4.5


def test_continuum_refuses_too_few_runs_and_zeros():
    runs = made_up(0.01)
    for bad_runs, observable, message in (
        (matching(runs, eps_c=0.5), "kappa_edge", "too few grids"),
        (matching(runs, seed=1), "kappa_edge", "two of some"),
        ([run | {"gap_over_h_rms": 0.0} for run in runs], "gap_over_h_rms", "zeros"),
    ):
        with pytest.raises(SceneError, match=message):
            continuum(bad_runs, observable)


def sweeps(thresholds, grid=8, size=1, shifts=(0.02, -0.02)):
    """Load sweeps of surfaces that percolate at the given areas along x and y.

    thresholds: areas along (x, y) of each surface; shifts: of the thresholds through sides and
    through corners, times a/lam_s. Counted areas are too large by 1/grid; gaps seal 0.01 above.
    """
    common = {"hurst": 0.5, "L_over_lam_l": size, "lam_l_over_lam_s": 16, "lam_s_over_a": grid}
    runs = []
    for seed, pair in enumerate(thresholds):
        for area in 1.75 * np.linspace(0.4, 0.04, 37):
            run = common | {"seed": seed, "p_star": area / 1.75, "a_r_edge": area}
            run |= {"a_r": area * (1 + 1 / grid)}
            for axis, at in zip("xy", pair, strict=True):
                for end, shift in zip(("", "_8"), shifts, strict=True):
                    run[f"contact_percolates_{axis}{end}"] = bool(area > at + shift / grid)
                run[f"gap_spans_{axis}"] = bool(area < at + 0.01)
            runs.append(run)
    return runs


def test_percolation_thresholds():
    """Thresholds are interpolated between loads for three cell sizes, and extrapolated to where
    counted and edge-corrected areas, sides and corners agree."""
    rng = np.random.default_rng(1)
    widths = {size: 0.06 * size**-0.75 for size in (1, 2, 4)}
    areas = {size: rng.normal(0.42, width, (60, 2)) for size, width in widths.items()}
    rows = percolation.thresholds(
        [run for size, areas_of_cell in areas.items() for run in sweeps(areas_of_cell, size=size)],
        "quick",
    )
    assert [row["surfaces"] for row in rows] == [60, 60, 60]
    for row in rows:
        assert row["width"] == pytest.approx(widths[row["L_over_lam_l"]], rel=0.25)
        assert abs(row["a_c"] - 0.42 - 0.053 * row["width"]) < 4 * row["a_c_se"] < 0.04
        assert 0.001 < row["a_c_sides"] - row["a_c_corners"] < 0.009
        assert row["a_c_counted"] == pytest.approx(1.125 * row["a_c"], abs=0.002)
        assert row["shift"] is None
    (large,) = percolation.large(rows)
    assert (large["a_c"], large["exponent"]) == (None, pytest.approx(-0.75, abs=0.2))
    assert 0.2 < percolation.thresholds(sweeps([(0.1, 0.9), (0.3, 0.4)]), "quick")[0]["a_c"] < 0.75

    shifts = (0.01, -0.026)
    pairs = np.random.default_rng(3).normal(0.4, 0.03, (100, 2))
    runs = [run for grid in (4, 8, 16) for run in sweeps(pairs[: 400 // grid], grid, shifts=shifts)]
    rows = percolation.thresholds(runs, "quick")
    for row in rows:
        assert abs(row["shift"] - 0.008 / row["lam_s_over_a"]) < 4 * row["shift_se"] < 0.02
    (large,) = percolation.large([row | {"L_over_lam_l": 2} for row in rows])
    assert abs(large["a_c"] - 0.4 - 0.053 * 0.03) < 4 * large["a_c_se"] < 0.04
    assert abs(large["a_c_sealed"] - 0.41 + 0.349 * 0.03) < 4 * large["a_c_sealed_se"] < 0.04


def test_stiffness_power_law_up_to_a_pressure():
    rng = np.random.default_rng(2)
    system = dict(zip((*stiffness.SYSTEM, "lam_s_over_a"), (0.5, 1, 256, 2), strict=True))
    loads = 1e-4 * 2.0 ** np.arange(11)
    planted = np.where(loads < 0.004, loads**0.6, 0.004**0.6 * (loads / 0.004) ** 1.4)
    runs = [
        system
        | {"h_rms": 2.0, "g_rms": 1.0, "seed": seed, "p_star": p}
        | {"stiffness": 3 * k * factor * (1 + 0.02 * rng.normal())}
        for seed, factor in enumerate(rng.uniform(0.5, 2, 20))
        for p, k in zip(loads, planted, strict=True)
    ]
    rows = stiffness.means(runs, "desk")
    (law,) = stiffness.power_laws(rows)
    assert law["exponent"] == pytest.approx(0.6, abs=0.02)
    assert 0.002 < law["ends"] < 0.008
    assert 0 < law["ends_se"] < 0.1 * law["ends"]
    assert rows[-1]["exponent"] == pytest.approx(1.4, abs=0.05)
    assert rows[0]["stiffness"] == pytest.approx(6 * planted[0] * 1.2, rel=0.35)


def test_rebinning_keeps_integral_and_mean():
    edges = np.linspace(0, 2, 33)
    density = np.exp(-edges[:-1])
    density /= np.sum(density * np.diff(edges))
    stored = {"edges": 3 * edges, "density": density / 3}
    new = np.linspace(0, 2.5, 41)
    density_there = distributions._binned(stored, 3.0, new)
    middle = (new[1:] + new[:-1]) / 2
    old = (edges[1:] + edges[:-1]) / 2
    assert np.sum(density_there * np.diff(new)) == pytest.approx(1, rel=1e-12)
    assert np.sum(density_there * middle * np.diff(new)) == pytest.approx(
        np.sum(density * old * np.diff(edges)), rel=2e-3
    )
    edges = distributions.KINDS["pressure"][2]
    inside = distributions.theory(0.3, edges[:-1], edges[1:])
    assert np.sum(inside * np.diff(edges)) == pytest.approx(1, abs=1e-3)
    rows = [
        {"kind": "patches", "low": x, "high": 2 * x, "density": y, "density_se": 0.01 * y}
        for x, y in ((x, x**-1.7) for x in 2.0 ** np.arange(-3, 8))
    ]
    assert distributions.patch_exponent(rows) == pytest.approx((1.7, 0), abs=1e-6)
