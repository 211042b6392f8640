"""Coefficients of eq. tfc, power laws and exponents from runs, by fits that know which runs share a surface (scatter.Scatter)."""

from collections import defaultdict
from dataclasses import replace

import numpy as np

from ..errors import SceneError
from ..theory.tfc_fit import PAPER_ALPHA, fit_tfc
from .averages import near
from .levels import level_of
from .scatter import SOLVER_SHARE, Scatter, error_of

POWER_LAW = (0.1, 4.5)  # exponents that a series along eps_c can have; others are the ends of what is tried
GAP_ALPHA = {"t": 1.0, "f": None, "c": 1.0}  # the paper's choice for the gap, whose limit in units of h_rms is zero


def fit_runs(runs, observable, alpha, terms="tfc", limit=None, scatter=None):
    """theory.tfc_fit.fit_tfc on runs at one H and p*, with their covariance; alpha: exponents by term, None for free ones.

    Where the law does not fit within the errors (chi2 above its degrees of freedom), they are enlarged by the root of that ratio.
    """
    scatter = scatter or Scatter.of(runs, observable)
    if scatter.law is None:
        raise SceneError("runs: found one realisation of each surface, allowed: at least two of some")
    eps = [np.array([run[f"eps_{i}"] for run in runs]) for i in "tfc"]
    value = [run[observable] for run in runs]
    fit = fit_tfc(*eps, value, sigma=scatter.covariance(runs, observable), alpha=alpha, terms=tuple(terms), limit=limit)
    worse = max(1.0, fit.chi2 / fit.dof if fit.dof else 1.0)
    sigma = {name: x * worse**0.5 for name, x in fit.sigma.items()}
    return replace(fit, covariance=fit.covariance * worse, sigma=sigma)


def axes(runs, level):
    """The runs in which one ratio at a time differs from a system of the eps_f series: {"t", "f", "c": runs}, the last at the
    reference lam_l/lam_s, and "fine", those along eps_c at the lam_l/lam_s with most grids."""
    L, F, C = level_of(level).reference
    grids = defaultdict(set)
    for run in runs:
        if near(run["L_over_lam_l"], L):
            grids[run["lam_l_over_lam_s"]].add(run["lam_s_over_a"])
    finest = max(sorted(grids), key=lambda f: len(grids[f]), default=F)

    def picked(**fixed):
        return [run for run in runs if all(near(run[name], x) for name, x in fixed.items())]

    return {
        "t": picked(lam_s_over_a=C),
        "f": picked(L_over_lam_l=L, lam_s_over_a=C),
        "c": picked(L_over_lam_l=L, lam_l_over_lam_s=F),
        "fine": picked(L_over_lam_l=L, lam_l_over_lam_s=finest),
    }


def fit_kappa(runs, observable, level, paper_exponents=False):
    """eq. tfc for kappa on the axes through the reference system, as the paper does; a TfcFit.

    With paper_exponents they are 1, 0.67, 0.67. Otherwise alpha_c is that of the longest eps_c series, alpha_f is fitted, and the
    uncertainty of both is in the covariance; alpha_t = 1.
    """
    part = axes(runs, level)
    chosen = _union(part["t"], part["f"], part["c"])
    scatter = Scatter.of(runs, observable)
    if paper_exponents:
        return fit_runs(chosen, observable, dict(PAPER_ALPHA), scatter=scatter)
    along_c = exponent_c(runs, observable, level, scatter=scatter)
    return _with_exponent(chosen, observable, along_c, scatter)


def fit_gap(runs, observable, level, paper_exponents=False):
    """eq. tfc for gap/h_rms: a pure power law of eps_f (the limit is zero) over the finer half of the octaves, linear in eps_t.

    With paper_exponents it is linear in eps_c, too; otherwise alpha_c is that of the longest eps_c series, as for fit_kappa. A TfcFit.
    """
    octaves = sorted({run["eps_f"] for run in axes(runs, level)["f"]})
    part = axes([run for run in runs if run["eps_f"] <= octaves[len(octaves) // 2] * 1.01], level)
    chosen = _union(part["t"], part["f"], part["c"])
    scatter = Scatter.of(runs, observable)
    if paper_exponents:
        return fit_runs(chosen, observable, dict(GAP_ALPHA), limit=0.0, scatter=scatter)
    along_c = exponent_c(runs, observable, level, scatter=scatter)
    return _with_exponent(chosen, observable, along_c, scatter, limit=0.0)


def exponent_c(runs, observable, level, coarsest=0.5, scatter=None):
    """limit + C_c eps_c^alpha_c along the longest eps_c series, from eps_c = coarsest down; a TfcFit."""
    series = [run for run in axes(runs, level)["fine"] if run["eps_c"] <= coarsest * 1.01]
    return fit_runs(series, observable, {"c": None}, "c", scatter=scatter or Scatter.of(runs, observable))


def local_exponents(runs, observable, level):
    """alpha_c between neighbouring octaves of the longest eps_c series from paired differences of the same surfaces.

    Rows eps_c (the middle grid of three), alpha, alpha_se (jackknife over three seeds or more, and solver), n_seeds; alpha None where
    the differences change sign.
    """
    grids = defaultdict(dict)
    for run in axes(runs, level)["fine"]:
        grids[run["lam_s_over_a"]][run["seed"]] = run
    rows = []
    for c in sorted(grids):
        trio = [grids.get(c / 2, {}), grids[c], grids.get(2 * c, {})]
        if seeds := sorted(set.intersection(*(set(g) for g in trio))):
            value, solver = (
                np.array([[of(grid[s]) for grid in trio] for s in seeds])
                for of in (lambda run: run[observable], lambda run: SOLVER_SHARE * run[error_of(observable)] * run[observable])
            )
            alpha, sigma = _log_ratio(-np.diff(value, axis=1), np.sqrt(np.mean(solver**2, axis=0) / len(seeds)))
            rows.append({"eps_c": 1 / c, "alpha": alpha, "alpha_se": sigma, "n_seeds": len(seeds)})
    return rows


def power_law(rows, x, observable):
    """(exponent, standard error) of a straight line through the logarithms of rows with error bars; None where there are too few."""
    rows = [row for row in rows if row.get(observable) and row[observable] > 0]
    if len({row[x] for row in rows}) < 3:
        return None, None
    sigma = [(row[f"{observable}_se"] or 0.0) / row[observable] or 1e-3 for row in rows]
    at, log = np.log([row[x] for row in rows]), np.log([row[observable] for row in rows])
    design = np.stack([np.ones_like(at), at], axis=1) / np.array(sigma)[:, None]
    solution = np.linalg.lstsq(design, log / sigma, rcond=None)[0]
    return float(solution[1]), float(np.sqrt(np.linalg.inv(design.T @ design)[1, 1]))


def _with_exponent(runs, observable, along_c, scatter, limit=None):
    """The fit with the alpha_c of another fit; its covariance holds what the uncertainty of that does to the other parameters.

    Raises SceneError where the series is no power law: alpha_c at the end of its range, or far outside the error bars.
    """
    alpha_c, sigma = along_c.alpha["c"], along_c.sigma["alpha_c"]
    if not POWER_LAW[0] < alpha_c < POWER_LAW[1] or not sigma < alpha_c:
        raise SceneError(f"alpha_c: found {alpha_c:.2f} +- {sigma:.2f}, allowed: a power law of eps_c")

    def fit_at(exponent):
        return fit_runs(runs, observable, {"t": 1.0, "f": None, "c": exponent}, limit=limit, scatter=scatter)

    best = fit_at(alpha_c)
    step = 0.1 * sigma
    moved = (
        (_parameters(fit_at(alpha_c + step)) - _parameters(fit_at(alpha_c - step))) / (2 * step) * sigma
        if sigma > 0
        else 0 * _parameters(best)
    )
    direction = np.append(moved, sigma)
    covariance = np.zeros((len(direction),) * 2)
    covariance[:-1, :-1] = best.covariance
    covariance += np.outer(direction, direction)
    names = (*best.names, "alpha_c")
    return replace(best, names=names, covariance=covariance, sigma=dict(zip(names, np.sqrt(np.diag(covariance)).tolist(), strict=True)))


def _parameters(fit):
    values = {"limit": fit.limit} | {f"C_{i}": c for i, c in fit.C.items()} | {f"alpha_{i}": a for i, a in fit.alpha.items()}
    return np.array([values[name] for name in fit.names])


def _log_ratio(steps, solver):
    """log2 of the ratio of the mean steps, and its standard error; steps: (seeds, 2), solver: errors of the three means."""

    def exponent(part):
        first, second = part.mean(axis=0)
        return np.log2(first / second) if first * second > 0 else np.nan

    alpha = exponent(steps)
    if not np.isfinite(alpha):
        return None, None
    first, second = steps.mean(axis=0)
    slopes = np.array([1 / first, -1 / first - 1 / second, 1 / second]) / np.log(2)
    variance = np.sum((slopes * solver) ** 2)
    if len(steps) > 2:
        left_out = np.array([exponent(np.delete(steps, i, axis=0)) for i in range(len(steps))])
        variance += (len(steps) - 1) * np.mean((left_out - left_out.mean()) ** 2)
    return float(alpha), float(np.sqrt(variance)) if np.isfinite(variance) else None


def _union(*parts):
    return list({id(run): run for part in parts for run in part}.values())
