"""The data file of hpc_gfmd.reference, made from the limits of the study "curves"."""

import json
import time
from pathlib import Path
from typing import Any

from hpc_gfmd.theory.reference.data import FORMAT
from hpc_gfmd.util.errors import SceneError

from . import catalogue
from .publish import write_whole
from .rows import Rows
from .store import Store

DIGITS = 5  # of values and uncertainties
WORST = 0.25  # relative standard error of a load that is still of use
NOTE = (
    "Means over realisations of periodic, self-affine, isotropic surfaces with random amplitudes"
    " and sharp cutoffs, extrapolated to large cells (eps_t -> 0) and fine grids (eps_c -> 0)."
    " sigma: relative standard errors of realisations, solver and extrapolation. The mean gap ends"
    " at p_star = {end:g}: above, it closes (contact everywhere) in some cells or is open at a"
    f" few last spots, whose mean over surfaces is not known to {WORST:.0%} at every H and eps_f."
)


def write_reference(path: str | Path, store: Store, level: str) -> int:
    """Write the reference curves of a level; returns their number. Raises SceneError where nothing
    is stored of every one of them."""
    study = catalogue.study("curves")
    runs = [run for run in store.runs_of(study.cases(level)) if run["status"] == "converged"]
    rows = study.tabulate(runs, level)
    axes = {name: sorted({row[name] for row in rows}) for name in ("hurst", "eps_f")}
    tables: dict[str, dict] = {"p_star": {}, "value": {}, "sigma": {}}
    for name, column, factor in (
        ("a_r", "kappa", "p_star"),
        ("gap_over_h_rms", "gap_over_h_rms", None),
    ):
        loads = _loads(rows, column, len(axes["hurst"]) * len(axes["eps_f"]))
        if len(loads) < 2:
            raise SceneError(
                f"--reference: found no curves of level {level} in {store.folder}, allowed: a"
                " folder with stored runs"
            )
        at = {(row["hurst"], row["eps_f"], row["p_star"]): row for row in rows}
        rough = [
            [[at[hurst, eps_f, p] for p in loads] for eps_f in axes["eps_f"]]
            for hurst in axes["hurst"]
        ]
        tables["p_star"][name] = loads
        tables["value"][name] = [
            [
                [_rounded(row[column] * (row[factor] if factor else 1)) for row in line]
                for line in part
            ]
            for part in rough
        ]
        tables["sigma"][name] = [
            [[_rounded(row[f"{column}_se"] / row[column]) for row in line] for line in part]
            for part in rough
        ]
    data = {
        "format": FORMAT,
        "note": NOTE.format(end=tables["p_star"]["gap_over_h_rms"][-1]),
        "provenance": {
            "command": f"python scripts/paper curves --level {level} --no-run --reference FILE",
            "level": level,
            "versions": sorted({run["version"] for run in runs}),
            "accuracy": sorted({run["accuracy"] for run in runs}),
            "runs": len(runs),
            "date": time.strftime("%Y-%m-%d", time.gmtime()),
        },
    }
    write_whole(path, json.dumps(data | axes | tables) + "\n")
    return len(axes["hurst"]) * len(axes["eps_f"])


def _loads(rows: Rows, column: str, curves: int) -> list[float]:
    """The loads at which all curves are known well enough, up to the first where they are not."""
    loads: list[float] = []
    for p_star in sorted({row["p_star"] for row in rows}):
        known = [
            row
            for row in rows
            if row["p_star"] == p_star and row[column] and row[f"{column}_se"] < WORST * row[column]
        ]
        if len(known) < curves:
            if loads:
                break
            continue
        loads.append(p_star)
    return loads


def _rounded(value: Any) -> float:
    return float(f"{value:.{DIGITS}g}")
