"""Corrections to the TFC limits: the paper's tables, refusals, and fits that recover planted
data."""

import json

import numpy as np
import pytest
from refusal import refused

from hpc_gfmd.theory import tfc

REFERENCE = {"eps_t": 1 / 2, "eps_f": 1 / 1024, "eps_c": 1 / 2}


def test_example_of_the_paper():
    value, sigma, terms = tfc.extrapolate(2.2, "kappa", 0.8, 0.007, **REFERENCE)
    assert value == pytest.approx(2.0160, abs=5e-5)
    assert value == pytest.approx(
        2.2 - 0.0421 / 2 - 8.5879 * 1024**-0.67 - 0.1279 * 0.5**0.67, rel=1e-14
    )
    assert sigma is None
    assert terms.total == pytest.approx(2.2 - value)


def test_rounded_pressures_select_their_table():
    for p_star, table in ((0.01 / np.sqrt(2), 0.007), (0.5 / np.sqrt(2), 0.353), (0.37, 0.353)):
        assert tfc.correction("kappa", 0.5, p_star, **REFERENCE).p_star == table


def test_of_two_pressures_the_nearer_one_is_taken():
    table = tfc.paper_table()
    part = next(part for part in table["tables"] if part["observable"] == "kappa")
    table["tables"].append(part | {"p_star": 1.04 * part["p_star"]})
    for wanted in (part["p_star"], 1.04 * part["p_star"]):
        terms = tfc.correction("kappa", 0.8, 1.001 * wanted, **REFERENCE, table=table)
        assert terms.p_star == wanted


@pytest.mark.parametrize("p_star", [0.006, 0.01, 0.05, 0.3, 0.4, 0, np.nan])
def test_other_pressures_are_refused(p_star):
    with refused(r"p_star: found .*allowed"):
        tfc.correction("kappa", 0.5, p_star, **REFERENCE)


def test_interpolation_only_in_hurst():
    ends = [
        tfc.correction("gap_over_h_rms", hurst, 0.353, **REFERENCE) for hurst in (0.5, 0.65, 0.8)
    ]
    assert ends[1].f == pytest.approx((ends[0].f + ends[2].f) / 2)
    assert "interpolated" in ends[1].notes[0]
    assert not any("interpolated" in note for note in ends[0].notes)
    for hurst in (0.29, 0.81, 0, 1):
        with refused("hurst: found"):
            tfc.correction("kappa", hurst, 0.007, **REFERENCE)


def test_zero_ratios_and_refused_arguments():
    assert tfc.correction("kappa", 0.8, 0.007, 0, 0, 0).total == 0
    for bad in ({"eps_t": -1}, {"eps_f": np.nan}, {"eps_c": 1.5}):
        with refused(f"{next(iter(bad))}: found"):
            tfc.correction("kappa", 0.8, 0.007, **(REFERENCE | bad))
    with refused("observable: found 'area', allowed: gap_over_h_rms, kappa"):
        tfc.correction("area", 0.8, 0.007, **REFERENCE)


def runs(noise=0.0, repeats=1, seed=0, limit=1.95, C=(0.04, 8.0, 0.13), alpha=(1, 0.7, 0.6)):
    """(eps_t, eps_f, eps_c, value): one ratio varied at a time around the reference system."""
    ratios = [(0.5**t, 0.5**10, 0.5) for t in (0, 1, 2, 3)]
    ratios += [(0.5, 0.5**f, 0.5) for f in range(4, 10)] + [
        (0.5, 0.5**10, 0.5**c) for c in range(2, 6)
    ]
    eps = np.repeat(np.array(ratios), repeats, axis=0).T
    value = limit + sum(c * e**a for c, e, a in zip(C, eps, alpha, strict=True))
    return (*eps, value + noise * np.random.default_rng(seed).normal(size=value.size))


def test_fit_recovers_exact_data():
    fit = tfc.fit_tfc(*runs(), alpha={"f": 0.7, "c": 0.6})
    assert (fit.limit, fit.C["t"], fit.C["f"], fit.C["c"]) == pytest.approx((1.95, 0.04, 8, 0.13))
    assert fit.names == ("limit", "C_t", "C_f", "C_c")
    free = tfc.fit_tfc(*runs(), alpha={"t": 1, "f": None, "c": None})
    assert free.alpha == pytest.approx({"t": 1, "f": 0.7, "c": 0.6}, rel=1e-5)
    assert free.limit == pytest.approx(1.95, rel=1e-6)
    assert free.correction(0.5, 0.5**10, 0.5)[0] == pytest.approx(
        0.02 + 8 * 0.5**7 + 0.13 * 0.5**0.6, rel=1e-6
    )


@pytest.mark.parametrize("sigma_is_known", [True, False])
def test_fit_uncertainties_match_the_scatter(sigma_is_known):
    """Over noisy repetitions, parameters scatter as the covariance predicts."""
    noise = 0.004
    free = {"f": None, "c": 0.6}
    fits = [
        tfc.fit_tfc(*runs(noise, 3, seed), sigma=noise if sigma_is_known else None, alpha=free)
        for seed in range(60)
    ]
    rows = [f.row(0.8) for f in fits]
    for name in ("limit", "C_f", "alpha_f"):
        fitted = [row[name] for row in rows]
        claimed = [f.sigma[name] for f in fits]
        assert np.std(fitted) == pytest.approx(np.mean(claimed), rel=0.3)
    truth = 0.02 + 8 * 0.5**7 + 0.13 * 0.5**0.6
    total = [f.correction(0.5, 0.5**10, 0.5) for f in fits]
    assert np.std([c for c, _ in total]) == pytest.approx(np.mean([s for _, s in total]), rel=0.3)
    assert np.mean([c for c, _ in total]) == pytest.approx(truth, abs=0.004)
    assert np.mean([f.chi2 / f.dof for f in fits]) == pytest.approx(
        1 if sigma_is_known else noise**2, rel=0.2
    )


def test_fit_of_a_single_term():
    eps_t, eps_f, eps_c, value = runs(C=(0, 8, 0))
    fit = tfc.fit_tfc(eps_t, eps_f, eps_c, value, alpha={"f": None}, terms=iter("f"))
    assert fit.names == ("limit", "C_f", "alpha_f")
    assert fit.alpha["f"] == pytest.approx(0.7, rel=1e-5)


def test_impossible_fits_are_refused():
    eps_t, eps_f, eps_c, value = runs()
    with refused("eps_c: found 1 different"):
        tfc.fit_tfc(eps_t, eps_f, 0.5, value)
    with refused("vary together"):
        tfc.fit_tfc(eps_f, eps_f, eps_c, value, alpha={"t": 0.67})
    with refused("runs: found 3"):
        tfc.fit_tfc([0.5, 0.25, 0.5], [0.1, 0.1, 0.2], [0.5, 0.25, 0.5], [1, 2, 3])
    with refused("value: found nan"):
        tfc.fit_tfc(eps_t, eps_f, eps_c, value * np.nan)
    with refused("terms: found 'tx', allowed: letters of tfc"):
        tfc.fit_tfc(eps_t, eps_f, eps_c, value, terms="tx")
    with refused("alpha: found 'x', allowed: letters of tfc"):
        tfc.fit_tfc(eps_t, eps_f, eps_c, value, alpha={"x": 1})
    with refused("sigma: found 0"):
        tfc.fit_tfc(eps_t, eps_f, eps_c, value, sigma=0)


def test_table_of_a_user(tmp_path):
    fit = tfc.fit_tfc(*runs(0.004, 3), sigma=0.004, alpha={"f": None})
    table = {"tables": [{"observable": "kappa", "p_star": 0.05, "rows": [fit.row(0.8)]}]}
    (tmp_path / "own.json").write_text(json.dumps(table))
    read = tfc.read_table("own.json")
    value, sigma, terms = tfc.extrapolate(
        2.2, "kappa", 0.8, 0.05, **REFERENCE, sigma=0.01, table=read
    )
    expected, error = fit.correction(**REFERENCE)
    assert value == pytest.approx(2.2 - expected)
    assert sigma == pytest.approx(np.hypot(error, 0.01))
    assert terms.notes == ()
    with refused("table: found"):
        tfc.read_table("missing.json")
