"""Fits of the correction terms of eq. tfc to a set of runs, with uncertainties."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from hpc_gfmd import SceneError
from hpc_gfmd.theory.checks import within
from hpc_gfmd.theory.tfc import TERMS, ratios, sigma_of_terms, slopes, term

from .least_squares import least_squares

PAPER_ALPHA = {"t": 1.0, "f": 0.67, "c": 0.67}  # the exponents of the paper for kappa
_ALPHA_RANGE = (0.02, 5.0)
_STARTS = (0.3, 0.67, 1.5)


@dataclass(frozen=True)
class TfcFit:
    """A fit of limit + sum_i C[i] eps_i^alpha[i].

    Attributes
    ----------
    limit : float
        Value in the TFC limit.
    C, alpha : dict
        Coefficients and exponents by term ("t", "f", "c"), of the fitted terms only.
    names : tuple of str
        The fitted parameters ("limit", "C_t", ..., "alpha_c", ...) in the order of covariance.
    covariance : array, shape (parameters, parameters)
        Covariance of the fitted parameters. If the data have no error bars it is scaled by
        chi2/dof, and nan if dof = 0.
    chi2, dof : float, int
        Weighted sum of squares and its degrees of freedom.
    """

    limit: float
    C: dict
    alpha: dict
    names: tuple
    covariance: np.ndarray
    chi2: float
    dof: int

    @cached_property
    def sigma(self) -> dict:
        """The standard errors of the fitted parameters, by name."""
        return dict(zip(self.names, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    def correction(
        self, eps_t: float = 0.0, eps_f: float = 0.0, eps_c: float = 0.0
    ) -> tuple[float, float]:
        """Compute the sum of the fitted terms at these ratios, and its uncertainty.

        Parameters
        ----------
        eps_t, eps_f, eps_c : float
            Thermodynamic, fractal and continuum ratio, from 0 to 1. A term that was not fitted
            contributes 0.

        Returns
        -------
        total, sigma : float
            The sum, to be subtracted from a simulated value, and its standard deviation.
        """
        eps = ratios(eps_t, eps_f, eps_c)
        row = self.row(0.0)
        return sum(term(row, i, eps[i]) for i in TERMS), sigma_of_terms(row, eps)

    def row(self, hurst: float) -> dict:
        """Return the fit as a row of a coefficient table (see data/paper_tfc.json).

        hurst: the Hurst exponent of the runs. Terms that were not fitted get C = 0, alpha = 1.
        """
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


def fit_tfc(
    eps_t: ArrayLike,
    eps_f: ArrayLike,
    eps_c: ArrayLike,
    value: ArrayLike,
    sigma: ArrayLike | None = None,
    alpha: Mapping | None = None,
    terms: Iterable[str] = TERMS,
    limit: float | None = None,
) -> TfcFit:
    """Fit eq. tfc to the results of several runs by least squares.

    Parameters
    ----------
    eps_t, eps_f, eps_c : arrays, shape (runs,), or numbers
        Thermodynamic, fractal and continuum ratio of each run, above 0 and at most 1; those of
        terms that are not fitted are ignored.
    value : array, shape (runs,)
        The simulated observable.
    sigma : number or array, optional
        Error bars of value, shape (runs,), or their covariance matrix, shape (runs, runs), if runs
        share a surface. If None, errors follow from the scatter of the fit.
    alpha : dict, optional
        Exponents by term, above 0 and at most 10, e.g. {"t": 1, "f": 0.67, "c": None}. None means
        that the exponent is fitted (0.02 to 5); a term that is absent has the paper's exponent.
    terms : iterable of str
        The terms to fit, of "t", "f", "c".
    limit : float, optional
        A known value in the TFC limit; fitted if None.

    Returns
    -------
    TfcFit

    Raises
    ------
    SceneError
        If the runs do not determine every parameter (too few runs, or a ratio that does not vary
        enough), a number is out of range, or a term is unknown.
    """
    terms = tuple(terms)
    for name, letters in (("terms", terms), ("alpha", tuple(alpha or ()))):
        if set(letters) - set(TERMS):
            text = "".join(map(str, letters))
            raise SceneError(f"{name}: found {text!r}, allowed: letters of tfc")
    value = np.atleast_1d(within("value", value, -np.inf, np.inf))
    eps = {
        i: np.broadcast_to(within(f"eps_{i}", e, 0, 1, open_low=True), value.shape)
        for i, e in zip(TERMS, (eps_t, eps_f, eps_c), strict=True)
        if i in terms
    }
    fixed = {} if limit is None else {"limit": float(within("limit", limit, -np.inf, np.inf))}
    wanted = PAPER_ALPHA | dict(alpha or {})
    for i in eps:
        if wanted[i] is not None:
            fixed[f"alpha_{i}"] = float(within(f"alpha_{i}", wanted[i], 0, 10, open_low=True))
    every = ("limit", *(f"{kind}_{i}" for kind in ("C", "alpha") for i in eps))
    names = tuple(name for name in every if name not in fixed)
    free = [name for name in names if name.startswith("alpha")]
    _enough(value, eps, free, names)
    if sigma is not None and np.ndim(sigma) < 2:
        sigma = np.broadcast_to(within("sigma", sigma, 0, np.inf, open_low=True), value.shape)

    def law(x: np.ndarray) -> dict[str, float]:
        return fixed | dict(zip(names, x, strict=True))

    def model(x: np.ndarray) -> np.ndarray:
        row = law(x)
        return row["limit"] + sum(term(row, i, eps[i]) for i in eps)

    def jacobian(x: np.ndarray) -> np.ndarray:
        derivatives = slopes(law(x), eps)
        columns = [np.broadcast_to(derivatives[name], value.shape) for name in names]
        return np.stack(columns, axis=1)

    starts = []
    for guess in product(_STARTS, repeat=len(free)):
        x = np.append(np.zeros(len(names) - len(free)), guess)
        # the law is linear in the parameters that stand first
        linear = jacobian(x)[:, : len(names) - len(free)]
        x[: linear.shape[1]] = np.linalg.lstsq(linear, value - model(x), rcond=None)[0]
        starts.append(x)
    bounds = np.array([_ALPHA_RANGE if name in free else (-np.inf, np.inf) for name in names]).T
    best = least_squares(model, jacobian, starts, value, sigma, bounds)
    dof = value.size - len(names)
    covariance = best.covariance
    if sigma is None:
        covariance = covariance * (best.chi2 / dof if dof else np.nan)
    row = law(best.x.tolist())
    C = {i: row[f"C_{i}"] for i in eps}
    exponents = {i: row[f"alpha_{i}"] for i in eps}
    return TfcFit(row["limit"], C, exponents, names, covariance, best.chi2, dof)


def _enough(value: np.ndarray, eps: dict, free: list, names: tuple) -> None:
    """Raise SceneError if there are too few runs or too few different values of a ratio.

    eps: ratios of the runs by term. names, free: all fitted parameters, and the fitted exponents. A
    term with a fitted exponent needs three different ratios, others two.
    """
    for i, values in eps.items():
        needed = 3 if f"alpha_{i}" in free else 2
        number = np.unique(values).size
        if number < needed:
            raise SceneError(
                f"eps_{i}: found {number} different values, allowed: at least {needed} to fit "
                f"{'C and alpha' if needed == 3 else 'C'}, or leave the term {i} out"
            )
    if value.size < len(names):
        raise SceneError(
            f"runs: found {value.size}, allowed: at least {len(names)}, the number of fitted"
            " parameters"
        )
