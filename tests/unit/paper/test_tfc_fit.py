"""Fits of eq. tfc recover planted data, with honest errors."""

import numpy as np
import pytest
from paper.tfc_fit import fit_tfc
from refusal import refused

pytestmark = pytest.mark.slow
NOISE = 0.004
ALPHA = {"t": 1.0, "f": None, "c": 0.6}


def planted(repeats=1, noise=0.0, seed=0):
    """(ratios, values): one ratio varied at a time around the reference system."""
    triples = [(0.5**t, 0.5**10, 0.5) for t in (0, 1, 2, 3)]
    triples += [(0.5, 0.5**f, 0.5) for f in range(4, 10)]
    triples += [(0.5, 0.5**10, 0.5**c) for c in range(2, 6)]
    t, f, c = np.repeat(np.array(triples), repeats, axis=0).T
    value = 1.95 + 0.04 * t + 8 * f**0.7 + 0.13 * c**0.6
    value += noise * np.random.default_rng(seed).normal(size=value.size)
    return {"t": t, "f": f, "c": c}, value


def test_uncertainties_match_the_scatter():
    """Over noisy repetitions, parameters scatter as the covariance predicts."""
    fits = []
    for seed in range(60):
        eps, value = planted(3, NOISE, seed)
        fits.append(fit_tfc(eps, value, NOISE**2 * np.eye(value.size), ALPHA))
    rows = [fit.row(0.8) for fit in fits]
    for name in ("limit", "C_f", "alpha_f"):
        fitted = [row[name] for row in rows]
        claimed = [fit.sigma[name] for fit in fits]
        assert np.std(fitted) == pytest.approx(np.mean(claimed), rel=0.3)
    totals, sigmas = np.transpose([fit.correction(0.5, 0.5**10, 0.5) for fit in fits])
    assert np.std(totals) == pytest.approx(np.mean(sigmas), rel=0.3)
    assert np.mean([fit.chi2 / fit.dof for fit in fits]) == pytest.approx(1, rel=0.2)


def test_runs_that_do_not_determine_every_term_are_refused():
    eps, value = planted()
    one = np.eye(value.size)
    with refused("eps_c: found 1 different"):
        fit_tfc(eps | {"c": 0.5 + 0 * value}, value, one, ALPHA)
    with refused("vary together"):
        fit_tfc(eps | {"t": eps["f"]}, value, one, ALPHA | {"t": 0.67, "f": 0.67})
    with refused("runs: found 3"):
        few = {"t": [0.5, 0.25, 0.5], "f": [0.1, 0.1, 0.2], "c": [0.5, 0.25, 0.5]}
        fit_tfc(few, [1, 2, 3], np.eye(3), {"t": 1.0, "f": 1.0, "c": 1.0})
