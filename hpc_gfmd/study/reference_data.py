"""The data file of hpc_gfmd.reference, made from the stored sweeps over p_star."""

import json
import time
from collections import defaultdict
from pathlib import Path

import numpy as np

from ..errors import SceneError
from ..reference.data import FORMAT, QUANTITIES
from .levels import gap_pressure_series, pressure_series
from .publish import write_whole
from .store import Store

GROUP = ("hurst", "eps_t", "eps_f", "eps_c", "n")
SOLVED = {name: "a_r_error" if name.startswith("a_r") else "gap_error" for name in QUANTITIES}
DIGITS = 7  # of means and uncertainties
NOTE = (
    "Means over realisations of periodic, self-affine, isotropic surfaces with random amplitudes. Uncertainties are standard errors: "
    "the scatter between realisations, pooled over all eps_f of the same hurst, p_star and eps_t, and the estimated errors of the "
    "solutions. eps_t and eps_c are as given: no correction for them is applied but that of the edge in a_r_edge."
)


def write_reference(path: str | Path, store: Store, level: str) -> int:
    """Write the reference curves of all converged sweeps of a level; returns the number of curves. Raises SceneError if none is
    stored."""
    runs = store.runs_of(pressure_series(level) + gap_pressure_series(level))
    runs = [run for run in runs if run["status"] == "converged"]
    if not runs:
        raise SceneError(f"--reference: found no sweep of level {level} in {store.folder}, allowed: a folder with stored runs")
    curves = defaultdict(list)
    for (p_star, *_), same_load in sorted(_grouped(runs, ("p_star", "hurst", "eps_t")).items()):
        groups = _grouped(same_load, GROUP)
        scatter = {name: _scatter(groups.values(), name) for name in QUANTITIES}
        for group, same in groups.items():
            curves[group].append(_point(p_star, same, scatter))
    curves = [curve for group, points in sorted(curves.items()) if (curve := _curve(group, points))["p_star"]]
    data = {
        "format": FORMAT, "note": NOTE,
        "provenance": {
            "command": f"hpc-gfmd study all --level {level} --no-run --reference FILE", "level": level,
            "versions": sorted({run["version"] for run in runs}), "accuracy": sorted({run["accuracy"] for run in runs}),
            "runs": len(runs), "date": time.strftime("%Y-%m-%d", time.gmtime()),
        },
        "curves": curves,
    }
    write_whole(path, json.dumps(data, indent=1) + "\n")
    return len(curves)


def _grouped(runs, names):
    found = defaultdict(list)
    for run in runs:
        found[tuple(run[name] for name in names)].append(run)
    return found


def _scatter(groups, name):
    """Relative standard deviation between realisations, pooled over groups; nan if none has two."""
    squares, freedom = 0.0, 0
    for same in groups:
        values = np.array([run[name] for run in same])
        if values.any():  # at full contact there is no gap
            squares += ((values / values.mean() - 1) ** 2).sum()
        freedom += len(values) - 1
    return np.sqrt(squares / freedom) if freedom else np.nan


def _point(p_star, same, scatter):
    """p_star, the seeds, and mean and standard error of every quantity; the error is nan where the scatter is unknown."""
    point = {"p_star": p_star, "seeds": [run["seed"] for run in same], "sigma": {}}
    for name in QUANTITIES:
        mean = float(np.mean([run[name] for run in same]))
        random = scatter[name] / np.sqrt(len(same))
        solved = np.mean([run[SOLVED[name]] or 0.0 for run in same])  # bounds: they do not average out
        point[name], point["sigma"][name] = mean, float(mean * np.hypot(random, solved))
    return point


def _curve(group, points):
    """One curve, without loads of unknown uncertainty: those of which nowhere two realisations were solved."""
    points = [point for point in points if np.isfinite(list(point["sigma"].values())).all()]
    found = dict(zip(GROUP, group, strict=True)) | {"p_star": [point["p_star"] for point in points]}
    found |= {"seeds": sorted({seed for point in points for seed in point["seeds"]})}
    found |= {name: [_rounded(point[name]) for point in points] for name in QUANTITIES}
    return found | {"sigma": {name: [_rounded(point["sigma"][name]) for point in points] for name in QUANTITIES}}


def _rounded(value):
    return float(f"{value:.{DIGITS}g}")
