"""An observable in the limit of fine grids and large cells at given H, eps_f and pressure, all of
one pressure or several together.

    ln value = ln limit + C_t eps_t + C_1 eps_c + sum over k of eps_c^k (smooth function of H, ln
    eps_f, ln p_star)

by generalised least squares, with a limit and C_t for each H, eps_f and p_star, C_1 (linear in ln
p_star) for each H and eps_f, and the covariance of runs that share a surface: what realisations add
cancels in the differences between grids. The grid sees single contacts, which hardly know of H,
eps_f and a small load; what it does is therefore common to all of them (but for C_1 of the area as
counted), and known well even where one surface has few contacts.
"""

from collections import defaultdict
from dataclasses import dataclass, replace

import numpy as np

from hpc_gfmd.util.errors import SceneError

from .rows import Rows
from .scatter import SOLVER_SHARE, Scatter, error_of

# of eps_c: (those of every family, those common to all); counted points exceed by the length of the
# contact boundary
POWERS = {
    "kappa": ((1,), (2, 3)),
    "kappa_edge": ((), (1, 2, 3)),
    "gap_over_h_rms": ((), (3, 4)),
}

MODEL = {
    "kappa": 1e-6,
    "kappa_edge": 1e-6,
    "gap_over_h_rms": 2e-4,
}  # relative: how well common terms describe what the grid does
# what realisations add is correlated by (p/p')^LOADS at the loads p < p' of a surface, found in
# runs of level desk
LOADS = 0.25


@dataclass(frozen=True)
class Continuum:
    """value, error: {(H, eps_f, p_star): limit, its relative standard error}; chi2: per degree of
    freedom."""

    value: dict
    error: dict
    chi2: float


def continuum(runs: Rows, observable: str) -> Continuum:
    """The limits of one of POWERS for all H, eps_f and p_star among the runs.

    Errors are enlarged where the model does not fit within them. Raises SceneError where a value is
    zero, the scatter not known, or a term not determined.
    """
    families = sorted({_family(run) for run in runs})
    parts = [[run for run in runs if _family(run) == family] for family in families]
    runs = [run for part in parts for run in part]
    value = np.array([run[observable] for run in runs])
    if not runs or not (value > 0).all():
        raise SceneError(f"{observable}: found no runs or zeros, allowed: positive values")
    scatter = _same_jitter(families, [Scatter.of(part, observable) for part in parts])
    if any(one.law is None for one in scatter):
        raise SceneError(
            "runs: found one realisation of each surface, allowed: at least two of some"
        )
    errors = _covariance(
        runs, [one for one, part in zip(scatter, parts, strict=True) for _ in part], observable
    )
    own, common = POWERS[observable]
    common = common[
        : max(1, len({run["eps_c"] for run in runs}) - 1 - len(own))
    ]  # as many as the grids can tell
    design = np.column_stack(
        [*_of_families(runs, families, own), *_of_grids(runs, common, len(own))]
    )
    whiten = np.linalg.inv(np.linalg.cholesky(errors))
    white, target = whiten @ design, whiten @ np.log(value)
    scale = np.linalg.norm(white, axis=0)
    found, _, rank, _ = np.linalg.lstsq(white / scale, target, rcond=1e-9)
    if rank < len(found):
        raise SceneError("runs: found too few grids or cells, allowed: as many as there are powers")
    dof = len(value) - len(found)
    chi2 = float(np.sum((target - white / scale @ found) ** 2)) / dof if dof else 1.0
    found, sigma = (
        found / scale,
        np.sqrt(np.diag(np.linalg.inv((white / scale).T @ (white / scale))) * max(1.0, chi2))
        / scale,
    )
    count = len(families)
    return Continuum(
        dict(zip(families, np.exp(found[:count]).tolist(), strict=True)),
        dict(zip(families, sigma[:count].tolist(), strict=True)),
        chi2,
    )


def _family(run: dict) -> tuple[float, float, float]:
    return run["hurst"], run["eps_f"], run["p_star"]


def _same_jitter(
    families: list[tuple[float, float, float]], scatter: list[Scatter]
) -> list[Scatter]:
    """What a grid adds is alike for all H, of each of which few surfaces were solved on several
    grids: the root mean square."""
    squares: dict[tuple, list[float]] = defaultdict(list)
    for (_, *rest), one in zip(families, scatter, strict=True):
        squares[tuple(rest)].append(one.jitter**2)
    return [
        replace(one, jitter=float(np.sqrt(np.mean(squares[family[1:]]))))
        for family, one in zip(families, scatter, strict=True)
    ]


def _covariance(runs: Rows, scatter: list[Scatter], observable: str) -> np.ndarray:
    """Relative, shape (runs, runs); scatter: the Scatter of each run.

    What a grid adds is not correlated at different loads. At neighbouring H of a seed it is (by 0.7
    at 0.7 and 0.8): left out here, which makes errors a tenth too small.
    """
    surface = np.unique(
        [[run[name] for name in ("hurst", "eps_f", "eps_t", "seed")] for run in runs],
        axis=0,
        return_inverse=True,
    )[1]
    log = np.log([run["p_star"] for run in runs])
    sigma = [
        one.relative(run["eps_t"], run["eps_f"]) for one, run in zip(scatter, runs, strict=True)
    ]
    alone = [
        np.hypot(one.grid(run), SOLVER_SHARE * run[error_of(observable)])
        for one, run in zip(scatter, runs, strict=True)
    ]
    shared = np.equal.outer(surface, surface) * np.exp(-LOADS * np.abs(np.subtract.outer(log, log)))
    return shared * np.outer(sigma, sigma) + np.diag(np.square(alone) + MODEL[observable] ** 2)


def _of_families(
    runs: Rows, families: list[tuple[float, float, float]], powers: tuple[int, ...]
) -> list[np.ndarray]:
    """A column for the limit of each family, one for its C_t where its cells differ, and one (two
    where there are several loads) for each of its own powers of eps_c for each H and eps_f."""
    which = np.array([families.index(_family(run)) for run in runs])
    eps_t, eps_c, log = np.array(
        [(run["eps_t"], run["eps_c"], np.log(run["p_star"])) for run in runs]
    ).T
    limits = [np.where(which == k, 1.0, 0.0) for k in range(len(families))]
    kinds = {
        family[:2]: sum(
            mask for mask, one in zip(limits, families, strict=True) if one[:2] == family[:2]
        )
        for family in families
    }
    terms = [1.0, log] if np.ptp(log) > 0 else [1.0]
    return [
        *limits,
        *(mask * eps_t for mask in limits if np.ptp(eps_t[mask > 0]) > 0),
        *(mask * term * eps_c**k for k in powers for mask in kinds.values() for term in terms),
    ]


def _of_grids(runs: Rows, powers: tuple[int, ...], start: int) -> list[np.ndarray]:
    """Columns of eps_c^k times smooth functions of H, ln eps_f and ln p_star, the fewer the higher
    the power, as far as they differ. start: number of powers below."""
    eps_c, hurst, log, load = (
        np.array(x)
        for x in zip(
            *((r["eps_c"], r["hurst"], np.log(r["eps_f"]), np.log(r["p_star"])) for r in runs),
            strict=True,
        )
    )
    several, varied = min(len(set(hurst.tolist())), 3), len(set(log.tolist())) > 1
    columns = []
    for rank, k in enumerate(powers, start):
        smooth = [hurst**m for m in range(min(several, 3 if rank == 0 else 2))]
        if varied and rank < 2:
            smooth += [log, *([hurst * log] if rank == 0 and several > 1 else [])]
        if len(set(load.tolist())) > 1 and rank < 2:
            smooth.append(load)
        columns += [eps_c**k * term for term in smooth]
    return columns
