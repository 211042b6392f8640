"""Least squares with known errors (scipy.optimize.curve_fit), and a check that the data determine
every parameter."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import curve_fit

from hpc_gfmd import SceneError
from hpc_gfmd.util.errors import one_line

# condition number of the normalised design up to which every parameter counts as determined
WORST = 1e7
TOLERANCE = 1e-12
Function = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Fit:
    """The best fit.

    Attributes
    ----------
    x : ndarray, shape (k,)
        Parameters.
    covariance : ndarray, shape (k, k)
        Covariance of the parameters, computed with the errors of the data, or with errors of 1 if
        none are given.
    chi2 : float
        Weighted sum of squares.
    """

    x: np.ndarray
    covariance: np.ndarray
    chi2: float


def least_squares(
    model: Function,
    jacobian: Function,
    starts: list[np.ndarray],
    value: np.ndarray,
    sigma: Any,
    bounds: Any,
) -> Fit:
    """Fit model(x) to value, starting from each of several x, and return the best fit.

    Parameters
    ----------
    model, jacobian : functions of x
        Return arrays of shapes (runs,) and (runs, k).
    starts : list of arrays, shape (k,)
        Parameters x to begin with.
    value : array, shape (runs,)
        What the model is fitted to; finite.
    sigma : array or None
        Standard errors, shape (runs,), or covariance matrix, shape (runs, runs); None: errors of 1.
    bounds : pair of numbers or of arrays, shape (k,)
        Lower and upper bounds of x.

    Returns
    -------
    Fit
        The one with the smallest chi2. Starts that do not converge are skipped.

    Raises
    ------
    SceneError
        If sigma has another shape or is no covariance matrix, no start converges, or the data do
        not determine every parameter.
    """
    best: Fit | None = None
    for start in starts:
        try:
            x, covariance, info, *_ = curve_fit(
                lambda _, *x: model(np.array(x)),
                None,
                value,
                start,
                sigma,
                absolute_sigma=True,
                bounds=bounds,
                method="trf",
                jac=lambda _, *x: jacobian(np.array(x)),
                x_scale="jac",
                full_output=True,
                ftol=TOLERANCE,
                xtol=TOLERANCE,
                gtol=TOLERANCE,
            )
        except RuntimeError:  # not converged from here
            continue
        except ValueError as error:  # of sigma
            raise SceneError(
                f"sigma: found {one_line(str(error))}, allowed: errors or a covariance matrix of"
                f" the {len(value)} runs"
            ) from None
        chi2 = float(np.sum(info["fvec"] ** 2))
        if best is None or chi2 < best.chi2:
            best = Fit(x, covariance, chi2)
    slopes = jacobian(best.x) if best else np.zeros((1, 1))
    scale = np.linalg.norm(slopes, axis=0)
    if best is None or not scale.all() or np.linalg.cond(slopes / scale) > WORST:
        raise SceneError(
            "runs: found ratios that vary together, or no trend, allowed: runs that determine every"
            " term"
        )
    return best
