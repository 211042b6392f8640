"""kappa in the limit of large cells, many decades of roughness and fine grids, by two routes: as counted and edge-corrected.

The corrections of eq. tfc do not simply add up: a coarse grid enlarges the fractal correction. The model is therefore

    kappa = kappa_0 + C_t eps_t + (C_f + D eps_c) eps_f^alpha_f + C_1 eps_c + C_2 eps_c^2 + C_3 eps_c^3,

eq. tfc with the product that the data demand, and with a Taylor series in eps_c: the contact of a surface that is smooth below lam_s
has a boundary of finite length, so the excess of counted grid points is linear in eps_c for eps_c -> 0.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from ..errors import SceneError
from ..theory.tfc_fit import PAPER_ALPHA
from .scatter import Scatter

NAMES = ("kappa", "C_t", "C_f", "alpha_f", "D", "C_1", "C_2", "C_3")
START = (2.0, 0.0, 2.0, 0.7, 0.0, 1.0, 0.0, 0.0)
ALPHA_F = (0.1, 3.0)  # what is tried


@dataclass(frozen=True)
class Limit:
    """values by name; free: names of the fitted ones, the order of covariance and of influence (parameters, runs), which says how
    each follows a change of each value; shift: of kappa, when the coarsest third of the eps_f is left out; lean: of kappa, when
    alpha_f is larger by its error; alpha_error, alpha_own: that error, and (alpha_f, error) of this route alone; kappa_paper: the
    limit with the paper's alpha_f, and its standard error."""

    values: dict
    free: tuple
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
    def kappa(self):
        """The value in the limit."""
        return self.values["kappa"]

    @property
    def sigma(self):
        """Standard error of kappa from realisations and solver, at this alpha_f."""
        return float(np.sqrt(self.covariance[0, 0]))

    @property
    def error(self):
        """All uncertainties of kappa together."""
        return float(np.hypot.reduce([self.sigma, self.shift, self.lean]))

    def error_of(self, name):
        """Standard error of a parameter; None of one that was not fitted."""
        if name == "alpha_f":
            return self.alpha_error
        return float(np.sqrt(np.diag(self.covariance)[self.free.index(name)])) if name in self.free else None

    def row(self):
        """Columns kappa_tfc, kappa_tfc_se (all), its parts, NAME and NAME_se of the other parameters, chi2_per_dof."""
        rest = {key: x for name in NAMES[1:] for key, x in ((name, self.values[name]), (f"{name}_se", self.error_of(name)))}
        parts = {"kappa_tfc_se_runs": self.sigma, "kappa_tfc_shift": self.shift, "kappa_tfc_lean": self.lean}
        own = {"alpha_f_own": self.alpha_own[0], "alpha_f_own_se": self.alpha_own[1]}
        theirs = {"kappa_paper_alpha": self.kappa_paper[0], "kappa_paper_alpha_se": self.kappa_paper[1]}
        return {
            "kappa_tfc": self.kappa,
            "kappa_tfc_se": self.error,
            **parts,
            **theirs,
            **rest,
            **own,
            "chi2_per_dof": self.chi2 / self.dof,
        }

    def at(self, eps_t, eps_f, eps_c):
        """kappa at given ratios, by the model."""
        return float(_model([self.values[name] for name in NAMES], *(np.array([x]) for x in (eps_t, eps_f, eps_c)))[0])


def compare_routes(runs):
    """(raw Limit, edge-corrected Limit, raw minus edge-corrected, its standard error) of runs at one H and p*.

    alpha_f is a property of the fractal limit, not of how the area is counted, and common to both: the mean of what each route
    finds alone, weighted with their errors. Both routes see the same contacts, so that what realisations add cancels in the
    difference: its error follows from that of the excess kappa - kappa_edge and from how differently the two fits weigh the runs.
    Raises SceneError where the ratios vary too little.
    """
    _check(runs)
    names = ("kappa", "kappa_edge")
    scatter = {name: Scatter.of(runs, name) for name in names}
    alone = {name: _fit(runs, name, scatter[name]) for name in names}
    own = {name: (fit.values["alpha_f"], float(np.sqrt(fit.covariance[3, 3]))) for name, fit in alone.items()}
    weight = [1 / own[name][1] ** 2 for name in names]
    alpha, error = np.average([own[name][0] for name in names], weights=weight), min(own[name][1] for name in names)
    raw, edge = (_limit(runs, name, scatter[name], float(alpha), error, own[name]) for name in names)
    excess = [run | {"excess": run["kappa"] - run["kappa_edge"]} for run in runs]
    a, b = raw.influence[0], edge.influence[0]
    of_excess = Scatter.of(excess, "excess").covariance(excess, "excess", error="a_r_error")
    of_edge = scatter["kappa_edge"].covariance(runs, "kappa_edge")
    variance = a @ of_excess @ a + (a - b) @ of_edge @ (a - b)
    return raw, edge, raw.kappa - edge.kappa, float(np.hypot.reduce([np.sqrt(variance), raw.shift - edge.shift, raw.lean - edge.lean]))


def _check(runs):
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


def _limit(runs, observable, scatter, alpha, error, own):
    """The Limit with alpha_f given as alpha +- error."""

    def fit_at(exponent, chosen=runs):
        return _fit(chosen, observable, scatter, {"alpha_f": float(np.clip(exponent, *ALPHA_F))})

    best, octaves = fit_at(alpha), sorted({run["eps_f"] for run in runs})
    lean = (fit_at(alpha + error).kappa - fit_at(alpha - error).kappa) / 2
    try:
        shift = fit_at(alpha, [run for run in runs if run["eps_f"] <= octaves[-1 - len(octaves) // 3]]).kappa - best.kappa
    except SceneError:  # not enough without the coarsest
        shift = 0.0
    theirs = fit_at(PAPER_ALPHA["f"])
    more = {"alpha_error": error, "alpha_own": own, "kappa_paper": (theirs.kappa, theirs.sigma)}
    return replace(best, shift=shift, lean=lean, **more)


def _model(x, eps_t, eps_f, eps_c):
    kappa, C_t, C_f, alpha_f, D, C_1, C_2, C_3 = x
    return kappa + C_t * eps_t + (C_f + D * eps_c) * eps_f**alpha_f + eps_c * (C_1 + eps_c * (C_2 + eps_c * C_3))


def _fit(runs, observable, scatter, fixed=()):
    """A Limit by generalised least squares; fixed: values of parameters that are not fitted."""
    fixed = dict(fixed)
    free = tuple(name for name in NAMES if name not in fixed)
    eps = [np.array([run[name] for run in runs]) for name in ("eps_t", "eps_f", "eps_c")]
    value = np.array([run[observable] for run in runs])
    whiten = np.linalg.inv(np.linalg.cholesky(scatter.covariance(runs, observable)))
    start = dict(zip(NAMES, START, strict=True))
    bounds = np.array([ALPHA_F if name == "alpha_f" else (-np.inf, np.inf) for name in free]).T

    def residual(x):
        parameters = start | fixed | dict(zip(free, x, strict=True))
        return whiten @ (_model([parameters[name] for name in NAMES], *eps) - value)

    fit = least_squares(residual, [start[name] for name in free], bounds=bounds, x_scale="jac")
    scale = np.linalg.norm(fit.jac, axis=0)
    if not scale.all() or np.linalg.cond(fit.jac / scale) > 1e7:
        raise SceneError("runs: found ratios that vary together, allowed: runs that determine every term of the limit")
    inverse = np.linalg.pinv(fit.jac / scale) / scale[:, None]
    values = start | fixed | dict(zip(free, fit.x.tolist(), strict=True))
    return Limit(values, free, inverse @ inverse.T, inverse @ whiten, float(2 * fit.cost), len(runs) - len(free))
