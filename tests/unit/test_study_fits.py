"""Averages and fits of the studies: planted coefficients, exponents and limits come back, with
errors that say how well."""

import json
from dataclasses import replace

import numpy as np
import pytest
from paper import coefficients, fits, limits, paper, text
from paper.averages import average
from paper.case import Case
from paper.levels import P_HIGH, P_LOW, tfc_series
from paper.scatter import Scatter
from study_runs import EDGE, GAP, LAW, runs_of

from hpc_gfmd.theory import tfc
from hpc_gfmd.util.errors import SceneError

SURFACE = Case(0.8, 2, 64, 2, 1, (P_LOW,))


def desk(hurst=0.8, **how):
    """The runs of the desk level at one H and the low pressure."""
    return runs_of([replace(case, p_star=(P_LOW,)) for case in tfc_series("desk", (hurst,))], **how)


def test_scatter_is_found_and_shared():
    runs = desk(scatter=0.06, noise=4e-4)
    scatter = Scatter.of(runs, "kappa")
    for eps_t in (0.5, 0.25):
        assert scatter.relative(eps_t, 1 / 64) == pytest.approx(0.06 * eps_t, rel=0.25)
    assert abs(scatter.law[1]) < 0.15  # the same at all eps_f
    pair = [
        run
        for run in runs
        if (run["seed"], run["lam_l_over_lam_s"], run["L_over_lam_l"]) == (1, 128, 2)
    ][:2]
    other = next(run for run in runs if run["seed"] == 2)
    covariance = scatter.covariance([*pair, other], "kappa")
    sigma = np.sqrt(np.diag(covariance))
    assert covariance[0, 1] / sigma[0] / sigma[1] > 0.99
    assert covariance[0, 2] == 0
    assert np.isnan(Scatter.of(pair, "kappa").relative(0.5, 0.1))


def test_averages():
    runs = runs_of([replace(SURFACE, seed=seed) for seed in range(1, 9)], scatter=0.1)
    (row,) = average(runs, ("kappa", "gap_over_h_rms"))
    values = [run["kappa"] for run in runs]
    assert (row["n_seeds"], row["hurst"], row["eps_f"]) == (8, 0.8, 1 / 64)
    assert row["kappa"] == pytest.approx(np.mean(values), rel=1e-12)
    assert row["kappa_se"] == pytest.approx(
        np.std(values, ddof=1) / np.sqrt(8), rel=0.15
    )  # the pooled logarithm is unbiased, not it
    assert average(runs[:1], ("kappa",))[0]["kappa_se"] is None


def test_fine_grids_with_few_seeds_do_not_jump():
    """A mean over the seeds that a fine grid happens to have is corrected by what those seeds do on
    the grid that has all."""
    coarse = [replace(SURFACE, seed=seed) for seed in range(1, 9)]
    fine = replace(SURFACE, seed=3, lam_s_over_a=4)
    runs = runs_of([*coarse, fine], scatter=0.2)
    rows = {row["lam_s_over_a"]: row for row in average(runs, ("kappa",))}
    alone = runs_of([SURFACE, replace(SURFACE, lam_s_over_a=4)], scatter=0)
    assert rows[4]["kappa"] / rows[2]["kappa"] == pytest.approx(
        alone[1]["kappa"] / alone[0]["kappa"], rel=1e-12
    )
    assert rows[4]["n_seeds"] == 1
    assert rows[4]["kappa_se"] / rows[4]["kappa"] == pytest.approx(
        rows[2]["kappa_se"] / rows[2]["kappa"], rel=0.01
    )


def test_planted_coefficients_come_back():
    fit = fits.fit_observable(desk(), "kappa", "desk")
    found = (
        {"limit": fit.limit}
        | {f"C_{i}": c for i, c in fit.C.items()}
        | {f"alpha_{i}": a for i, a in fit.alpha.items()}
    )
    for name, sigma in fit.sigma.items():
        assert abs(found[name] - LAW[name]) < 4 * sigma + 1e-9, name
    assert 0 < fit.sigma["C_f"] < 0.5
    assert fit.sigma["alpha_c"] < 0.01  # pairs: the scatter of realisations does not matter
    assert fit.sigma["C_c"] < 0.02


def test_pairs_beat_averages():
    """With the covariance of shared surfaces C_c is known to a fraction of what independent runs
    would give."""
    runs, alpha = desk(scatter=0.1, noise=4e-4), {"c": 1.1}
    series = fits.axes(runs, "desk")["fine"]
    paired = fits.fit_runs(series, "kappa", alpha, "c")
    sigma = np.sqrt(np.diag(Scatter.of(series, "kappa").covariance(series, "kappa")))
    eps = [[run[f"eps_{i}"] for run in series] for i in "tfc"]
    alone = tfc.fit_tfc(*eps, [run["kappa"] for run in series], sigma=sigma, alpha=alpha, terms="c")
    assert paired.sigma["C_c"] < alone.sigma["C_c"] / 5
    assert (
        abs(paired.C["c"] - LAW["C_c"])
        < 4 * paired.sigma["C_c"] + 0.002 * LAW["C_c"] + 0.1 * LAW["C_c"]
    )


def test_errors_of_fits_are_honest():
    """Over repetitions the parameters scatter as their errors say."""
    runs = [desk(scatter=0.04, noise=4e-3, seed=seed) for seed in range(12)]
    for observable, law, name in (
        ("kappa", LAW, "alpha_c"),
        ("kappa", LAW, "limit"),
        ("kappa_edge", EDGE, "limit"),
    ):
        pulls = []
        for one in runs:
            fit = fits.fit_observable(one, observable, "desk")
            value = fit.limit if name == "limit" else fit.alpha["c"]
            pulls.append((value - law[name]) / fit.sigma[name])
        assert 0.4 < np.sqrt(np.mean(np.square(pulls))) < 1.7, (observable, name)


def test_gap_is_a_pure_power_law():
    fit = fits.fit_observable(desk(scatter=0.01), "gap_over_h_rms", "desk")
    assert fit.limit == 0
    assert "limit" not in fit.names
    fall = 1 / (1 + P_LOW)
    assert abs(fit.C["f"] - GAP["C_f"] * fall) < 4 * fit.sigma["C_f"]
    assert abs(fit.alpha["f"] - GAP["alpha_f"]) < 4 * fit.sigma["alpha_f"]


def test_exponents_along_a_series():
    runs = desk(scatter=0.0)
    for row in fits.local_exponents(runs, "kappa", "desk"):
        assert row["alpha"] == pytest.approx(LAW["alpha_c"], abs=1e-6)
        assert 0 < row["alpha_se"] < 0.02
    rows = average(desk(), ("kappa", "gap_over_h_rms"))
    at = [row for row in rows if row["L_over_lam_l"] == 2 and row["lam_s_over_a"] == 2]
    exponent, sigma = fits.power_law(
        [row | {"x": 3 * row["eps_f"] ** 0.4, "x_se": 0.01} for row in at], "eps_f", "x"
    )
    assert exponent == pytest.approx(0.4, abs=1e-9)
    assert sigma > 0
    assert fits.power_law(at[:2], "eps_f", "kappa") == (None, None)


def test_steps_that_change_sign_have_no_exponent():
    cases = [replace(SURFACE, lam_l_over_lam_s=128, lam_s_over_a=c) for c in (2, 4, 8)]
    runs = runs_of(cases, kappa=lambda case: ({2: 2.1, 4: 2.0, 8: 2.05}[case.lam_s_over_a],) * 2)
    (row,) = fits.local_exponents(runs, "kappa", "desk")
    assert row["alpha"] is None


def planted(case):
    """kappa, kappa_edge with the product of grid and roughness, and a common limit of 1.9."""
    common = 1.9 + 0.03 * case.eps_t
    raw = common + (1.5 + 2 * case.eps_c) * case.eps_f**0.6 + 0.7 * case.eps_c + 0.2 * case.eps_c**2
    return raw, common + 1.5 * case.eps_f**0.6 - 0.1 * case.eps_c + 0.5 * case.eps_c**3


def test_both_routes_find_the_limit():
    raw, edge = limits.compare_routes(desk(kappa=planted, noise=2e-3))
    for limit in (raw, edge):
        assert abs(limit["kappa_tfc"] - 1.9) < 4 * limit["kappa_tfc_se"]
        assert limit["kappa_tfc_se"] < 0.1
        assert abs(limit["alpha_f"] - 0.6) < 0.3
        assert 0.5 < limit["chi2_per_dof"] < 1.5
        assert limit["difference"] == raw["kappa_tfc"] - edge["kappa_tfc"]
        assert abs(limit["difference"]) < 4 * limit["difference_se"]
        assert limit["difference_se"] < limit["kappa_tfc_se"]  # the same contacts
    assert raw["alpha_f"] == edge["alpha_f"]


def test_limits_need_enough_runs():
    runs = desk()
    with pytest.raises(SceneError, match="eps_f: found 1"):
        limits.compare_routes([run for run in runs if run["lam_l_over_lam_s"] == 1024])
    with pytest.raises(SceneError, match="one realisation"):
        limits.compare_routes([run for run in runs if run["seed"] == 1])
    with pytest.raises(SceneError, match="fewer than two eps_f"):
        limits.compare_routes(
            [run for run in runs if run["lam_s_over_a"] == 2 or run["lam_l_over_lam_s"] == 128]
        )


def test_covariance_is_checked():
    eps = np.array([0.5, 0.25, 0.125])
    with pytest.raises(SceneError, match="sigma: found shape"):
        tfc.fit_tfc(0.5, 0.5, eps, 2 + eps, sigma=-np.eye(3), terms="c", alpha={"c": 1})
    fit = tfc.fit_tfc(
        0.5, 0.5, eps, 3 * eps, sigma=0.01 * np.eye(3), terms="c", alpha={"c": 1}, limit=0.0
    )
    assert (fit.limit, fit.C["c"], fit.names) == (0.0, pytest.approx(3), ("C_c",))


def test_our_table_serves_the_command(tmp_path):
    runs = runs_of(tfc_series("desk", (0.3, 0.8)))
    path = tmp_path / "ours.json"
    coefficients.write_our_table(coefficients.our_table(runs, "desk"), path)
    table = tfc.read_table(path)
    assert {(part["observable"], len(part["rows"])) for part in table["tables"]} == {
        ("kappa", 2),
        ("gap_over_h_rms", 2),
    }
    for p_star in (0.007, P_HIGH):
        sim = LAW["limit"] + LAW["C_t"] / 2 + LAW["C_f"] * 1024**-0.7 + LAW["C_c"] * 0.5**1.1
        value, sigma, _ = tfc.extrapolate(
            sim, "kappa", 0.8, p_star, 0.5, 1 / 1024, 0.5, table=table
        )
        assert abs(value - LAW["limit"]) < 4 * sigma < 0.2
    assert json.loads(path.read_text())["source"].startswith("hpc_gfmd")


def test_numbers_of_the_paper():
    assert paper.of_hurst("kappa_tfc", 0.8) == 1.93
    assert paper.of_hurst("gap_exponents_h_rms", 0.3, "high") == 0.30
    assert paper.of_hurst("kappa_tfc", 0.5) is None
    assert paper.coefficients("kappa", "low", 0.8)["C_f"] == 8.5879
    assert paper.coefficients("kappa", "low", 0.0) is None
    assert len(paper.numbers()["literature"]) == 7


@pytest.mark.parametrize(
    ("value", "sigma", "expected"),
    [
        (2.0604, 0.0123, "2.060 ± 0.012"),
        (2.0604, None, "2.06"),
        (None, None, "-"),
        (-0.5, 12.0, "-0 ± 12"),
        (1.5, 0.96, "1.50 ± 0.96"),
    ],
)
def test_quoted(value, sigma, expected):
    assert text.quoted(value, sigma) == expected


def test_templates():
    row = {
        "kappa": 2.0604,
        "kappa_se": 0.0123,
        "eps_f": 1 / 16,
        "gap": None,
        "n": 512,
        "0.1": 3.14159,
    }
    assert (
        text.filled("{kappa:±} or {kappa:.1f} at {eps_f:1/}, n = {n}", row)
        == "2.060 ± 0.012 or 2.1 at 1/16, n = 512"
    )
    assert text.filled("{gap:.3g} {gap:±} {missing:.3g}|{0.1:.3g}", row) == "- - |3.14"
    assert (
        text.table([row], {"H | x": "{n}", "kappa": "{kappa:±}|"})
        == "| H | x | kappa |\n|---|---|\n| 512 | 2.060 ± 0.012\\| |"
    )
