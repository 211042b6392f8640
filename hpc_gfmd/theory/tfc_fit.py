"""Fits of the correction terms of eq. tfc to a set of runs, with uncertainties."""

import csv
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.optimize import least_squares

from hpc_gfmd.errors import SceneError, one_line
from hpc_gfmd.theory.checks import within

TERMS = ("t", "f", "c")
PAPER_ALPHA = {"t": 1.0, "f": 0.67, "c": 0.67}  # the exponents of the paper for kappa
_ALPHA_RANGE = (0.02, 5.0)
_STARTS = (0.3, 0.67, 1.5)


@dataclass(frozen=True)
class TfcFit:
    """limit + sum_i C[i] eps_i^alpha[i], fitted.

    limit: value in the TFC limit; C, alpha: dicts over the fitted terms; names: the fitted parameters
    ("limit", "C_t", ..., "alpha_c", ...) in the order of covariance and sigma (dict by name); chi2 with dof
    degrees of freedom. Without error bars of the data the covariance is scaled by chi2/dof, and is nan when
    dof = 0. influence, shape (parameters, runs): how each parameter follows a small change of each value.
    """

    limit: float
    C: dict
    alpha: dict
    names: tuple
    covariance: np.ndarray
    sigma: dict
    chi2: float
    dof: int
    influence: np.ndarray

    def correction(self, eps_t=0.0, eps_f=0.0, eps_c=0.0):
        """(sum of the terms, its uncertainty) at the given ratios; a term that was not fitted is zero."""
        eps = {"t": eps_t, "f": eps_f, "c": eps_c}
        eps = {i: float(within(f"eps_{i}", eps[i], 0, 1)) for i in TERMS}
        power = {i: eps[i] ** a if eps[i] > 0 else 0.0 for i, a in self.alpha.items()}
        gradient = {f"C_{i}": power[i] for i in power}
        gradient |= {f"alpha_{i}": self.C[i] * power[i] * np.log(eps[i] or 1) for i in power}
        vector = np.array([gradient.get(name, 0.0) for name in self.names])
        return sum(self.C[i] * power[i] for i in power), float(
            np.sqrt(max(vector @ self.covariance @ vector, 0))
        )

    def row(self, hurst):
        """The fit as a row of a coefficient table (see data/paper_tfc.json); terms that were not fitted get C
        = 0."""
        numbers = {f"C_{i}": self.C.get(i, 0.0) for i in TERMS} | {
            f"alpha_{i}": self.alpha.get(i, 1.0) for i in TERMS
        }
        return {
            "hurst": hurst,
            **numbers,
            "limit": self.limit,
            "sigma": self.sigma,
            "names": list(self.names),
            "covariance": self.covariance.tolist(),
        }


def fit_tfc(eps_t, eps_f, eps_c, value, sigma=None, alpha=None, terms=TERMS, limit=None):
    """Least-squares fit of eq. tfc to runs, a TfcFit.

    eps_t, eps_f, eps_c, value, sigma: shape (runs,) (the ratios and sigma may be single numbers); sigma:
    error bars of value, or their covariance matrix, shape (runs, runs), where runs share a surface. limit: a
    known value in the TFC limit, fitted if None. alpha: fixed exponents by term, e.g. {"t": 1, "f": 0.67, "c": None}, where None
    leaves the exponent free (0.02 to 5); a term left out has the paper's (1, 0.67, 0.67). terms: the terms to
    include. SceneError when the runs cannot determine what is asked (too few, or a ratio that does not vary
    enough).
    """
    value = np.atleast_1d(within("value", value, -np.inf, np.inf))
    eps = {
        i: np.broadcast_to(within(f"eps_{i}", e, 0, 1, open_low=True), value.shape)
        for i, e in zip(TERMS, (eps_t, eps_f, eps_c), strict=True)
        if i in terms
    }
    whiten = _whitening(sigma, value.size)
    alpha = {i: (PAPER_ALPHA | dict(alpha or {}))[i] for i in eps}
    free = [i for i in eps if alpha[i] is None]
    for i in alpha:
        if alpha[i] is not None:
            alpha[i] = float(within(f"alpha_{i}", alpha[i], 0, 10, open_low=True))
    for i in eps:
        needed = 3 if i in free else 2
        if np.unique(eps[i]).size < needed:
            raise SceneError(
                f"eps_{i}: found {np.unique(eps[i]).size} different values, allowed: at least {needed} "
                f"to fit {'C and alpha' if i in free else 'C'}, or leave the term {i} out"
            )
    fixed = None if limit is None else float(within("limit", limit, -np.inf, np.inf))
    first = int(fixed is None)  # where the C begin among the parameters
    names = ("limit",)[:first] + (*(f"C_{i}" for i in eps), *(f"alpha_{i}" for i in free))
    target = value - (fixed or 0.0)
    if value.size < len(names):
        raise SceneError(
            f"runs: found {value.size}, allowed: at least {len(names)}, the number of fitted parameters"
        )

    def matrix(exponents):
        columns = [np.ones_like(value)][:first] + [eps[i] ** exponents[i] for i in eps]
        return np.stack(columns, axis=1)

    linear = first + len(eps)

    def residual(x):
        exponents = alpha | dict(zip(free, x[linear:], strict=True))
        return whiten @ (matrix(exponents) @ x[:linear] - target)

    x = _best_start(target, whiten, matrix, alpha, free)
    if free:
        low = np.concatenate([np.full(linear, -np.inf), np.full(len(free), _ALPHA_RANGE[0])])
        high = np.where(np.isinf(low), np.inf, _ALPHA_RANGE[1])
        x = least_squares(
            residual, x, bounds=(low, high), x_scale="jac", xtol=1e-14, ftol=1e-14, gtol=1e-14
        ).x
    C = dict(zip(eps, x[first:], strict=False))
    alpha = alpha | dict(zip(free, x[linear:], strict=True))

    columns = [matrix(alpha), *((C[i] * eps[i] ** alpha[i] * np.log(eps[i]))[:, None] for i in free)]
    jacobian = whiten @ np.concatenate(columns, axis=1)
    scale = np.linalg.norm(jacobian, axis=0)
    if not scale.all() or np.linalg.cond(jacobian / scale) > 1e8:
        raise SceneError(
            "runs: found ratios that vary together, or no trend, allowed: runs that determine every term"
        )
    inverse = np.linalg.pinv(jacobian / scale) / scale[:, None]
    covariance = inverse @ inverse.T
    chi2, dof = float(np.sum(residual(x) ** 2)), value.size - len(names)
    if sigma is None:
        covariance = covariance * (chi2 / dof if dof else np.nan)
    errors = dict(zip(names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    return TfcFit(
        float(x[0]) if first else fixed,
        {i: float(C[i]) for i in C},
        {i: float(alpha[i]) for i in alpha},
        names,
        covariance,
        errors,
        chi2,
        dof,
        inverse @ whiten,
    )


def _whitening(sigma, runs):
    """The matrix that turns the values into ones of unit variance and no correlation."""
    if sigma is None:
        return np.eye(runs)
    if np.ndim(sigma) < 2:
        return np.diag(1 / np.broadcast_to(within("sigma", sigma, 0, np.inf, open_low=True), (runs,)))
    try:
        root = np.linalg.cholesky(np.asarray(sigma, dtype=float).reshape(runs, runs))
    except (ValueError, np.linalg.LinAlgError):
        raise SceneError(f"sigma: found shape {np.shape(sigma)}, allowed: a covariance matrix of the {runs} runs") from None
    return np.linalg.inv(root)


def _best_start(value, whiten, matrix, alpha, free):
    """The best linear fit over a few choices of the free exponents; the fit itself where none is free."""
    best = None
    for guess in product(_STARTS, repeat=len(free)):
        m = whiten @ matrix(alpha | dict(zip(free, guess, strict=True)))
        x = np.linalg.lstsq(m, whiten @ value, rcond=None)[0]
        cost = np.sum((m @ x - whiten @ value) ** 2)
        if best is None or cost < best[0]:
            best = cost, np.concatenate([x, guess])
    return best[1]


def read_runs(path):
    """Columns eps_t, eps_f, eps_c, value and, if there, sigma of a CSV file with a header, as a dict of
    arrays for fit_tfc."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        wanted = ["eps_t", "eps_f", "eps_c", "value"] + (["sigma"] if rows and "sigma" in rows[0] else [])
        return {name: np.array([float(row[name]) for row in rows]) for name in wanted}
    except (OSError, ValueError, KeyError, TypeError, csv.Error) as error:
        raise SceneError(
            f"runs: found {str(path)!r} ({one_line(str(error))}), allowed: a CSV file with the columns "
            "eps_t, eps_f, eps_c, value and maybe sigma"
        ) from None
