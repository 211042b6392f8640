"""Fits of the correction terms of eq. tfc to a set of runs, with uncertainties."""

import csv
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..util.errors import SceneError, one_line
from .checks import within
from .least_squares import least_squares

TERMS = ("t", "f", "c")
COEFFICIENTS = [f"{name}_{i}" for name in ("C", "alpha") for i in TERMS]
PAPER_ALPHA = {"t": 1.0, "f": 0.67, "c": 0.67}  # the exponents of the paper for kappa
_ALPHA_RANGE = (0.02, 5.0)
_STARTS = (0.3, 0.67, 1.5)


@dataclass(frozen=True)
class TfcFit:
    """limit + sum_i C[i] eps_i^alpha[i], fitted.

    Attributes
    ----------
    limit : float
        Value in the TFC limit.
    C, alpha : dict
        By fitted term ("t", "f", "c").
    names : tuple of str
        The fitted parameters ("limit", "C_t", ..., "alpha_c", ...) in the order of covariance.
    covariance : array, shape (parameters, parameters)
        Without error bars of the data scaled by chi2/dof, nan where dof = 0.
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
    def values(self) -> np.ndarray:
        """The fitted parameters in the order of names."""
        known = (
            {"limit": self.limit}
            | {f"C_{i}": c for i, c in self.C.items()}
            | {f"alpha_{i}": a for i, a in self.alpha.items()}
        )
        return np.array([known[name] for name in self.names])

    @cached_property
    def sigma(self) -> dict:
        """Standard errors of the fitted parameters by name."""
        return dict(zip(self.names, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    def correction(
        self, eps_t: float = 0.0, eps_f: float = 0.0, eps_c: float = 0.0
    ) -> tuple[float, float]:
        """(sum of the terms, its uncertainty) at the given ratios; a term that was not fitted is
        zero."""
        eps = {"t": eps_t, "f": eps_f, "c": eps_c}
        eps = {i: float(within(f"eps_{i}", eps[i], 0, 1)) for i in TERMS}
        row = self.row(0.0)
        return sum(term(row, i, eps[i]) for i in TERMS), sigma_of_terms(row, eps)

    def row(self, hurst: float) -> dict:
        """The fit as a row of a coefficient table (see data/paper_tfc.json); terms that were not
        fitted get C = 0."""
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


def term(row: Mapping[str, Any], i: str, eps: float) -> float:
    """C_i eps^alpha_i by a row of a coefficient table."""
    return row[f"C_{i}"] * eps ** row[f"alpha_{i}"] if eps > 0 else 0.0


def sigma_of_terms(row: Mapping[str, Any], eps: Mapping[str, float]) -> float:
    """Uncertainty of the sum of the terms, from the "covariance" of the row (order "names") if
    given, else from its "sigma"."""
    names = row.get("names", COEFFICIENTS)
    gradient = []
    for name in names:
        kind, _, i = name.partition("_")
        power = eps[i] ** row[f"alpha_{i}"] if i in eps and eps[i] > 0 else 0.0
        gradient.append(
            {"C": power, "alpha": row.get(f"C_{i}", 0) * power * np.log(eps.get(i) or 1)}.get(
                kind, 0.0
            )
        )
    covariance = row.get(
        "covariance", np.diag([row["sigma"].get(name, 0.0) ** 2 for name in names])
    )
    return float(np.sqrt(max(gradient @ np.asarray(covariance) @ gradient, 0.0)))


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
    """Least-squares fit of eq. tfc to runs.

    Parameters
    ----------
    eps_t, eps_f, eps_c : arrays, shape (runs,), or numbers
    value : array, shape (runs,)
    sigma : number or array, optional
        Error bars of value, shape (runs,), or their covariance matrix, shape (runs, runs), where
        runs share a surface.
    alpha : dict, optional
        Exponents by term, e.g. {"t": 1, "f": 0.67, "c": None}; None leaves one free (0.02 to 5), a
        term left out has the paper's.
    terms : iterable of str
        The terms to include.
    limit : float, optional
        A known value in the TFC limit; fitted if None.

    Returns
    -------
    TfcFit

    Raises
    ------
    SceneError
        When the runs cannot determine what is asked: too few, or a ratio that does not vary enough.
    """
    value = np.atleast_1d(within("value", value, -np.inf, np.inf))
    eps = {
        i: np.broadcast_to(within(f"eps_{i}", e, 0, 1, open_low=True), value.shape)
        for i, e in zip(TERMS, (eps_t, eps_f, eps_c), strict=True)
        if i in terms
    }
    alpha = {i: (PAPER_ALPHA | dict(alpha or {}))[i] for i in eps}
    alpha = {
        i: None if a is None else float(within(f"alpha_{i}", a, 0, 10, open_low=True))
        for i, a in alpha.items()
    }
    free = [i for i in eps if alpha[i] is None]
    fixed = None if limit is None else float(within("limit", limit, -np.inf, np.inf))
    names = (
        *(("limit",) if fixed is None else ()),
        *(f"C_{i}" for i in eps),
        *(f"alpha_{i}" for i in free),
    )
    _enough(value, eps, free, names)
    if sigma is not None and np.ndim(sigma) < 2:
        sigma = np.broadcast_to(within("sigma", sigma, 0, np.inf, open_low=True), value.shape)

    target = value - (fixed or 0.0)
    linear = len(names) - len(free)  # the parameters in which the law is linear stand first

    def exponents(x: np.ndarray) -> dict:
        return alpha | dict(zip(free, x[linear:], strict=True))

    def design(alpha: dict) -> np.ndarray:
        return np.stack(
            [np.ones_like(value)] * (fixed is None) + [eps[i] ** alpha[i] for i in eps], axis=1
        )

    def model(x: np.ndarray) -> np.ndarray:
        return design(exponents(x)) @ x[:linear]

    def jacobian(x: np.ndarray) -> np.ndarray:
        powers = design(exponents(x))
        slopes = [
            powers[:, names.index(f"C_{i}")] * x[names.index(f"C_{i}")] * np.log(eps[i])
            for i in free
        ]
        return np.column_stack([powers, *slopes])

    starts = [
        np.append(
            np.linalg.lstsq(design(alpha | dict(zip(free, guess))), target, rcond=None)[0], guess
        )
        for guess in product(_STARTS, repeat=len(free))
    ]
    bounds = np.array([(-np.inf, np.inf)] * linear + [_ALPHA_RANGE] * len(free)).T
    found = least_squares(model, jacobian, starts, target, sigma, bounds)
    dof = value.size - len(names)
    covariance = (
        found.covariance
        if sigma is not None
        else found.covariance * (found.chi2 / dof if dof else np.nan)
    )
    known: dict[str, Any] = {"limit": fixed} | dict(zip(names, found.x.tolist(), strict=True))
    return TfcFit(
        known["limit"],
        {i: known[f"C_{i}"] for i in eps},
        {i: known.get(f"alpha_{i}", alpha[i]) for i in eps},
        names,
        covariance,
        found.chi2,
        dof,
    )


def _enough(value: np.ndarray, eps: dict, free: list, names: tuple) -> None:
    """Raise SceneError where there are fewer runs than parameters, or fewer values of a ratio than
    its term needs."""
    for i, values in eps.items():
        needed, found = 3 if i in free else 2, np.unique(values).size
        if found < needed:
            raise SceneError(
                f"eps_{i}: found {found} different values, allowed: at least {needed} to fit "
                f"{'C and alpha' if i in free else 'C'}, or leave the term {i} out"
            )
    if value.size < len(names):
        raise SceneError(
            f"runs: found {value.size}, allowed: at least {len(names)}, the number of fitted"
            " parameters"
        )


def read_runs(path: str | Path) -> dict:
    """Columns eps_t, eps_f, eps_c, value and, if there, sigma of the CSV file at path, with a
    header, as arrays for fit_tfc.

    Raises SceneError if it is not one.
    """
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        wanted = ["eps_t", "eps_f", "eps_c", "value"] + (
            ["sigma"] if rows and "sigma" in rows[0] else []
        )
        return {name: np.array([float(row[name]) for row in rows]) for name in wanted}
    except (OSError, ValueError, KeyError, TypeError, csv.Error) as error:
        raise SceneError(
            f"runs: found {str(path)!r} ({one_line(str(error))}), allowed: a CSV file with the"
            " columns eps_t, eps_f, eps_c, value and maybe sigma"
        ) from None
