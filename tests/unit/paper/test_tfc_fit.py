"""Fits of eq. tfc recover planted data, with honest errors."""

import numpy as np
import pytest
from paper.tfc_fit import fit_tfc
from refusal import refused

pytestmark = pytest.mark.slow


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
    fit = fit_tfc(*runs(), alpha={"f": 0.7, "c": 0.6})
    assert (fit.limit, fit.C["t"], fit.C["f"], fit.C["c"]) == pytest.approx((1.95, 0.04, 8, 0.13))
    assert fit.names == ("limit", "C_t", "C_f", "C_c")
    free = fit_tfc(*runs(), alpha={"t": 1, "f": None, "c": None})
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
        fit_tfc(*runs(noise, 3, seed), sigma=noise if sigma_is_known else None, alpha=free)
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
    fit = fit_tfc(eps_t, eps_f, eps_c, value, alpha={"f": None}, terms=iter("f"))
    assert fit.names == ("limit", "C_f", "alpha_f")
    assert fit.alpha["f"] == pytest.approx(0.7, rel=1e-5)


def test_impossible_fits_are_refused():
    eps_t, eps_f, eps_c, value = runs()
    with refused("eps_c: found 1 different"):
        fit_tfc(eps_t, eps_f, 0.5, value)
    with refused("vary together"):
        fit_tfc(eps_f, eps_f, eps_c, value, alpha={"t": 0.67})
    with refused("runs: found 3"):
        fit_tfc([0.5, 0.25, 0.5], [0.1, 0.1, 0.2], [0.5, 0.25, 0.5], [1, 2, 3])
    with refused("value: found nan"):
        fit_tfc(eps_t, eps_f, eps_c, value * np.nan)
    with refused("terms: found 'tx', allowed: letters of tfc"):
        fit_tfc(eps_t, eps_f, eps_c, value, terms="tx")
    with refused("alpha: found 'x', allowed: letters of tfc"):
        fit_tfc(eps_t, eps_f, eps_c, value, alpha={"x": 1})
    with refused("sigma: found 0"):
        fit_tfc(eps_t, eps_f, eps_c, value, sigma=0)
