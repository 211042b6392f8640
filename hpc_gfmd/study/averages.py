"""Means over realisations with their standard errors: the rows of the figures."""

from collections import defaultdict
from collections.abc import Iterator

import numpy as np

from .rows import Rows
from .scatter import Scatter

RATIOS = ("L_over_lam_l", "lam_l_over_lam_s", "lam_s_over_a")
COLUMNS = ("hurst", "p_star", *RATIOS, "eps_t", "eps_f", "eps_c", "n")


def average(runs: Rows, observables: tuple[str, ...]) -> Rows:
    """One row per surface statistics and pressure, ordered: COLUMNS, n_seeds and, for each observable, its mean and NAME_se.

    The standard error is the scatter of realisations, pooled over neighbouring eps_f (scatter.Scatter), over sqrt(n_seeds); None
    where no group had two seeds. Surfaces that are solved on several grids, some of them for fewer seeds, are averaged as ratios to
    the grid with most seeds, so that means along eps_c do not jump with the choice of seeds.
    """
    families = defaultdict(list)
    for run in runs:
        families[run["hurst"], run["p_star"]].append(run)
    rows: Rows = []
    for key in sorted(families):
        scatter = {name: Scatter.of(families[key], name) for name in observables}
        surfaces = defaultdict(list)
        for run in families[key]:
            surfaces[run["L_over_lam_l"], run["lam_l_over_lam_s"]].append(run)
        for surface in sorted(surfaces):
            rows += _grids_of(surfaces[surface], observables, scatter)
    return rows


def relative_scatter(row: dict, observable: str) -> float | None:
    """Scatter of single realisations over the mean, from the standard error; None where it is not known."""
    se = row.get(f"{observable}_se")
    return se * row["n_seeds"] ** 0.5 / abs(row[observable]) if se is not None else None


def _grids_of(runs: Rows, observables: tuple[str, ...], scatter: dict[str, Scatter]) -> Iterator[dict]:
    grids: dict[float, dict] = defaultdict(dict)
    for run in runs:
        grids[run["lam_s_over_a"]][run["seed"]] = run
    base = max(sorted(grids), key=lambda grid: len(grids[grid]))
    for grid in sorted(grids):
        seeds = grids[grid]
        first = next(iter(seeds.values()))
        row = {name: first[name] for name in COLUMNS} | {"n_seeds": len(seeds)}
        for name in observables:
            row[name], row[f"{name}_se"] = _mean(name, seeds, grids[base], scatter[name])
        yield row


def _mean(name: str, seeds: dict, base: dict, scatter: Scatter) -> tuple[float, float | None]:
    """Mean and standard error of an observable over seeds; base: the same surfaces, and more, on another grid."""
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
