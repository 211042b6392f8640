"""kappa in the limit of large cells, many decades of roughness and fine grids, by two routes: as counted and edge-corrected.

The corrections of eq. tfc do not simply add up: a coarse grid enlarges the fractal correction. The model is therefore

    kappa = kappa_0 + C_t eps_t + (C_f + D eps_c) eps_f^alpha_f + C_1 eps_c + C_2 eps_c^2 + C_3 eps_c^3,

eq. tfc with the product that the data demand, and with a Taylor series in eps_c: the contact of a surface that is smooth below lam_s
has a boundary of finite length, so the excess of counted grid points is linear in eps_c for eps_c -> 0.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..errors import SceneError
from ..theory.least_squares import least_squares
from ..theory.tfc_fit import PAPER_ALPHA
from .rows import Rows
from .scatter import Scatter

NAMES = ("kappa", "C_t", "C_f", "D", "C_1", "C_2", "C_3", "alpha_f")
START = np.array([2.0, 0.0, 2.0, 0.0, 1.0, 0.0, 0.0, 0.7])
ALPHA_F = (0.1, 3.0)  # what is tried


@dataclass(frozen=True)
class Limit:
    """One route to the limit, at a given alpha_f or a fitted one.

    Attributes
    ----------
    values : dict by NAMES
    covariance : array, shape (k, k)
        Of the fitted parameters, NAMES in their order, without alpha_f where that is given.
    influence : array, shape (runs,)
        How kappa follows a change of the value of each run.
    chi2, dof : float, int
    shift, lean : float
        Of kappa, when the coarsest third of the eps_f is left out, and when alpha_f is larger by its error.
    alpha_error, alpha_own
        Error of alpha_f, and (alpha_f, error) of this route alone.
    kappa_paper
        The limit with the paper's alpha_f, and its standard error.
    """

    values: dict
    covariance: np.ndarray
    influence: np.ndarray
    chi2: float
    dof: int
    shift: float = 0.0
    lean: float = 0.0
    alpha_error: float = 0.0
    alpha_own: tuple = (None, None)
    kappa_paper: tuple = (None, None)

    @property
    def kappa(self) -> float:
        """The value in the limit."""
        return self.values["kappa"]

    @property
    def sigma(self) -> float:
        """Standard error of kappa from realisations and solver, at this alpha_f."""
        return float(np.sqrt(self.covariance[0, 0]))

    @property
    def error(self) -> float:
        """All uncertainties of kappa together."""
        return float(np.hypot.reduce([self.sigma, self.shift, self.lean]))

    def row(self) -> dict:
        """Columns kappa_tfc, kappa_tfc_se (all), its parts, NAME and NAME_se of the other parameters, chi2_per_dof."""
        errors = dict(zip(NAMES, np.sqrt(np.diag(self.covariance)).tolist(), strict=False)) | {"alpha_f": self.alpha_error}
        row = {"kappa_tfc": self.kappa, "kappa_tfc_se": self.error, "kappa_tfc_se_runs": self.sigma, "kappa_tfc_shift": self.shift,
               "kappa_tfc_lean": self.lean, "kappa_paper_alpha": self.kappa_paper[0], "kappa_paper_alpha_se": self.kappa_paper[1]}
        for name in ("C_t", "C_f", "alpha_f", "D", "C_1", "C_2", "C_3"):
            row |= {name: self.values[name], f"{name}_se": errors[name]}
        return row | {"alpha_f_own": self.alpha_own[0], "alpha_f_own_se": self.alpha_own[1], "chi2_per_dof": self.chi2 / self.dof}


def compare_routes(runs: Rows) -> tuple[Limit, Limit, float, float]:
    """(raw Limit, edge-corrected Limit, raw minus edge-corrected, its standard error) of runs at one H and p*.

    alpha_f is a property of the fractal limit, not of how the area is counted, and common to both: the mean of what each route
    finds alone, weighted with their errors. Both routes see the same contacts, so that what realisations add cancels in the
    difference: its error follows from that of the excess kappa - kappa_edge and from how differently the two fits weigh the runs.
    Raises SceneError where the ratios vary too little.
    """
    _check(runs)
    names = ("kappa", "kappa_edge")
    scatter = {name: Scatter.of(runs, name) for name in names}
    alone = [fit_limit(runs, name, scatter[name]) for name in names]
    own = [(fit.values["alpha_f"], float(np.sqrt(fit.covariance[-1, -1]))) for fit in alone]
    errors = np.array([error for _, error in own])
    alpha = float(np.average([alpha for alpha, _ in own], weights=errors**-2.0))
    raw, edge = (_limit(runs, name, scatter[name], alpha, errors.min(), own) for name, own in zip(names, own))
    excess = [run | {"excess": run["kappa"] - run["kappa_edge"]} for run in runs]
    a, b = raw.influence, edge.influence
    of_excess = Scatter.of(excess, "excess").covariance(excess, "excess", error="a_r_error")
    of_edge = scatter["kappa_edge"].covariance(runs, "kappa_edge")
    sigma = np.sqrt(a @ of_excess @ a + (a - b) @ of_edge @ (a - b))
    return raw, edge, raw.kappa - edge.kappa, float(np.hypot.reduce([sigma, raw.shift - edge.shift, raw.lean - edge.lean]))


def _check(runs: Rows) -> None:
    octaves = {run["eps_f"] for run in runs}
    for name, needed in (("eps_t", 2), ("eps_f", 3), ("eps_c", 4)):
        found = len({run[name] for run in runs})
        if found < needed:
            raise SceneError(f"{name}: found {found} different values, allowed: at least {needed} for a limit")
    grids = {(run["eps_f"], run["eps_c"]) for run in runs}
    if sum(sum(f == octave for f, _ in grids) > 1 for octave in octaves) < 2:
        raise SceneError("eps_c: found several grids at fewer than two eps_f, allowed: at least two")
    if Scatter.of(runs, "kappa").law is None:
        raise SceneError("runs: found one realisation of each surface, allowed: at least two of some")


def _limit(runs: Rows, observable: str, scatter: Scatter, alpha: float, error: float, own: tuple) -> Limit:
    """The Limit with alpha_f given as alpha +- error."""

    def fit_at(exponent: float, chosen: Rows = runs) -> Limit:
        return fit_limit(chosen, observable, scatter, float(np.clip(exponent, *ALPHA_F)))

    best, octaves = fit_at(alpha), sorted({run["eps_f"] for run in runs})
    lean = (fit_at(alpha + error).kappa - fit_at(alpha - error).kappa) / 2
    try:
        shift = fit_at(alpha, [run for run in runs if run["eps_f"] <= octaves[-1 - len(octaves) // 3]]).kappa - best.kappa
    except SceneError:  # not enough without the coarsest
        shift = 0.0
    paper = fit_at(PAPER_ALPHA["f"])
    return replace(best, shift=shift, lean=lean, alpha_error=float(error), alpha_own=own, kappa_paper=(paper.kappa, paper.sigma))


def fit_limit(runs: Rows, observable: str, scatter: Scatter, alpha_f: float | None = None) -> Limit:
    """A Limit by generalised least squares; alpha_f: given, or fitted if None."""
    eps_t, eps_f, eps_c = (np.array([run[name] for run in runs]) for name in ("eps_t", "eps_f", "eps_c"))
    value = np.array([run[observable] for run in runs])
    errors = scatter.covariance(runs, observable)
    fitted = len(NAMES) - (alpha_f is not None)

    def design(x: np.ndarray) -> np.ndarray:
        power = eps_f ** (x[-1] if alpha_f is None else alpha_f)
        return np.stack([np.ones_like(value), eps_t, power, power * eps_c, eps_c, eps_c**2, eps_c**3], axis=1)

    def model(x: np.ndarray) -> np.ndarray:
        return design(x) @ x[:7]

    def jacobian(x: np.ndarray) -> np.ndarray:
        terms = design(x)
        return np.column_stack([terms, terms[:, 2:4] @ x[2:4] * np.log(eps_f)])[:, :fitted]

    low, high = np.full(fitted, -np.inf), np.full(fitted, np.inf)
    low[7:], high[7:] = ALPHA_F
    found = least_squares(model, jacobian, [START[:fitted]], value, errors, (low, high))
    values = {"alpha_f": alpha_f} | dict(zip(NAMES, found.x.tolist(), strict=False))
    influence = np.linalg.solve(errors, found.jacobian @ found.covariance[0])
    return Limit(values, found.covariance, influence, found.chi2, len(runs) - fitted)
