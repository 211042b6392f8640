"""kappa in the limit of large cells, many decades of roughness and fine grids, by two routes: as
counted and edge-corrected.

The corrections of eq. tfc do not simply add up: a coarse grid enlarges the fractal correction. The
model is therefore

    kappa = kappa_0 + C_t eps_t + (C_f + D eps_c) eps_f^alpha_f + C_1 eps_c + C_2 eps_c^2 + C_3
    eps_c^3,

eq. tfc with the product that the data demand, and with a Taylor series in eps_c: the contact of a
surface that is smooth below lam_s has a boundary of finite length, so the excess of counted grid
points is linear in eps_c for eps_c -> 0.
"""

from typing import NamedTuple

import numpy as np

from hpc_gfmd.theory.least_squares import least_squares
from hpc_gfmd.theory.tfc_fit import PAPER_ALPHA
from hpc_gfmd.util.errors import SceneError

from .rows import Rows
from .scatter import Scatter

NAMES = ("kappa", "C_t", "C_f", "D", "C_1", "C_2", "C_3", "alpha_f")
START = np.array([2.0, 0.0, 2.0, 0.0, 1.0, 0.0, 0.0, 0.7])
ALPHA_F = (0.1, 3.0)  # what is tried


class Limit(NamedTuple):
    """kappa by one route, at a given alpha_f or a fitted one.

    values: by NAMES; errors: standard errors of those that were fitted from realisations and
    solver; influence: how kappa follows a change of the value of each run; chi2, dof: of the fit.
    """

    values: dict[str, float]
    errors: dict[str, float]
    influence: np.ndarray
    chi2: float
    dof: int

    @property
    def kappa(self) -> float:
        """The value in the limit."""
        return self.values["kappa"]


def compare_routes(runs: Rows) -> Rows:
    """Two rows, the limit as counted and edge-corrected, of runs at one H and p*.

    Columns: kappa_tfc, kappa_tfc_se (all uncertainties together) and its parts: kappa_tfc_se_runs
    (realisations and solver), kappa_tfc_shift (the coarsest third of the eps_f left out),
    kappa_tfc_lean (alpha_f larger by its error); kappa_paper_alpha, kappa_paper_alpha_se: with the
    paper's alpha_f; NAME and NAME_se of the other parameters; alpha_f_own, alpha_f_own_se: of this
    route alone; chi2_per_dof; difference, difference_se: raw minus edge-corrected.

    alpha_f is a property of the fractal limit, not of how the area is counted, and common to both:
    the mean of what each route finds alone, weighted with their errors. Both routes see the same
    contacts, so that what realisations add cancels in the difference: its error follows from that
    of the excess kappa - kappa_edge and from how differently the two fits weigh the runs. Raises
    SceneError where the ratios vary too little.
    """
    _check(runs)
    scatter = {name: Scatter.of(runs, name) for name in ("kappa", "kappa_edge")}
    alone = [fit_limit(runs, name, of) for name, of in scatter.items()]
    alphas, errors = np.array([(fit.values["alpha_f"], fit.errors["alpha_f"]) for fit in alone]).T
    alpha = float(np.average(alphas, weights=errors**-2.0))
    (raw, counted), (edge, corrected) = (
        _route(runs, name, of, alpha, float(errors.min()), own)
        for (name, of), own in zip(scatter.items(), alone, strict=True)
    )
    excess = [run | {"excess": run["kappa"] - run["kappa_edge"]} for run in runs]
    of_excess = Scatter.of(excess, "excess").covariance(excess, "excess", error="a_r_error")
    apart = raw.influence - edge.influence
    sigma = np.sqrt(
        raw.influence @ of_excess @ raw.influence
        + apart @ scatter["kappa_edge"].covariance(runs, "kappa_edge") @ apart
    )
    parts = [
        sigma,
        *(counted[name] - corrected[name] for name in ("kappa_tfc_shift", "kappa_tfc_lean")),
    ]
    difference = {
        "difference": raw.kappa - edge.kappa,
        "difference_se": float(np.hypot.reduce(parts)),
    }
    return [counted | difference, corrected | difference]


def _check(runs: Rows) -> None:
    octaves = {run["eps_f"] for run in runs}
    for name, needed in (("eps_t", 2), ("eps_f", 3), ("eps_c", 4)):
        found = len({run[name] for run in runs})
        if found < needed:
            raise SceneError(
                f"{name}: found {found} different values, allowed: at least {needed} for a limit"
            )
    grids = {(run["eps_f"], run["eps_c"]) for run in runs}
    if sum(sum(f == octave for f, _ in grids) > 1 for octave in octaves) < 2:
        raise SceneError(
            "eps_c: found several grids at fewer than two eps_f, allowed: at least two"
        )
    if Scatter.of(runs, "kappa").law is None:
        raise SceneError(
            "runs: found one realisation of each surface, allowed: at least two of some"
        )


def _route(
    runs: Rows, observable: str, scatter: Scatter, alpha: float, error: float, own: Limit
) -> tuple[Limit, dict]:
    """The Limit with alpha_f given as alpha +- error, and its row; own: the one that the route
    finds alone."""

    def fit_at(exponent: float, chosen: Rows = runs) -> Limit:
        return fit_limit(chosen, observable, scatter, float(np.clip(exponent, *ALPHA_F)))

    best, paper, octaves = (
        fit_at(alpha),
        fit_at(PAPER_ALPHA["f"]),
        sorted({run["eps_f"] for run in runs}),
    )
    try:
        shift = (
            fit_at(
                alpha, [run for run in runs if run["eps_f"] <= octaves[-1 - len(octaves) // 3]]
            ).kappa
            - best.kappa
        )
    except SceneError:  # not enough without the coarsest
        shift = 0.0
    lean = (fit_at(alpha + error).kappa - fit_at(alpha - error).kappa) / 2
    errors = best.errors | {"alpha_f": error}
    row = {
        "kappa_tfc": best.kappa,
        "kappa_tfc_se": float(np.hypot.reduce([errors["kappa"], shift, lean])),
        "kappa_tfc_se_runs": errors["kappa"],
        "kappa_tfc_shift": shift,
        "kappa_tfc_lean": lean,
        "kappa_paper_alpha": paper.kappa,
        "kappa_paper_alpha_se": paper.errors["kappa"],
    }
    for name in ("C_t", "C_f", "alpha_f", "D", "C_1", "C_2", "C_3"):
        row |= {name: best.values[name], f"{name}_se": errors[name]}
    return best, row | {
        "alpha_f_own": own.values["alpha_f"],
        "alpha_f_own_se": own.errors["alpha_f"],
        "chi2_per_dof": best.chi2 / best.dof,
    }


def fit_limit(runs: Rows, observable: str, scatter: Scatter, alpha_f: float | None = None) -> Limit:
    """A Limit by generalised least squares; alpha_f: given, or fitted if None."""
    eps_t, eps_f, eps_c = (
        np.array([run[name] for run in runs]) for name in ("eps_t", "eps_f", "eps_c")
    )
    value = np.array([run[observable] for run in runs])
    errors = scatter.covariance(runs, observable)
    fitted = len(NAMES) - (alpha_f is not None)

    def design(x: np.ndarray) -> np.ndarray:
        power = eps_f ** (x[-1] if alpha_f is None else alpha_f)
        return np.stack(
            [np.ones_like(value), eps_t, power, power * eps_c, eps_c, eps_c**2, eps_c**3], axis=1
        )

    def model(x: np.ndarray) -> np.ndarray:
        return design(x) @ x[:7]

    def jacobian(x: np.ndarray) -> np.ndarray:
        terms = design(x)
        return np.column_stack([terms, terms[:, 2:4] @ x[2:4] * np.log(eps_f)])[:, :fitted]

    low, high = np.full(fitted, -np.inf), np.full(fitted, np.inf)
    low[7:], high[7:] = ALPHA_F
    found = least_squares(model, jacobian, [START[:fitted]], value, errors, (low, high))
    values: dict = {"alpha_f": alpha_f} | dict(zip(NAMES, found.x.tolist(), strict=False))
    sigma = dict(zip(NAMES, np.sqrt(np.diag(found.covariance)).tolist(), strict=False))
    influence = np.linalg.solve(errors, found.jacobian @ found.covariance[0])
    return Limit(values, sigma, influence, found.chi2, len(runs) - fitted)
