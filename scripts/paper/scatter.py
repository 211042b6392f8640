"""How much realisations differ, and what runs that share a surface have in common: the covariance
matrix of a set of runs.

One surface is solved on several grids and at several pressures, and the surfaces of a seed at
neighbouring lam_l/lam_s share their long waves. What a realisation adds is therefore common to many
runs and cancels in differences: fits that know the covariance are fits of paired differences where
there are pairs, and of averages where there are none.
"""

from collections import defaultdict
from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.special import digamma

from .rows import Rows, groups

SOLVER_SHARE = (
    0.2  # of the solver's error estimate is one sigma: the estimate is nearly an upper bound
)
ERROR_OF = {
    "kappa": "a_r_error",
    "a_r": "a_r_error",
}  # which estimate belongs to which observable; the others are gaps


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
        """From runs at one H and p* that differ in seed and ratios."""
        alike = groups(runs, "eps_t", "eps_f", "eps_c")
        points = []
        deviations: dict[tuple, dict] = defaultdict(dict)
        for (eps_t, eps_f, eps_c), group in alike.items():
            values = np.array([run[observable] for run in group])
            if len(group) < 2 or values.mean() == 0:
                continue
            relative = values / values.mean() - 1
            points.append(
                (np.log(eps_f), np.sum(relative**2) / (len(group) - 1) / eps_t**2, len(group) - 1)
            )
            if len(group) >= 4:
                for run, x in zip(group, relative, strict=True):
                    deviations[eps_t, eps_c, run["seed"]][np.log2(eps_f)] = x / np.sqrt(
                        np.mean(relative**2) or 1
                    )
        return cls(_law(points), _jitter(alike, observable), _memory(deviations))

    def relative(self, eps_t: float, eps_f: float) -> float:
        """Standard deviation of one realisation over the mean; nan where it is not known."""
        return float(np.exp(self.law[0]) * eps_f ** self.law[1] * eps_t) if self.law else np.nan

    def grid(self, run: dict) -> float:
        """Standard deviation over the mean of what the grid of a run adds to what all grids of its
        surface have."""
        return self.jitter * run["eps_t"] * run["eps_f"] * run["eps_c"]

    def covariance(self, runs: Rows, observable: str, error: str | None = None) -> np.ndarray:
        """Shape (runs, runs), of the values of an observable: realisation (shared), grid and solver
        (not shared).

        error: name of the solver's error estimate, if not the observable's own.
        """
        value = np.array([run[observable] for run in runs])
        sigma = value * [self.relative(run["eps_t"], run["eps_f"]) for run in runs]
        apart = np.abs(np.subtract.outer(*2 * [[np.log2(run["eps_f"]) for run in runs]]))
        who = [(run["seed"], run["eps_t"]) for run in runs]
        same = np.array([[a == b for b in who] for a in who])
        shared = np.where(same, self.memory**apart, 0.0) * np.outer(sigma, sigma)
        alone = value * [self.grid(run) for run in runs]
        solver = value * [SOLVER_SHARE * run[error or error_of(observable)] for run in runs]
        return shared + np.diag(alone**2 + solver**2)


def error_of(observable: str) -> str:
    """The name of the solver's error estimate that belongs to an observable."""
    return ERROR_OF.get(observable.removesuffix("_edge"), "gap_error")


def _law(points: list[tuple]) -> tuple[float, float] | None:
    """A straight line through the logarithms of the variances, each as uncertain as its degrees of
    freedom say."""
    points = [point for point in points if point[1] > 0]
    if not points:
        return None
    at, variance, dof = np.array(points).T
    log = (
        np.log(variance) - digamma(dof / 2) + np.log(dof / 2)
    )  # the mean logarithm of a sample variance is too small
    slope = np.polyfit(at, log, 1, w=np.sqrt(dof))[0] if len(set(at)) > 2 else 0.0
    return float(np.average(log - slope * at, weights=dof) / 2), float(slope / 2)


def _jitter(alike: dict, observable: str) -> float:
    squares, dof = 0.0, 0
    for (eps_t, eps_f, eps_c), group in alike.items():
        coarser = {run["seed"]: run[observable] for run in alike.get((eps_t, eps_f, 2 * eps_c), ())}
        ratio = np.array(
            [run[observable] / coarser[run["seed"]] for run in group if run["seed"] in coarser]
        )
        if len(ratio) > 1:
            squares += np.sum((ratio / ratio.mean() - 1) ** 2) / (
                5 * (eps_t * eps_f * eps_c) ** 2
            )  # 5 = 1 + 2^2: both grids
            dof += len(ratio) - 1
    return float(np.sqrt(squares / dof)) if dof else 0.0


def _memory(deviations: dict) -> float:
    """Mean product of a seed's normalised deviations one octave apart, in [0, 0.99]."""
    products = [
        x * series[at - 1]
        for series in deviations.values()
        for at, x in series.items()
        if at - 1 in series
    ]
    return float(np.clip(np.mean(products), 0.0, 0.99)) if products else 0.0
