"""Means over realisations with their standard errors: the rows of the figures."""

import numpy as np

from .rows import Rows, groups
from .scatter import Scatter

COLUMNS = (
    "hurst",
    "p_star",
    "L_over_lam_l",
    "lam_l_over_lam_s",
    "lam_s_over_a",
    "eps_t",
    "eps_f",
    "eps_c",
    "n",
)


def average(runs: Rows, observables: tuple[str, ...]) -> Rows:
    """One row per surface statistics and pressure, ordered: COLUMNS, n_seeds and, for each
    observable, its mean and NAME_se.

    The standard error is the scatter of realisations, pooled over neighbouring eps_f
    (scatter.Scatter), over sqrt(n_seeds); None where no group had two seeds. Surfaces that are
    solved on several grids, some of them for fewer seeds, are averaged as ratios to the grid with
    most seeds, so that means along eps_c do not jump with the choice of seeds.
    """
    rows: Rows = []
    for _, family in groups(runs, "hurst", "p_star").items():
        scatter = {name: Scatter.of(family, name) for name in observables}
        for _, surfaces in groups(family, "L_over_lam_l", "lam_l_over_lam_s").items():
            grids = [
                {run["seed"]: run for run in part}
                for part in groups(surfaces, "lam_s_over_a").values()
            ]
            base = max(grids, key=len)
            for seeds in grids:
                first = next(iter(seeds.values()))
                rows.append({name: first[name] for name in COLUMNS} | {"n_seeds": len(seeds)})
                for name in observables:
                    rows[-1][name], rows[-1][f"{name}_se"] = _mean(name, seeds, base, scatter[name])
    return rows


def relative_scatter(row: dict, observable: str) -> float | None:
    """Scatter of single realisations over the mean, from the standard error; None where it is not
    known."""
    se = row.get(f"{observable}_se")
    return se * row["n_seeds"] ** 0.5 / abs(row[observable]) if se is not None else None


def _mean(name: str, seeds: dict, base: dict, scatter: Scatter) -> tuple[float, float | None]:
    """Mean and standard error of an observable over seeds; base: the same surfaces, and more, on
    another grid."""
    some = next(iter(seeds.values()))
    relative = scatter.relative(some["eps_t"], some["eps_f"])
    grids = sum(scatter.grid(run) ** 2 for run in (some, next(iter(base.values()))))
    shared = [seed for seed in seeds if seed in base]
    if len(shared) == len(seeds) and len(base) > len(seeds):
        ratio = np.mean([seeds[s][name] for s in shared]) / np.mean([base[s][name] for s in shared])
        mean = ratio * np.mean([run[name] for run in base.values()])
        square = relative**2 / len(base) + grids / len(seeds)
    else:
        mean, square = np.mean([run[name] for run in seeds.values()]), relative**2 / len(seeds)
    return float(mean), float(abs(mean) * np.sqrt(square)) if np.isfinite(square) else None
