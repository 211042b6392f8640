"""From runs to numbers with standard errors: means over realisations, power laws, the coefficients
of eq. tfc, limits.

One surface is solved on several grids and at several pressures, and the surfaces of a seed at
neighbouring lam_l/lam_s share their long waves. The deviation of a realisation is therefore common
to many runs and cancels in differences: a fit with the covariance (Scatter) is a fit of paired
differences where there are pairs, and of averages where there are none.
"""

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import digamma

from hpc_gfmd import SceneError

from .cases import CATALOGUE
from .rows import Rows, families, fine_half, groups, longest, near
from .tfc_fit import PAPER_ALPHA, TfcFit, fit_tfc, least_squares

COLUMNS = (
    *("hurst", "p_star", "L_over_lam_l", "lam_l_over_lam_s", "lam_s_over_a"),
    *("eps_t", "eps_f", "eps_c", "n"),
)
SOLVER_SHARE = 0.2  # sigma over the solver's error estimate, which is nearly an upper bound
POWER_LAW = (0.1, 4.5)  # exponents of a series along eps_c; beyond them a search has failed
JACKKNIFE = 20  # groups of realisations that are left out one after the other


def jackknife(
    estimate: Callable[[np.ndarray], ArrayLike], count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return an estimate, or several, and the standard errors (nan for one surface).
    estimate(indices) makes them from some of `count` surfaces."""
    all_indices = np.arange(count)
    parts = np.array_split(all_indices, min(count, JACKKNIFE))
    value = np.asarray(estimate(all_indices))
    if count < 2:
        return value, np.full_like(value, np.nan)
    partial_estimates: Any = [estimate(np.delete(all_indices, part)) for part in parts]
    return value, np.sqrt((len(parts) - 1) * np.var(partial_estimates, axis=0))


def weighted_mean(values: ArrayLike, errors: ArrayLike) -> tuple[float, float]:
    """Return a weighted mean and its standard error, which is scaled up if the values scatter by
    more than their own errors."""
    value = np.asarray(values)
    weight = np.asarray(errors) ** -2.0
    mean = float(np.average(value, weights=weight))
    chi2 = float(np.sum(weight * (value - mean) ** 2)) / max(value.size - 1, 1)
    return mean, float(np.sqrt(max(1.0, chi2) / np.sum(weight)))


def power_law(rows: Rows, x: str, y: str, cov: Any = "unscaled") -> tuple[Any, Any]:
    """Fit y ~ x^exponent to the rows with a positive y, whose errors are y_se; return (exponent,
    standard error), None twice for fewer than three x. cov=True scales the error by how well the
    law fits."""
    rows = [row for row in rows if row.get(y) and row[y] > 0]
    if len({row[x] for row in rows}) < 3:
        return None, None
    abscissa, value, error = (
        np.array([row.get(column) or 0.0 for row in rows]) for column in (x, y, f"{y}_se")
    )
    weight = value / np.where(error > 0, error, 1e-3 * value)
    line, covariance = np.polyfit(np.log(abscissa), np.log(value), 1, w=weight, cov=cov)
    return float(line[0]), float(np.sqrt(covariance[0, 0]))


@dataclass(frozen=True)
class Scatter:
    """Relative scatter of one observable at one H and p*.

    Attributes
    ----------
    law : (float, float) or None
        a and b of the relative standard deviation eps_t exp(a) eps_f^b; None if no surface has two
        seeds. It is proportional to eps_t, because a cell of side L holds 1/eps_t^2 cells of side
        lam_l.
    jitter : float
        Standard deviation due to the grid at eps_t = eps_f = eps_c = 1. It is proportional to
        eps_t eps_f, because contacts of size lam_s meet the grid independently.
    memory : float
        Correlation of the deviations of one seed at eps_f and eps_f/2.
    """

    law: tuple | None
    jitter: float
    memory: float

    @classmethod
    def of(cls, runs: Rows, observable: str) -> Self:
        """Return the scatter of a column of runs at one H and p*, with several seeds and ratios."""
        alike = groups(runs, "eps_t", "eps_f", "eps_c")
        points = []
        deviations: dict[tuple, dict] = defaultdict(dict)
        for (eps_t, eps_f, eps_c), group in alike.items():
            values = np.array([run[observable] for run in group])
            if len(group) < 2 or values.mean() == 0:
                continue
            relative = values / values.mean() - 1
            dof = len(group) - 1
            points.append((np.log(eps_f), np.sum(relative**2) / dof / eps_t**2, dof))
            if len(group) >= 4:
                normalised = relative / np.sqrt(np.mean(relative**2) or 1)
                for run, deviation in zip(group, normalised):
                    deviations[eps_t, eps_c, run["seed"]][np.log2(eps_f)] = deviation
        return cls(_law(points), _jitter(alike, observable), _memory(deviations))

    def relative(self, run: dict) -> float:
        """Return the standard deviation of a realisation over the mean; nan without a law."""
        if not self.law:
            return np.nan
        return float(np.exp(self.law[0]) * run["eps_f"] ** self.law[1] * run["eps_t"])

    def grid(self, run: dict) -> float:
        """Return the relative standard deviation that the grid adds to that of the surface."""
        return self.jitter * run["eps_t"] * run["eps_f"] * run["eps_c"]

    def covariance(self, runs: Rows, observable: str) -> np.ndarray:
        """Return the covariance (runs, runs) of a column by realisations, grids and the solver."""
        value = np.array([run[observable] for run in runs])
        sigma = value * [self.relative(run) for run in runs]
        octaves = np.log2([run["eps_f"] for run in runs])
        apart = np.abs(np.subtract.outer(octaves, octaves))
        seed, eps_t = np.array([(run["seed"], run["eps_t"]) for run in runs]).T
        same_waves = np.equal.outer(seed, seed) & np.equal.outer(eps_t, eps_t)
        shared = np.where(same_waves, self.memory**apart, 0.0) * np.outer(sigma, sigma)
        independent = [self.grid(run) ** 2 + _solver_sigma(run, observable) ** 2 for run in runs]
        return shared + np.diag(value**2 * independent)


def _solver_sigma(run, observable):
    """Return the relative standard error due to the solver."""
    error = "a_r_error" if observable.startswith(("kappa", "a_r")) else "gap_error"
    return SOLVER_SHARE * run[error]


def _law(points):
    """Fit a line through the logarithms of the variances; return (a, b) of Scatter.law.

    points: (ln eps_f, variance/eps_t^2, degrees of freedom), which are the weights.
    """
    points = [point for point in points if point[1] > 0]
    if not points:
        return None
    log_eps_f, variance, dof = np.array(points).T
    log = np.log(variance) - digamma(dof / 2) + np.log(dof / 2)  # without the bias of a sample
    slope = 0.0
    if len(set(log_eps_f)) > 2:
        slope = np.polyfit(log_eps_f, log, 1, w=np.sqrt(dof))[0]
    return float(np.average(log - slope * log_eps_f, weights=dof) / 2), float(slope / 2)


def _jitter(alike, observable):
    """Return Scatter.jitter from pairs of neighbouring grids of the same surfaces."""
    squares = 0.0
    dof = 0
    for (eps_t, eps_f, eps_c), group in alike.items():
        coarser = {run["seed"]: run[observable] for run in alike.get((eps_t, eps_f, 2 * eps_c), ())}
        pairs = [(run[observable], coarser.get(run["seed"])) for run in group]
        ratio = np.array([fine / coarse for fine, coarse in pairs if coarse is not None])
        if len(ratio) > 1:  # 5 = 1 + 2^2: the variances of both grids
            scale = 5 * (eps_t * eps_f * eps_c) ** 2
            squares += np.sum((ratio / ratio.mean() - 1) ** 2) / scale
            dof += len(ratio) - 1
    return float(np.sqrt(squares / dof)) if dof else 0.0


def _memory(deviations):
    """Return Scatter.memory: the mean product of normalised deviations one octave apart."""
    products = [
        deviation * series[octave - 1]
        for series in deviations.values()
        for octave, deviation in series.items()
        if octave - 1 in series
    ]
    return float(np.clip(np.mean(products), 0.0, 0.99)) if products else 0.0


def average(runs: Rows, *observables: str) -> Rows:
    """Average columns over realisations.

    Surfaces that are solved on several grids, some of them for fewer seeds, are averaged as ratios
    to the grid with most seeds, so that means along eps_c do not jump with the choice of seeds.
    Return a row for each pressure and surface without its seed, in order: COLUMNS, n_seeds, the
    mean of each observable and NAME_se, its scatter over sqrt(n_seeds); None if no surface has two
    seeds.
    """
    rows: Rows = []
    for family in groups(runs, "hurst", "p_star").values():
        scatter = {name: Scatter.of(family, name) for name in observables}
        for surfaces in groups(family, "L_over_lam_l", "lam_l_over_lam_s").values():
            grids = groups(surfaces, "lam_s_over_a").values()
            base = max(grids, key=len)
            for part in grids:
                row = {name: part[0][name] for name in COLUMNS} | {"n_seeds": len(part)}
                for name in observables:
                    row[name], row[f"{name}_se"] = _mean(name, part, base, scatter[name])
                rows.append(row)
    return rows


def _mean(name, part, base, scatter):
    """Return the mean over seeds and its standard error.

    base: runs of the same surfaces, and perhaps more, on another grid.
    """
    square = scatter.relative(part[0]) ** 2
    mean = np.mean([run[name] for run in part])
    seeds = {run["seed"] for run in part}
    shared = [run[name] for run in base if run["seed"] in seeds]
    if len(base) > len(part) == len(shared):
        mean *= np.mean([run[name] for run in base]) / np.mean(shared)
        grid_square = sum(scatter.grid(runs[0]) ** 2 for runs in (part, base))
        square = square / len(base) + grid_square / len(part)
    else:
        square /= len(part)
    sigma = float(abs(mean) * np.sqrt(square)) if np.isfinite(square) else None
    return float(mean), sigma


def along_c(runs: Rows, level: str) -> Rows:
    """Return the runs of the longest series along eps_c at the level's reference L/lam_l."""
    L, _, _ = CATALOGUE["reference"][level]
    return longest([run for run in runs if near(run["L_over_lam_l"], L)], "eps_c")


def fit_runs(
    runs: Rows, observable: str, scatter: Scatter, alpha: dict, limit: float | None = None
) -> TfcFit:
    """Fit eq. tfc to a column of runs at one H and p* with their covariance. For `alpha` and
    `limit` see fit_tfc; standard errors are scaled up if the law does not fit within them."""
    eps = {i: np.array([run[f"eps_{i}"] for run in runs]) for i in alpha}
    value = np.array([run[observable] for run in runs])
    fit = fit_tfc(eps, value, scatter.covariance(runs, observable), alpha, limit)
    scale = max(1.0, fit.chi2 / fit.dof) if fit.dof else 1.0
    return replace(fit, covariance=fit.covariance * scale)


def known_scatter(runs: Rows, observable: str) -> Scatter:
    """Return the Scatter of an observable. Raises SceneError if no surface has two seeds."""
    scatter = Scatter.of(runs, observable)
    if scatter.law is None:
        raise SceneError("runs: found one realisation of each surface, allowed: two of some")
    return scatter


def fit_observable(runs: Rows, observable: str, level: str, printed: bool = False) -> TfcFit:
    """Fit eq. tfc to runs at one H and p*, on the axes through the reference system of the level,
    as the paper does.

    The limit of kappa is free. That of the gap in units of h_rms is zero, and only the finer half
    of the octaves of eps_f is fitted. `printed` uses the paper's exponents alpha_t, alpha_f,
    alpha_c = 1, 0.67, 0.67 (for the gap 1, free, 1). Otherwise alpha_t = 1, alpha_f is fitted,
    alpha_c is that of the longest eps_c series, and the covariance contains the uncertainty of
    both. Raises SceneError if the series are too short.
    """
    scatter = known_scatter(runs, observable)
    limit = None
    L, F, C = CATALOGUE["reference"][level]
    chosen = [
        run
        for run in runs
        if near(run["lam_s_over_a"], C)
        or (near(run["L_over_lam_l"], L) and near(run["lam_l_over_lam_s"], F))
    ]
    if observable.startswith("gap"):
        chosen = fine_half(chosen)
        limit = 0.0

    def fit_at(alpha_c, alpha_f=None):
        alpha = {"t": 1.0, "f": alpha_f, "c": alpha_c}
        return fit_runs(chosen, observable, scatter, alpha, limit)

    if printed:
        return fit_at(1.0) if limit == 0 else fit_at(PAPER_ALPHA["c"], PAPER_ALPHA["f"])
    along = fit_runs(along_c(runs, level), observable, scatter, {"c": None})
    alpha_c = along.parameters["alpha_c"]
    sigma = along.sigma["alpha_c"]
    if not (POWER_LAW[0] < alpha_c < POWER_LAW[1] and sigma < alpha_c):
        raise SceneError(f"alpha_c: found {alpha_c:.2f} ± {sigma:.2f}, allowed: a power law")
    best = fit_at(alpha_c)
    step = 0.1 * sigma
    difference = parameters_of(fit_at(alpha_c + step)) - parameters_of(fit_at(alpha_c - step))
    direction = np.append(difference / 0.2, sigma)  # if alpha_c is larger by its standard error
    covariance = np.pad(best.covariance, (0, 1)) + np.outer(direction, direction)
    return replace(best, names=(*best.names, "alpha_c"), covariance=covariance)


def parameters_of(fit: TfcFit) -> np.ndarray:
    """Return the fitted parameters in the order of fit.names."""
    return np.array([fit.parameters[name] for name in fit.names])


def local_exponents(runs: Rows, observable: str, level: str) -> Rows:
    """Return alpha_c between neighbouring octaves of the longest eps_c series of runs at one H and
    p*.

    There is a row for each three grids: eps_c of the middle one, alpha from paired differences
    (None if they change sign), alpha_se from the solver and, for three seeds or more, a jackknife,
    and n_seeds.
    """
    series = groups(along_c(runs, level), "lam_s_over_a")
    grids = {c: {run["seed"]: run for run in part} for c, part in series.items()}
    rows = []
    for c in grids:
        trio = [grids.get(c / 2, {}), grids[c], grids.get(2 * c, {})]
        if seeds := sorted(set.intersection(*map(set, trio))):
            runs_of_seeds = [[grid[seed] for grid in trio] for seed in seeds]
            value = np.array([[run[observable] for run in part] for part in runs_of_seeds])
            error = np.array(
                [[_solver_sigma(run, observable) for run in part] for part in runs_of_seeds]
            )
            noise = np.sqrt(np.mean((value * error) ** 2, axis=0) / len(seeds))
            alpha, sigma = _log_ratio(-np.diff(value, axis=1), noise)
            rows.append({"eps_c": 1 / c, "alpha": alpha, "alpha_se": sigma, "n_seeds": len(seeds)})
    return rows


def _log_ratio(steps, solver_sigma):
    """Return log2 of the ratio of two mean steps, and its standard error.

    steps: (seeds, 2), from each grid to the next of three; solver_sigma: standard errors of the
    means on the three grids.
    """
    fine_step, coarse_step = steps.mean(axis=0)
    if not fine_step * coarse_step > 0:
        return None, None

    def exponent(seeds):
        ratio = np.divide(*steps[seeds].mean(axis=0))
        return np.log2(ratio) if ratio > 0 else np.nan

    alpha, sigma = jackknife(exponent, len(steps))
    slopes = np.array([1 / fine_step, -1 / fine_step - 1 / coarse_step, 1 / coarse_step])
    slopes /= np.log(2)
    sigma = np.hypot(sigma if len(steps) > 2 else 0.0, np.linalg.norm(slopes * solver_sigma))
    return float(alpha), float(sigma) if np.isfinite(sigma) else None


# kappa in the limit of large cells, many decades of roughness and fine grids


ROUTES = ("kappa", "kappa_edge")  # as counted, edge-corrected
ALPHA_F = (0.1, 3.0)  # bounds of the fit
AGREE = 6.6  # chi2 by which 2 - 2H may be worse than the best exponent (1 % significance)


def fit_limit(runs: Rows, observable: str, scatter: Scatter, alpha_f: float | None) -> dict:
    """Fit kappa, as counted or edge-corrected (one of ROUTES), at one H and p*.

    The corrections of eq. tfc do not simply add up: a coarse grid increases the fractal correction.
    The model is therefore

        kappa_TFC + C_t eps_t + (C_f + D eps_c) eps_f^alpha_f
            + C_1 eps_c + C_2 eps_c^2 + C_3 eps_c^3,

    that is eq. tfc with the product that the data demand, and with a Taylor series in eps_c: the
    contact of a surface that is smooth below lam_s has a boundary of finite length, so the excess
    of counted grid points is linear in eps_c for eps_c -> 0. alpha_f None is a free exponent.
    kappa_se is scaled up if the model does not fit. Raises SceneError if the runs do not determine
    the parameters.
    """
    errors = scatter.covariance(runs, observable)
    columns = (observable, "eps_t", "eps_f", "eps_c")
    value, t, f, c = np.array([[run[column] for column in columns] for run in runs]).T
    is_free = alpha_f is None
    count = 8 if is_free else 7

    def design(x):
        power = f ** (x[7] if is_free else alpha_f)
        return np.stack([np.ones_like(f), t, power, power * c, c, c**2, c**3], axis=1)

    def jacobian(x):
        terms = design(x)
        return np.column_stack([terms, terms[:, 2:4] @ x[2:4] * np.log(f)])[:, :count]

    start = np.array([2.0, 0.0, 2.0, 0.0, 1.0, 0.0, 0.0, 0.7])[:count]
    low = np.full(count, -np.inf)
    high = np.full(count, np.inf)
    low[7:], high[7:] = ALPHA_F
    fit = least_squares(lambda x: design(x) @ x[:7], jacobian, [start], value, errors, (low, high))
    dof = len(runs) - count
    sigma = np.sqrt(np.diag(fit.covariance) * max(1.0, fit.chi2 / dof))
    return {
        "kappa": float(fit.x[0]),
        "kappa_se": float(sigma[0]),
        "alpha_f": float(fit.x[7]) if is_free else alpha_f,
        "alpha_f_se": float(sigma[7]) if is_free else None,
        "chi2": fit.chi2,
        "dof": dof,
    }


def limits(runs: Rows) -> Rows:
    """Return kappa in the limit, the one estimate that all tables and pictures show.

    The area as counted and the edge-corrected one must have the same limit, and alpha_f depends on
    neither: kappa_tfc is the mean of both fits with alpha_f = 2 - 2H if that agrees with the free
    exponents of both, otherwise with the free exponents. The coarsest third of the octaves of eps_f
    is left out, because no power law holds there.

    There is a row for each H and p* with enough runs, with both fits (counted, edge) and the mean
    of the free exponents (alpha_f). kappa_tfc_se combines realisations and solver, half the
    difference of the two fits, the effect of leaving out one more octave and, if the exponents
    disagree, half the effect of that.
    """
    rows = []
    for _, _, family in families(runs):
        try:
            rows.append(_limit(family))
        except SceneError:
            continue
    return rows


def _limit(runs):
    """Return the row of `limits` at one H and p*."""
    octaves = sorted({run["eps_f"] for run in runs})
    hurst = runs[0]["hurst"]
    expected_alpha = float(np.clip(2 - 2 * hurst, *ALPHA_F))
    left_out = len(octaves) // 3
    scatter = {name: known_scatter(runs, name) for name in ROUTES}

    def fit(alpha_f, left_out=left_out):
        fine_runs = [run for run in runs if run["eps_f"] <= octaves[-1 - left_out]]
        return [fit_limit(fine_runs, name, scatter[name], alpha_f) for name in ROUTES]

    def mean_kappa(fits):
        return float(np.mean([row["kappa"] for row in fits]))

    free = fit(None)
    fixed = fit(expected_alpha)
    chi2_increase = [
        (b["chi2"] - a["chi2"]) / max(1.0, a["chi2"] / a["dof"]) for a, b in zip(free, fixed)
    ]
    agrees = max(chi2_increase) < AGREE
    chosen, rejected = (fixed, free) if agrees else (free, fixed)
    counted, edge = (row["kappa"] for row in chosen)
    kappa = mean_kappa(chosen)
    try:
        kappa_of_fewer_octaves = mean_kappa(fit(expected_alpha if agrees else None, left_out + 1))
    except SceneError:  # too few octaves
        kappa_of_fewer_octaves = kappa
    errors = [
        max(row["kappa_se"] for row in chosen),
        (counted - edge) / 2,
        kappa_of_fewer_octaves - kappa,
        0.0 if agrees else (mean_kappa(rejected) - kappa) / 2,
    ]
    alpha, alpha_se = np.array([(row["alpha_f"], row["alpha_f_se"]) for row in free]).T
    return {
        "hurst": hurst,
        "p_star": runs[0]["p_star"],
        "kappa_tfc": kappa,
        "kappa_tfc_se": float(np.hypot.reduce(errors)),
        "counted": counted,
        "edge": edge,
        "alpha_f": float(np.average(alpha, weights=alpha_se**-2.0)),
        "alpha_f_se": float(alpha_se.min()),
        "agrees": agrees,
    }


# an observable in the limit of fine grids and large cells at a given H, eps_f and pressure


# (powers of eps_c with a coefficient for each family, powers with a common one, relative error of
# the description by common terms). The area as counted has an excess that is proportional to the
# length of the contact boundary.
GRID_TERMS: dict[str, tuple] = {
    "kappa": ((1,), (2, 3), 1e-6),
    "kappa_edge": ((), (1, 2, 3), 1e-6),
    "gap_over_h_rms": ((), (3, 4), 2e-4),
}
LOADS = 0.25  # the deviations of a surface at loads p < p' are correlated by (p/p')^LOADS


def continuum(runs: Rows, observable: str) -> dict[tuple, tuple]:
    """Return the limit of an observable (of GRID_TERMS) for each H, eps_f and p_star from all runs
    together.

        ln value = ln limit + C_t eps_t + C_1 eps_c + sum over k of eps_c^k (smooth function of H,
        ln eps_f, ln p_star)

    is fitted by generalised least squares, with a limit and C_t for each H, eps_f and p_star, and
    C_1 (linear in ln p_star) for each H and eps_f. The grid acts on single contacts, which hardly
    depend on H, eps_f and a small load. Its effect is therefore common to all of them (except C_1
    of the area as counted) and well determined even if one surface has few contacts.

    Return {(H, eps_f, p_star): (limit, standard error)}; errors are scaled up if the model does not
    fit within them. Raises SceneError if a value is zero, the scatter is unknown or a term is not
    determined.
    """
    parts = groups(runs, "hurst", "eps_f", "p_star")
    runs = [run for part in parts.values() for run in part]
    value = np.array([run[observable] for run in runs])
    if not runs or not (value > 0).all():
        raise SceneError(f"{observable}: found no runs or zeros, allowed: positive values")
    errors = _covariance(parts, observable)
    family_powers, common_powers, _ = GRID_TERMS[observable]
    grids = len({run["eps_c"] for run in runs})
    n_common = max(1, grids - 1 - len(family_powers))  # as many as the grids determine
    design = np.column_stack(
        [
            *_family_columns(parts, family_powers),
            *_grid_columns(runs, common_powers[:n_common], len(family_powers)),
        ]
    )
    whiten = np.linalg.inv(np.linalg.cholesky(errors))
    white = whiten @ design
    target = whiten @ np.log(value)
    scale = np.linalg.norm(white, axis=0)
    parameters, _, rank, _ = np.linalg.lstsq(white / scale, target, rcond=1e-9)
    if rank < len(parameters):
        raise SceneError("runs: found too few grids or cells, allowed: as many as there are powers")
    dof = len(value) - len(parameters)
    chi2 = np.sum((target - white / scale @ parameters) ** 2) / max(dof, 1)
    variance = np.diag(np.linalg.inv((white / scale).T @ (white / scale))) * max(1.0, chi2)
    limit = np.exp(parameters / scale)
    sigma = limit * np.sqrt(variance) / scale
    return {key: (float(v), float(s)) for key, v, s in zip(parts, limit, sigma)}


def _covariance(parts, observable):
    """Return the relative covariance of all runs.

    The jitter of the grid is the root mean square over all H, because few surfaces of each H were
    solved on several grids. It is uncorrelated at different loads. Its correlation at neighbouring
    H of a seed (0.7 at H = 0.7 and 0.8) is neglected, which makes errors 10 % too small.
    """
    scatters = {key: known_scatter(part, observable) for key, part in parts.items()}
    squares: dict[tuple, list[float]] = defaultdict(list)
    for (_, *eps_f_and_load), scatter_of_part in scatters.items():
        squares[tuple(eps_f_and_load)].append(scatter_of_part.jitter**2)
    runs_with_scatter = [
        (run, replace(scatter_of_part, jitter=float(np.sqrt(np.mean(squares[key[1:]])))))
        for key, scatter_of_part in scatters.items()
        for run in parts[key]
    ]
    names = ("hurst", "eps_f", "eps_t", "seed")
    table = [[run[name] for name in names] for run, _ in runs_with_scatter]
    surface = np.unique(table, axis=0, return_inverse=True)[1]
    log = np.log([run["p_star"] for run, _ in runs_with_scatter])
    sigma = [scatter.relative(run) for run, scatter in runs_with_scatter]
    independent = [
        scatter.grid(run) ** 2 + _solver_sigma(run, observable) ** 2
        for run, scatter in runs_with_scatter
    ]
    shared = np.equal.outer(surface, surface) * np.exp(-LOADS * np.abs(np.subtract.outer(log, log)))
    model = GRID_TERMS[observable][2]
    return shared * np.outer(sigma, sigma) + np.diag(np.array(independent) + model**2)


def _family_columns(parts, powers):
    """Return the columns of the design matrix that belong to single families.

    These are the limit of each family, C_t of those with several sizes of the cell, and powers of
    eps_c for each H and eps_f, also times ln p_star if there are several loads.
    """
    keys = [key for key, part in parts.items() for _ in part]
    runs = [run for part in parts.values() for run in part]
    eps_t, eps_c, log = np.array([(r["eps_t"], r["eps_c"], np.log(r["p_star"])) for r in runs]).T
    limits = [np.array([float(key == family) for key in keys]) for family in parts]
    kinds = [
        np.array([float(key[:2] == kind) for key in keys])
        for kind in dict.fromkeys(family[:2] for family in parts)
    ]
    terms = [1.0, log] if np.ptp(log) > 0 else [1.0]
    return [
        *limits,
        *(mask * eps_t for mask in limits if np.ptp(eps_t[mask > 0]) > 0),
        *(mask * term * eps_c**k for k in powers for mask in kinds for term in terms),
    ]


def _grid_columns(runs, powers, start):
    """Return columns of eps_c^k times smooth functions of H, ln eps_f and ln p_star.

    Higher powers have fewer of them; constant variables have none. start: number of lower powers,
    which belong to families.
    """
    names = ("eps_c", "hurst", "eps_f", "p_star")
    eps_c, hurst, eps_f, p_star = np.array([[run[name] for name in names] for run in runs]).T
    log_eps_f = np.log(eps_f)
    log_load = np.log(p_star)
    n_hurst = min(len(set(hurst)), 3)
    columns = []
    for rank, k in enumerate(powers, start):
        smooth = [hurst**m for m in range(min(n_hurst, 3 if rank == 0 else 2))]
        if np.ptp(log_eps_f) > 0 and rank < 2:
            smooth.append(log_eps_f)
            if rank == 0 and n_hurst > 1:
                smooth.append(hurst * log_eps_f)
        if np.ptp(log_load) > 0 and rank < 2:
            smooth.append(log_load)
        columns += [eps_c**k * term for term in smooth]
    return columns
