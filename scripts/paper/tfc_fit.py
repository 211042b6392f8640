"""Least squares with a covariance, and fits of the correction terms of eq. tfc to a set of runs."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import curve_fit

from hpc_gfmd import SceneError
from hpc_gfmd.theory.tfc import TERMS, ratios, sigma_of_terms, slopes, term

PAPER_ALPHA = {"t": 1.0, "f": 0.67, "c": 0.67}  # the exponents of the paper for kappa
ALPHA_RANGE = (0.02, 5.0)
STARTS = (0.3, 0.67, 1.5)
# condition number of the normalised design up to which every parameter counts as determined
WORST = 1e7
TOLERANCE = 1e-12
Function = Callable[[np.ndarray], np.ndarray]


class Fit(NamedTuple):
    """The best fit: parameters (k,), their covariance (k, k), and the weighted sum of squares."""

    x: np.ndarray
    covariance: np.ndarray
    chi2: float


def least_squares(
    model: Function,
    jacobian: Function,
    starts: list[np.ndarray],
    value: np.ndarray,
    covariance: np.ndarray,
    bounds: Any,
) -> Fit:
    """Fit model(x) (runs,), with its jacobian(x) (runs, k), to a value with a covariance, starting
    from each of several x, and return the best fit.

    Starts from which the fit does not converge are skipped. Raises SceneError if none converges, or
    the data do not determine every parameter.
    """
    fits = []
    for start in starts:
        try:
            x, of_parameters, info, *_ = curve_fit(
                lambda _, *x: model(np.array(x)),
                None,
                value,
                start,
                covariance,
                absolute_sigma=True,
                bounds=bounds,
                jac=lambda _, *x: jacobian(np.array(x)),
                method="trf",  # also without bounds
                x_scale="jac",
                full_output=True,
                ftol=TOLERANCE,
                xtol=TOLERANCE,
                gtol=TOLERANCE,
            )
        except RuntimeError:  # not converged from here
            continue
        fits.append(Fit(x, of_parameters, float(np.sum(info["fvec"] ** 2))))
    best = min(fits, key=lambda fit: fit.chi2, default=None)
    slopes_of_fit = jacobian(best.x) if best else np.zeros((1, 1))
    scale = np.linalg.norm(slopes_of_fit, axis=0)
    if best is None or not scale.all() or np.linalg.cond(slopes_of_fit / scale) > WORST:
        raise SceneError(
            "runs: found ratios that vary together, or no trend, allowed: runs that determine every"
            " term"
        )
    return best


@dataclass(frozen=True)
class TfcFit:
    """A fit of limit + sum_i C[i] eps_i^alpha[i].

    Attributes
    ----------
    parameters : dict
        C_i, alpha_i ("t", "f", "c") and limit; C = 0 and alpha = 1 for terms that were not fitted.
    names : tuple of str
        The fitted parameters in the order of covariance.
    covariance : array, shape (parameters, parameters)
        Covariance of the fitted parameters.
    chi2, dof : float, int
        Weighted sum of squares and its degrees of freedom.
    """

    parameters: dict
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
        """Return the sum of the fitted terms at these ratios, and its standard deviation."""
        eps = ratios(eps_t, eps_f, eps_c)
        row = self.row(0.0)
        return sum(term(row, i, eps[i]) for i in TERMS), sigma_of_terms(row, eps)

    def row(self, hurst: float) -> dict:
        """Return the fit as a row of a coefficient table (see data/paper_tfc.json).

        hurst: the Hurst exponent of the runs.
        """
        return {
            "hurst": hurst,
            **self.parameters,
            "sigma": self.sigma,
            "names": list(self.names),
            "covariance": self.covariance.tolist(),
        }


def fit_tfc(
    eps: Mapping[str, np.ndarray],
    value: np.ndarray,
    covariance: np.ndarray,
    alpha: Mapping[str, float | None],
    limit: float | None = None,
) -> TfcFit:
    """Fit eq. tfc to values of runs with their covariance by least squares: runs may share a
    surface.

    eps: ratios of the runs by term ("t", "f", "c"). alpha: exponents of the terms to fit; None
    means that the exponent is fitted (0.02 to 5). limit: a known value in the TFC limit; fitted if
    None. Raises SceneError if the runs do not determine every parameter: too few runs, or ratios
    that do not vary enough.
    """
    eps = {i: np.asarray(eps[i]) for i in alpha}
    fixed = {} if limit is None else {"limit": limit}
    fixed |= {f"alpha_{i}": exponent for i, exponent in alpha.items() if exponent is not None}
    every = ("limit", *(f"{kind}_{i}" for kind in ("C", "alpha") for i in eps))
    names = tuple(name for name in every if name not in fixed)
    free = [name for name in names if name.startswith("alpha")]
    for i, values in eps.items():
        needed = 3 if f"alpha_{i}" in free else 2
        number = np.unique(values).size
        if number < needed:
            raise SceneError(f"eps_{i}: found {number} different values, allowed: {needed} or more")
    if len(value) < len(names):
        raise SceneError(f"runs: found {len(value)}, allowed: {len(names)} or more")

    def law(x: np.ndarray) -> dict[str, float]:
        return fixed | dict(zip(names, x, strict=True))

    def model(x: np.ndarray) -> np.ndarray:
        row = law(x)
        return row["limit"] + sum(term(row, i, eps[i]) for i in eps)

    def jacobian(x: np.ndarray) -> np.ndarray:
        derivatives = slopes(law(x), eps)
        columns = [np.broadcast_to(derivatives[name], len(value)) for name in names]
        return np.stack(columns, axis=1)

    starts = []
    n_linear = len(names) - len(free)  # parameters in which the law is linear, which stand first
    for guess in product(STARTS, repeat=len(free)):
        x = np.append(np.zeros(n_linear), guess)
        linear = jacobian(x)[:, :n_linear]
        x[:n_linear] = np.linalg.lstsq(linear, value - model(x), rcond=None)[0]
        starts.append(x)
    bounds = np.array([ALPHA_RANGE if name in free else (-np.inf, np.inf) for name in names]).T
    best = least_squares(model, jacobian, starts, np.asarray(value), covariance, bounds)
    not_fitted = {f"C_{i}": 0.0 for i in TERMS} | {f"alpha_{i}": 1.0 for i in TERMS}
    parameters = not_fitted | law(best.x.tolist())
    return TfcFit(parameters, names, best.covariance, best.chi2, len(value) - len(names))
