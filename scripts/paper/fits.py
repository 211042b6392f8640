"""Coefficients of eq. tfc, power laws and exponents from runs, by fits that know which runs share a
surface (scatter.Scatter)."""

from dataclasses import replace
from typing import Any

import numpy as np

from hpc_gfmd.theory.tfc_fit import PAPER_ALPHA, TfcFit, fit_tfc
from hpc_gfmd.util.errors import SceneError

from .levels import REFERENCE, at_level
from .rows import Rows, groups, near
from .scatter import SOLVER_SHARE, Scatter, error_of

POWER_LAW = (
    0.1,
    4.5,
)  # exponents that a series along eps_c can have; others are the ends of what is tried
GAP_ALPHA = {
    "t": 1.0,
    "f": None,
    "c": 1.0,
}  # the paper's choice for the gap, whose limit in units of h_rms is zero


def fit_runs(
    runs: Rows,
    observable: str,
    alpha: dict,
    terms: str = "tfc",
    limit: float | None = None,
    scatter: Scatter | None = None,
) -> TfcFit:
    """theory.tfc_fit.fit_tfc on runs at one H and p*, with their covariance; alpha: exponents by
    term, None for free ones.

    Where the law does not fit within the errors (chi2 above its degrees of freedom), they are
    enlarged by the root of that ratio.
    """
    scatter = scatter or Scatter.of(runs, observable)
    if scatter.law is None:
        raise SceneError(
            "runs: found one realisation of each surface, allowed: at least two of some"
        )
    eps_t, eps_f, eps_c = (np.array([run[f"eps_{i}"] for run in runs]) for i in "tfc")
    value = [run[observable] for run in runs]
    fit = fit_tfc(
        eps_t,
        eps_f,
        eps_c,
        value,
        sigma=scatter.covariance(runs, observable),
        alpha=alpha,
        terms=tuple(terms),
        limit=limit,
    )
    return replace(
        fit, covariance=fit.covariance * max(1.0, fit.chi2 / fit.dof if fit.dof else 1.0)
    )


def axes(runs: Rows, level: str) -> dict[str, Rows]:
    """The runs in which one ratio at a time differs from a system of the eps_f series: {"t", "f",
    "c": runs}, the last at the reference lam_l/lam_s, and "fine", those along eps_c at the
    lam_l/lam_s with most grids."""
    L, F, C = at_level(REFERENCE, level)
    series = groups([run for run in runs if near(run["L_over_lam_l"], L)], "lam_l_over_lam_s")
    finest = max(series, key=lambda f: len(groups(series[f], "lam_s_over_a")), default=F)

    def picked(**fixed: float) -> Rows:
        return [run for run in runs if all(near(run[name], x) for name, x in fixed.items())]

    return {
        "t": picked(lam_s_over_a=C),
        "f": picked(L_over_lam_l=L, lam_s_over_a=C),
        "c": picked(L_over_lam_l=L, lam_l_over_lam_s=F),
        "fine": picked(L_over_lam_l=L, lam_l_over_lam_s=finest),
    }


def fit_observable(
    runs: Rows, observable: str, level: str, paper_exponents: bool = False
) -> TfcFit:
    """eq. tfc on the axes through the reference system, as the paper does: for kappa with a free
    limit; for the gap, whose limit in units of h_rms is zero, over the finer half of the octaves of
    eps_f. A TfcFit.

    With paper_exponents they are 1, 0.67, 0.67 (gap: 1, free, 1). Otherwise alpha_c is that of the
    longest eps_c series, alpha_f is fitted, and the uncertainty of both is in the covariance;
    alpha_t = 1.
    """
    gap = observable.startswith("gap")
    chosen = runs
    if gap:
        octaves = sorted({run["eps_f"] for run in axes(runs, level)["f"]})
        chosen = [run for run in runs if run["eps_f"] <= octaves[len(octaves) // 2] * 1.01]
    part = axes(chosen, level)
    chosen = list({id(run): run for run in (*part["t"], *part["f"], *part["c"])}.values())
    how: dict[str, Any] = {"limit": 0.0 if gap else None, "scatter": Scatter.of(runs, observable)}
    if paper_exponents:
        return fit_runs(chosen, observable, GAP_ALPHA if gap else PAPER_ALPHA, **how)
    return _with_exponent(
        chosen, observable, exponent_c(runs, observable, level, scatter=how["scatter"]), **how
    )


def exponent_c(
    runs: Rows, observable: str, level: str, coarsest: float = 0.5, scatter: Scatter | None = None
) -> TfcFit:
    """limit + C_c eps_c^alpha_c along the longest eps_c series, from eps_c = coarsest down; a
    TfcFit."""
    series = [run for run in axes(runs, level)["fine"] if run["eps_c"] <= coarsest * 1.01]
    return fit_runs(
        series, observable, {"c": None}, "c", scatter=scatter or Scatter.of(runs, observable)
    )


def is_power_law(alpha: float, sigma: float) -> bool:
    """Whether an exponent of eps_c is none of the ends of what is tried, and known at all."""
    return POWER_LAW[0] < alpha < POWER_LAW[1] and sigma < alpha


def local_exponents(runs: Rows, observable: str, level: str) -> Rows:
    """alpha_c between neighbouring octaves of the longest eps_c series from paired differences of
    the same surfaces.

    Rows eps_c (the middle grid of three), alpha, alpha_se (jackknife over three seeds or more, and
    solver), n_seeds; alpha None where the differences change sign.
    """
    series = groups(axes(runs, level)["fine"], "lam_s_over_a")
    grids = {c: {run["seed"]: run for run in part} for c, part in series.items()}
    rows = []
    for c in grids:
        trio = [grids.get(c / 2, {}), grids[c], grids.get(2 * c, {})]
        if seeds := sorted(set.intersection(*(set(grid) for grid in trio))):
            value = np.array([[grid[seed][observable] for grid in trio] for seed in seeds])
            solver = (
                SOLVER_SHARE
                * value
                * [[grid[seed][error_of(observable)] for grid in trio] for seed in seeds]
            )
            alpha, sigma = _log_ratio(
                -np.diff(value, axis=1), np.sqrt(np.mean(solver**2, axis=0) / len(seeds))
            )
            rows.append({"eps_c": 1 / c, "alpha": alpha, "alpha_se": sigma, "n_seeds": len(seeds)})
    return rows


def power_law(rows: Rows, x: str, observable: str) -> tuple[float | None, float | None]:
    """(exponent, standard error) of a straight line through the logarithms of rows with error bars;
    None where there are too few."""
    rows = [row for row in rows if row.get(observable) and row[observable] > 0]
    if len({row[x] for row in rows}) < 3:
        return None, None
    sigma = np.array([(row[f"{observable}_se"] or 0.0) / row[observable] or 1e-3 for row in rows])
    line, covariance = np.polyfit(
        np.log([row[x] for row in rows]),
        np.log([row[observable] for row in rows]),
        1,
        w=1 / sigma,
        cov="unscaled",
    )
    return float(line[0]), float(np.sqrt(covariance[0, 0]))


def _with_exponent(
    runs: Rows, observable: str, along_c: TfcFit, limit: float | None, scatter: Scatter
) -> TfcFit:
    """The fit with the alpha_c of another fit; its covariance holds what the uncertainty of that
    does to the other parameters.

    Raises SceneError where the series is no power law: alpha_c at the end of its range, or far
    outside the error bars.
    """
    alpha_c, sigma = along_c.alpha["c"], along_c.sigma["alpha_c"]
    if not is_power_law(alpha_c, sigma):
        raise SceneError(
            f"alpha_c: found {alpha_c:.2f} +- {sigma:.2f}, allowed: a power law of eps_c"
        )

    def fit_at(exponent: float) -> TfcFit:
        return fit_runs(
            runs, observable, {"t": 1.0, "f": None, "c": exponent}, limit=limit, scatter=scatter
        )

    best, step = fit_at(alpha_c), 0.1 * sigma
    moved = (
        fit_at(alpha_c + step).values - fit_at(alpha_c - step).values
    ) / 0.2  # when alpha_c is larger by its error
    direction = np.append(moved, sigma)
    return replace(
        best,
        names=(*best.names, "alpha_c"),
        covariance=np.pad(best.covariance, (0, 1)) + np.outer(direction, direction),
    )


def _log_ratio(steps: np.ndarray, solver: np.ndarray) -> tuple[float | None, float | None]:
    """log2 of the ratio of the mean steps, and its standard error; steps: (seeds, 2), solver:
    errors of the three means."""

    def exponent(part: np.ndarray) -> float:
        first, second = part.mean(axis=0)
        return np.log2(first / second) if first * second > 0 else np.nan

    alpha = exponent(steps)
    if not np.isfinite(alpha):
        return None, None
    first, second = steps.mean(axis=0)
    slopes = np.array([1 / first, -1 / first - 1 / second, 1 / second]) / np.log(2)
    variance = np.sum((slopes * solver) ** 2)
    if len(steps) > 2:  # jackknife
        left_out = [exponent(np.delete(steps, i, axis=0)) for i in range(len(steps))]
        variance += (len(steps) - 1) * np.var(left_out)
    return float(alpha), float(np.sqrt(variance)) if np.isfinite(variance) else None
