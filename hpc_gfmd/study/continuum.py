"""An observable in the limit of fine grids and large cells at given H and eps_f, all of one pressure together.

    ln value = ln limit(H, eps_f) + C_t(H, eps_f) eps_t + C_1(H, eps_f) eps_c + sum over k of eps_c^k (smooth function of H, ln eps_f)

by generalised least squares with the covariance of runs that share a surface: what realisations add cancels in the differences between
grids. The grid sees single contacts, which hardly know of H and eps_f; what it does is therefore common to all of them (but for C_1 of
the area as counted), and known well even where one surface has few contacts.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from ..errors import SceneError
from .rows import Rows
from .scatter import Scatter

POWERS = {  # of eps_c: (those of every family, those common to all); counted points exceed by the length of the contact boundary
    "kappa": ((1,), (2, 3)), "kappa_edge": ((), (1, 2, 3)), "gap_over_h_rms": ((), (3, 4))}

ROUNDING = 1e-6  # relative: in full contact all values are the same


@dataclass(frozen=True)
class Continuum:
    """value, error: {(H, eps_f): limit, its relative standard error}; chi2: per degree of freedom."""

    value: dict
    error: dict
    chi2: float


def continuum(runs: Rows, observable: str) -> Continuum:
    """The limits of one of POWERS for all H and eps_f among the runs of one p_star.

    Errors are enlarged where the model does not fit within them. Raises SceneError where a value is zero, the scatter not known, or a
    term not determined.
    """
    families = sorted({(run["hurst"], run["eps_f"]) for run in runs})
    parts = [[run for run in runs if (run["hurst"], run["eps_f"]) == family] for family in families]
    runs = [run for part in parts for run in part]
    value = np.array([run[observable] for run in runs])
    if not runs or not (value > 0).all():
        raise SceneError(f"{observable}: found no runs or zeros, allowed: positive values")
    scatter = [Scatter.of(part, observable) for part in parts]
    if any(one.law is None for one in scatter):
        raise SceneError("runs: found one realisation of each surface, allowed: at least two of some")
    errors = block_diag(*(one.covariance(part, observable) for one, part in zip(scatter, parts, strict=True)))
    errors = errors / np.outer(value, value) + ROUNDING**2 * np.eye(len(value))
    own, common = POWERS[observable]
    design = np.column_stack([*_of_families(runs, families, own), *_of_grids(runs, common, len(own))])
    whiten = np.linalg.inv(np.linalg.cholesky(errors))
    white, target = whiten @ design, whiten @ np.log(value)
    scale = np.linalg.norm(white, axis=0)
    found, _, rank, _ = np.linalg.lstsq(white / scale, target, rcond=1e-9)
    if rank < len(found):
        raise SceneError("runs: found too few grids or cells, allowed: as many as there are powers")
    dof = len(value) - len(found)
    chi2 = float(np.sum((target - white / scale @ found) ** 2)) / dof if dof else 1.0
    found, sigma = found / scale, np.sqrt(np.diag(np.linalg.inv((white / scale).T @ (white / scale))) * max(1.0, chi2)) / scale
    count = len(families)
    return Continuum(dict(zip(families, np.exp(found[:count]).tolist(), strict=True)),
                     dict(zip(families, sigma[:count].tolist(), strict=True)), chi2)


def _of_families(runs: Rows, families: list, powers: tuple[int, ...]) -> list[np.ndarray]:
    """A column for the limit of each family, one for its C_t where its cells differ, one for each power of eps_c of its own."""
    which = np.array([families.index((run["hurst"], run["eps_f"])) for run in runs])
    eps_t, eps_c = (np.array([run[name] for run in runs]) for name in ("eps_t", "eps_c"))
    own = [np.where(which == k, 1.0, 0.0) for k in range(len(families))]
    return [*own, *(mask * eps_t for mask in own if np.ptp(eps_t[mask > 0]) > 0), *(mask * eps_c**k for k in powers for mask in own)]


def _of_grids(runs: Rows, powers: tuple[int, ...], start: int) -> list[np.ndarray]:
    """Columns of eps_c^k times smooth functions of H and ln eps_f, the fewer the higher the power, as far as they differ. start: number
    of powers below."""
    eps_c, hurst, log = (np.array(x) for x in zip(*((r["eps_c"], r["hurst"], np.log(r["eps_f"])) for r in runs), strict=True))
    several, varied = min(len(set(hurst.tolist())), 3), len(set(log.tolist())) > 1
    columns = []
    for rank, k in enumerate(powers, start):
        smooth = [hurst**m for m in range(min(several, 3 if rank == 0 else 2))]
        if varied and rank < 2:
            smooth += [log, *([hurst * log] if rank == 0 and several > 1 else [])]
        columns += [eps_c**k * term for term in smooth]
    return columns
