"""From runs to numbers with standard errors: means over realisations, power laws, the coefficients
of eq. tfc, limits.

One surface is solved on several grids and at several pressures, and the surfaces of a seed at
neighbouring lam_l/lam_s share their long waves. What a realisation adds is therefore common to many
runs and cancels in differences: fits that know the covariance (Scatter) are fits of paired
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
from hpc_gfmd.theory.least_squares import least_squares
from hpc_gfmd.theory.tfc_fit import PAPER_ALPHA, TfcFit, fit_tfc

from .cases import CATALOGUE
from .rows import Rows, families, fine_half, groups, longest, near

COLUMNS = (
    *("hurst", "p_star", "L_over_lam_l", "lam_l_over_lam_s", "lam_s_over_a"),
    *("eps_t", "eps_f", "eps_c", "n"),
)
SOLVER_SHARE = 0.2  # of the solver's error estimate is one sigma: it is nearly an upper bound
POWER_LAW = (0.1, 4.5)  # exponents that a series along eps_c can have; others are ends of a search
JACKKNIFE = 20  # groups of realisations, left out one after the other


def jackknife(of: Callable[[np.ndarray], ArrayLike], count: int) -> tuple[np.ndarray, np.ndarray]:
    """Compute (of(all), its standard errors) of a function of the indices of `count` surfaces."""
    everyone = np.arange(count)
    parts = np.array_split(everyone, min(count, JACKKNIFE))
    whole = np.asarray(of(everyone))
    if count < 2:
        return whole, np.full_like(whole, np.nan)
    left: Any = [of(np.delete(everyone, part)) for part in parts]
    return whole, np.sqrt((len(parts) - 1) * np.var(left, axis=0))


def weighted(values: ArrayLike, errors: ArrayLike) -> tuple[float, float]:
    """Compute (mean, standard error), enlarged where values differ by more than their errors."""
    value, weight = np.asarray(values), np.asarray(errors) ** -2.0
    mean = float(np.average(value, weights=weight))
    chi2 = float(np.sum(weight * (value - mean) ** 2)) / max(value.size - 1, 1)
    return mean, float(np.sqrt(max(1.0, chi2) / np.sum(weight)))


def power_law(rows: Rows, x: str, y: str, cov: Any = "unscaled") -> tuple[Any, Any]:
    """Compute (exponent, standard error) of a straight line through logarithms, by the errors y_se.

    (None, None) of fewer than three values of x. cov: "unscaled", or True to scale the errors by
    how well the line fits.
    """
    rows = [row for row in rows if row.get(y) and row[y] > 0]
    if len({row[x] for row in rows}) < 3:
        return None, None
    at, value, error = (np.array([row.get(k) or 0.0 for row in rows]) for k in (x, y, f"{y}_se"))
    weight = value / np.where(error > 0, error, 1e-3 * value)
    line, covariance = np.polyfit(np.log(at), np.log(value), 1, w=weight, cov=cov)
    return float(line[0]), float(np.sqrt(covariance[0, 0]))


@dataclass(frozen=True)
class Scatter:
    """Relative scatter of one observable at one H and p*.

    law: (a, b) of the relative standard deviation eps_t exp(a) eps_f^b, None where no group has two
    seeds; it falls as eps_t, because a cell of side L holds 1/eps_t^2 cells of side lam_l. jitter:
    what a grid adds, at eps_t = eps_f = eps_c = 1; it falls as eps_t eps_f, because contacts of
    size lam_s meet it one by one. memory: correlation of one seed's deviations at eps_f and
    eps_f/2.
    """

    law: tuple | None
    jitter: float
    memory: float

    @classmethod
    def of(cls, runs: Rows, observable: str) -> Self:
        """Find it from runs at one H and p* that differ in seed and ratios."""
        alike = groups(runs, "eps_t", "eps_f", "eps_c")
        points = []
        deviations: dict[tuple, dict] = defaultdict(dict)
        for (eps_t, eps_f, eps_c), group in alike.items():
            values = np.array([run[observable] for run in group])
            if len(group) < 2 or values.mean() == 0:
                continue
            relative, dof = values / values.mean() - 1, len(group) - 1
            points.append((np.log(eps_f), np.sum(relative**2) / dof / eps_t**2, dof))
            if len(group) >= 4:
                for run, x in zip(group, relative / np.sqrt(np.mean(relative**2) or 1)):
                    deviations[eps_t, eps_c, run["seed"]][np.log2(eps_f)] = x
        return cls(_law(points), _jitter(alike, observable), _memory(deviations))

    def relative(self, run: dict) -> float:
        """Compute the standard deviation of one realisation over the mean; nan if not known."""
        if not self.law:
            return np.nan
        return float(np.exp(self.law[0]) * run["eps_f"] ** self.law[1] * run["eps_t"])

    def grid(self, run: dict) -> float:
        """Compute the same of what the grid of a run adds to what all grids of its surface have."""
        return self.jitter * run["eps_t"] * run["eps_f"] * run["eps_c"]

    def covariance(self, runs: Rows, observable: str) -> np.ndarray:
        """Compute the covariance of runs, (runs, runs): realisation (shared), grid and solver."""
        value = np.array([run[observable] for run in runs])
        sigma = value * [self.relative(run) for run in runs]
        octaves = np.log2([run["eps_f"] for run in runs])
        apart = np.abs(np.subtract.outer(octaves, octaves))
        seed, eps_t = np.array([(run["seed"], run["eps_t"]) for run in runs]).T
        same = np.equal.outer(seed, seed) & np.equal.outer(eps_t, eps_t)
        shared = np.where(same, self.memory**apart, 0.0) * np.outer(sigma, sigma)
        alone = [self.grid(run) ** 2 + _solver(run, observable) ** 2 for run in runs]
        return shared + np.diag(value**2 * alone)


def _solver(run, observable):
    error = "a_r_error" if observable.startswith(("kappa", "a_r")) else "gap_error"
    return SOLVER_SHARE * run[error]


def _law(points):
    """Fit a line through the logarithms of the variances, by their degrees of freedom."""
    points = [point for point in points if point[1] > 0]
    if not points:
        return None
    at, variance, dof = np.array(points).T
    log = np.log(variance) - digamma(dof / 2) + np.log(dof / 2)  # of a sample it is too small
    slope = np.polyfit(at, log, 1, w=np.sqrt(dof))[0] if len(set(at)) > 2 else 0.0
    return float(np.average(log - slope * at, weights=dof) / 2), float(slope / 2)


def _jitter(alike, observable):
    squares, dof = 0.0, 0
    for (eps_t, eps_f, eps_c), group in alike.items():
        coarser = {run["seed"]: run[observable] for run in alike.get((eps_t, eps_f, 2 * eps_c), ())}
        pairs = [(run[observable], coarser.get(run["seed"])) for run in group]
        ratio = np.array([fine / coarse for fine, coarse in pairs if coarse is not None])
        if len(ratio) > 1:  # 5 = 1 + 2^2: both grids
            scale = 5 * (eps_t * eps_f * eps_c) ** 2
            squares += np.sum((ratio / ratio.mean() - 1) ** 2) / scale
            dof += len(ratio) - 1
    return float(np.sqrt(squares / dof)) if dof else 0.0


def _memory(deviations):
    """Average the products of a seed's normalised deviations one octave apart."""
    products = [
        x * series[at - 1]
        for series in deviations.values()
        for at, x in series.items()
        if at - 1 in series
    ]
    return float(np.clip(np.mean(products), 0.0, 0.99)) if products else 0.0


def average(runs: Rows, *observables: str) -> Rows:
    """Average over realisations: a row per surface statistics and pressure, ordered.

    COLUMNS, n_seeds and, for each observable, its mean and NAME_se: the scatter of realisations
    (Scatter) over sqrt(n_seeds); None where no group had two seeds. Surfaces that are solved on
    several grids, some of them for fewer seeds, are averaged as ratios to the grid with most seeds,
    so that means along eps_c do not jump with the choice of seeds.
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
    """Average over seeds; base: the same surfaces, and more, on another grid."""
    square, mean = scatter.relative(part[0]) ** 2, np.mean([run[name] for run in part])
    seeds = {run["seed"] for run in part}
    shared = [run[name] for run in base if run["seed"] in seeds]
    if len(base) > len(part) == len(shared):
        mean *= np.mean([run[name] for run in base]) / np.mean(shared)
        grids = sum(scatter.grid(one[0]) ** 2 for one in (part, base))
        square = square / len(base) + grids / len(part)
    else:
        square /= len(part)
    return float(mean), float(abs(mean) * np.sqrt(square)) if np.isfinite(square) else None


def along_c(runs: Rows, level: str) -> Rows:
    """Choose the longest series along eps_c, at the reference L/lam_l."""
    L, _, _ = CATALOGUE["reference"][level]
    return longest([run for run in runs if near(run["L_over_lam_l"], L)], "eps_c")


def fit_runs(
    runs: Rows, observable: str, scatter: Scatter, alpha: dict, limit: float | None = None
) -> TfcFit:
    """Fit eq. tfc, theory.tfc_fit.fit_tfc, to runs at one H and p* with their covariance.

    alpha: the exponents of the terms, None for free ones. Errors are enlarged where the law does
    not fit within them.
    """
    eps_t, eps_f, eps_c, value = (
        [run[name] for run in runs] for name in ("eps_t", "eps_f", "eps_c", observable)
    )
    sigma = scatter.covariance(runs, observable)
    fit = fit_tfc(eps_t, eps_f, eps_c, value, sigma, alpha, terms=alpha, limit=limit)
    scale = max(1.0, fit.chi2 / fit.dof) if fit.dof else 1.0
    return replace(fit, covariance=fit.covariance * scale)


def known_scatter(runs: Rows, observable: str) -> Scatter:
    """Find the Scatter. Raises SceneError where it is not known."""
    scatter = Scatter.of(runs, observable)
    if scatter.law is None:
        raise SceneError("runs: found one realisation of each surface, allowed: two of some")
    return scatter


def fit_observable(runs: Rows, observable: str, level: str, printed: bool = False) -> TfcFit:
    """Fit eq. tfc on the axes through the reference system, as the paper does.

    kappa has a free limit; that of the gap in units of h_rms is zero, and its fit is over the finer
    half of the octaves of eps_f. printed: with the paper's exponents 1, 0.67, 0.67 (gap: 1, free,
    1). Otherwise alpha_t = 1, alpha_f is fitted, alpha_c is that of the longest eps_c series, and
    the uncertainty of both is in the covariance.
    """
    scatter, limit = known_scatter(runs, observable), None
    L, F, C = CATALOGUE["reference"][level]
    chosen = [
        run
        for run in runs
        if near(run["lam_s_over_a"], C)
        or (near(run["L_over_lam_l"], L) and near(run["lam_l_over_lam_s"], F))
    ]
    if observable.startswith("gap"):
        chosen, limit = fine_half(chosen), 0.0

    def fit_at(alpha_c, alpha_f=None):
        alpha = {"t": 1.0, "f": alpha_f, "c": alpha_c}
        return fit_runs(chosen, observable, scatter, alpha, limit)

    if printed:
        return fit_at(1.0) if limit == 0 else fit_at(PAPER_ALPHA["c"], PAPER_ALPHA["f"])
    along = fit_runs(along_c(runs, level), observable, scatter, {"c": None})
    alpha_c, sigma = along.alpha["c"], along.sigma["alpha_c"]
    if not (POWER_LAW[0] < alpha_c < POWER_LAW[1] and sigma < alpha_c):
        raise SceneError(f"alpha_c: found {alpha_c:.2f} ± {sigma:.2f}, allowed: a power law")
    best, step = fit_at(alpha_c), 0.1 * sigma
    more, less = (values_of(fit_at(alpha_c + by)) for by in (step, -step))
    moved = more - less
    direction = np.append(moved / 0.2, sigma)  # when alpha_c is larger by its error
    covariance = np.pad(best.covariance, (0, 1)) + np.outer(direction, direction)
    return replace(best, names=(*best.names, "alpha_c"), covariance=covariance)


def values_of(fit: TfcFit) -> np.ndarray:
    """Return the fitted parameters in the order of names."""
    row = fit.row(0.0)
    return np.array([row[name] for name in fit.names])


def local_exponents(runs: Rows, observable: str, level: str) -> Rows:
    """Find alpha_c between neighbouring octaves of the longest eps_c series, by paired differences.

    Rows eps_c (the middle grid of three), alpha, alpha_se (jackknife over three seeds or more, and
    solver), n_seeds; alpha None where the differences change sign.
    """
    series = groups(along_c(runs, level), "lam_s_over_a")
    grids = {c: {run["seed"]: run for run in part} for c, part in series.items()}
    rows = []
    for c in grids:
        trio = [grids.get(c / 2, {}), grids[c], grids.get(2 * c, {})]
        if seeds := sorted(set.intersection(*map(set, trio))):
            value, error = (
                np.array([[of(grid[seed], observable) for grid in trio] for seed in seeds])
                for of in (dict.get, _solver)
            )
            noise = np.sqrt(np.mean((value * error) ** 2, axis=0) / len(seeds))
            alpha, sigma = _log_ratio(-np.diff(value, axis=1), noise)
            rows.append({"eps_c": 1 / c, "alpha": alpha, "alpha_se": sigma, "n_seeds": len(seeds)})
    return rows


def _log_ratio(steps, solver):
    """Compute log2 of the ratio of mean steps, (seeds, 2); solver: errors of the three means."""
    first, second = steps.mean(axis=0)
    if not first * second > 0:
        return None, None

    def exponent(some):
        ratio = np.divide(*steps[some].mean(axis=0))
        return np.log2(ratio) if ratio > 0 else np.nan

    alpha, sigma = jackknife(exponent, len(steps))
    slopes = np.array([1 / first, -1 / first - 1 / second, 1 / second]) / np.log(2)
    sigma = np.hypot(sigma if len(steps) > 2 else 0.0, np.linalg.norm(slopes * solver))
    return float(alpha), float(sigma) if np.isfinite(sigma) else None


# kappa in the limit of large cells, many decades of roughness and fine grids


ROUTES = ("kappa", "kappa_edge")  # as counted, edge-corrected
ALPHA_F = (0.1, 3.0)  # what is tried
AGREE = 6.6  # chi2 by which 2 - 2H may be worse than the best exponent: a chance of one per cent


def fit_limit(runs: Rows, observable: str, scatter: Scatter, alpha_f: float | None) -> dict:
    """Fit kappa by one route, at one H and p*, with a given alpha_f or a free one.

    The corrections of eq. tfc do not simply add up: a coarse grid enlarges the fractal correction.
    The model is therefore

        kappa_TFC + C_t eps_t + (C_f + D eps_c) eps_f^alpha_f
            + C_1 eps_c + C_2 eps_c^2 + C_3 eps_c^3,

    eq. tfc with the product that the data demand, and with a Taylor series in eps_c: the contact of
    a surface that is smooth below lam_s has a boundary of finite length, so the excess of counted
    grid points is linear in eps_c for eps_c -> 0. Columns kappa, kappa_se (enlarged where the model
    does not fit), alpha_f, alpha_f_se, chi2, dof. Raises SceneError for what is not determined.
    """
    errors = scatter.covariance(runs, observable)
    value, t, f, c = np.array(
        [[run[k] for k in (observable, "eps_t", "eps_f", "eps_c")] for run in runs]
    ).T
    free = alpha_f is None
    count = 8 if free else 7

    def design(x):
        power = f ** (x[7] if free else alpha_f)
        return np.stack([np.ones_like(f), t, power, power * c, c, c**2, c**3], axis=1)

    def jacobian(x):
        terms = design(x)
        return np.column_stack([terms, terms[:, 2:4] @ x[2:4] * np.log(f)])[:, :count]

    start = np.array([2.0, 0.0, 2.0, 0.0, 1.0, 0.0, 0.0, 0.7])[:count]
    low, high = np.full(count, -np.inf), np.full(count, np.inf)
    low[7:], high[7:] = ALPHA_F
    found = least_squares(
        lambda x: design(x) @ x[:7], jacobian, [start], value, errors, (low, high)
    )
    dof = len(runs) - count
    sigma = np.sqrt(np.diag(found.covariance) * max(1.0, found.chi2 / dof))
    return {
        "kappa": float(found.x[0]),
        "kappa_se": float(sigma[0]),
        "alpha_f": float(found.x[7]) if free else alpha_f,
        "alpha_f_se": float(sigma[7]) if free else None,
        "chi2": found.chi2,
        "dof": dof,
    }


def limits(runs: Rows) -> Rows:
    """Find kappa in the limit: the one estimate that all tables and pictures show.

    Both ways to count the area must meet, and alpha_f is a property of neither: kappa_tfc is their
    mean, with alpha_f = 2 - 2H where that agrees with what both find, else with what they find. The
    coarsest third of the octaves of eps_f is left out, where no power law reaches. kappa_tfc_se
    holds realisations and solver, half the difference of the routes, what one octave less changes
    and, where the exponents disagree, half of what that does. A row for each H and p*: hurst,
    p_star, kappa_tfc, counted, edge, alpha_f (what both find), agrees; none of too few runs.
    """
    rows = []
    for _, _, part in families(runs):
        try:
            rows.append(_limit(part))
        except SceneError:
            continue
    return rows


def _limit(runs):
    octaves, hurst = sorted({run["eps_f"] for run in runs}), runs[0]["hurst"]
    expected, out = float(np.clip(2 - 2 * hurst, *ALPHA_F)), len(octaves) // 3
    scatter = {name: known_scatter(runs, name) for name in ROUTES}

    def fit(exponent, out=out):
        chosen = [run for run in runs if run["eps_f"] <= octaves[-1 - out]]
        return [fit_limit(chosen, name, of, exponent) for name, of in scatter.items()]

    free, fixed = fit(None), fit(expected)
    worse = [(b["chi2"] - a["chi2"]) / max(1.0, a["chi2"] / a["dof"]) for a, b in zip(free, fixed)]
    agrees = max(worse) < AGREE
    ours, other = (fixed, free) if agrees else (free, fixed)
    counted, edge = (one["kappa"] for one in ours)
    kappa, not_ours = (float(np.mean([x["kappa"] for x in some])) for some in (ours, other))
    try:
        less = np.mean([one["kappa"] for one in fit(expected if agrees else None, out + 1)])
    except SceneError:  # too few octaves
        less = kappa
    errors = [max(one["kappa_se"] for one in ours), (counted - edge) / 2, less - kappa]
    errors.append(0.0 if agrees else (not_ours - kappa) / 2)
    alpha, alpha_se = np.array([(one["alpha_f"], one["alpha_f_se"]) for one in free]).T
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


# an observable in the limit of fine grids and large cells at given H, eps_f and pressure


# powers of eps_c: of every family, common to all (counted points exceed by the length of the
# contact boundary); relative: how well the common terms describe what the grid does
GRID_TERMS: dict[str, tuple] = {
    "kappa": ((1,), (2, 3), 1e-6),
    "kappa_edge": ((), (1, 2, 3), 1e-6),
    "gap_over_h_rms": ((), (3, 4), 2e-4),
}
LOADS = 0.25  # what realisations add is correlated by (p/p')^LOADS at the loads p < p' of a surface


def continuum(runs: Rows, observable: str) -> dict[tuple, tuple]:
    """Find {(H, eps_f, p_star): (limit, standard error)} of all runs together.

        ln value = ln limit + C_t eps_t + C_1 eps_c + sum over k of eps_c^k (smooth function of H,
        ln eps_f, ln p_star)

    by generalised least squares, with a limit and C_t for each H, eps_f and p_star, C_1 (linear in
    ln p_star) for each H and eps_f. The grid sees single contacts, which hardly know of H, eps_f
    and a small load; what it does is therefore common to all of them (but for C_1 of the area as
    counted), and known well even where one surface has few contacts. Errors are enlarged where the
    model does not fit within them. Raises SceneError where a value is zero, the scatter not known,
    or a term not determined.
    """
    parts = groups(runs, "hurst", "eps_f", "p_star")
    runs = [run for part in parts.values() for run in part]
    value = np.array([run[observable] for run in runs])
    if not runs or not (value > 0).all():
        raise SceneError(f"{observable}: found no runs or zeros, allowed: positive values")
    errors = _covariance(parts, observable)
    own, common, _ = GRID_TERMS[observable]
    grids = len({run["eps_c"] for run in runs})
    common = common[: max(1, grids - 1 - len(own))]  # as many as the grids can tell
    design = np.column_stack([*_of_families(parts, own), *_of_grids(runs, common, len(own))])
    whiten = np.linalg.inv(np.linalg.cholesky(errors))
    white, target = whiten @ design, whiten @ np.log(value)
    scale = np.linalg.norm(white, axis=0)
    found, _, rank, _ = np.linalg.lstsq(white / scale, target, rcond=1e-9)
    if rank < len(found):
        raise SceneError("runs: found too few grids or cells, allowed: as many as there are powers")
    dof = len(value) - len(found)
    chi2 = np.sum((target - white / scale @ found) ** 2) / max(dof, 1)
    variance = np.diag(np.linalg.inv((white / scale).T @ (white / scale))) * max(1.0, chi2)
    limit = np.exp(found / scale)
    sigma = limit * np.sqrt(variance) / scale
    return {key: (float(v), float(s)) for key, v, s in zip(parts, limit, sigma)}


def _covariance(parts, observable):
    """Compute the relative covariance of all runs.

    What a grid adds is alike for all H, of each of which few surfaces were solved on several grids:
    the root mean square. It is not correlated at different loads. At neighbouring H of a seed it is
    (by 0.7 at 0.7 and 0.8): left out here, which makes errors a tenth too small.
    """
    scatter = {key: known_scatter(part, observable) for key, part in parts.items()}
    squares: dict[tuple, list[float]] = defaultdict(list)
    for (_, *rest), one in scatter.items():
        squares[tuple(rest)].append(one.jitter**2)
    each = [
        (run, replace(one, jitter=float(np.sqrt(np.mean(squares[key[1:]])))))
        for key, one in scatter.items()
        for run in parts[key]
    ]
    names = ("hurst", "eps_f", "eps_t", "seed")
    table = [[run[name] for name in names] for run, _ in each]
    surface = np.unique(table, axis=0, return_inverse=True)[1]
    log = np.log([run["p_star"] for run, _ in each])
    sigma = [one.relative(run) for run, one in each]
    alone = [one.grid(run) ** 2 + _solver(run, observable) ** 2 for run, one in each]
    shared = np.equal.outer(surface, surface) * np.exp(-LOADS * np.abs(np.subtract.outer(log, log)))
    model = GRID_TERMS[observable][2]
    return shared * np.outer(sigma, sigma) + np.diag(np.array(alone) + model**2)


def _of_families(parts, powers):
    """Make columns for the limit of each family, for its C_t where its cells differ, and for each
    of its own powers of eps_c for each H and eps_f (two where there are several loads)."""
    keys = [key for key, part in parts.items() for _ in part]
    runs = [run for part in parts.values() for run in part]
    eps_t, eps_c, log = np.array([(r["eps_t"], r["eps_c"], np.log(r["p_star"])) for r in runs]).T
    limits = [np.array([float(key == one) for key in keys]) for one in parts]
    kinds = [
        np.array([float(key[:2] == one) for key in keys])
        for one in dict.fromkeys(k[:2] for k in parts)
    ]
    terms = [1.0, log] if np.ptp(log) > 0 else [1.0]
    return [
        *limits,
        *(mask * eps_t for mask in limits if np.ptp(eps_t[mask > 0]) > 0),
        *(mask * term * eps_c**k for k in powers for mask in kinds for term in terms),
    ]


def _of_grids(runs, powers, start):
    """Make columns of eps_c^k times smooth functions of H, ln eps_f and ln p_star, the fewer the
    higher the power, as far as they differ. start: number of powers below."""
    names = ("eps_c", "hurst", "eps_f", "p_star")
    eps_c, hurst, eps_f, p_star = np.array([[run[name] for name in names] for run in runs]).T
    log, load = np.log(eps_f), np.log(p_star)
    several, varied = min(len(set(hurst)), 3), np.ptp(log) > 0
    columns = []
    for rank, k in enumerate(powers, start):
        smooth = [hurst**m for m in range(min(several, 3 if rank == 0 else 2))]
        if varied and rank < 2:
            smooth += [log, *([hurst * log] if rank == 0 and several > 1 else [])]
        if np.ptp(load) > 0 and rank < 2:
            smooth.append(load)
        columns += [eps_c**k * term for term in smooth]
    return columns
