"""kappa and mean gap against p_star for many H and three eps_f, in the limit of fine grids and
large cells: hpc_gfmd.reference."""

import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hpc_gfmd import SceneError
from hpc_gfmd.plotting.style import THEORY
from hpc_gfmd.theory import persson
from hpc_gfmd.theory.reference.data import FORMAT

from ..cases import CATALOGUE
from ..estimates import GRID_TERMS, continuum
from ..pictures import named, of_h, panels, points
from ..rows import PRESSURES, Rows, at_load, groups, saying
from ..study import Study

LOADS, LIGHT = (CATALOGUE["series"]["curves"]["loads"][name] for name in ("all", "light"))
RESOLVED = 4  # lam_s/a from which a grid resolves single contacts, which meet it alike
FROM = (0.0, 0.001, PRESSURES["low"], 0.03, 0.12)  # loads from which on errors are quoted
GAP = "gap_over_h_rms"


def limits(runs: Rows, level: str) -> Rows:
    """Find a row for each H, eps_f and p_star: kappa, gap_over_h_rms, NAME_se, Persson's.

    kappa is the mean of what its two routes give, its error half their difference and more; the
    area at light loads is fitted together. None where the gap is closed in some realisation.
    """
    found: dict[str, dict] = {}
    resolved = [run for run in runs if run["lam_s_over_a"] >= RESOLVED]
    for name in GRID_TERMS:
        light = LIGHT if name.startswith("kappa") else ()
        parts = [[run for p_star in light for run in at_load(resolved, p_star)]]
        parts += [at_load(runs, p_star) for p_star in LOADS if p_star not in light]
        found[name] = {}
        for part in parts:
            try:
                found[name] |= continuum(part, name)
            except SceneError:  # not enough runs yet, or closed gaps
                continue
    rows = []
    for p_star, hurst, eps_f in sorted({(r["p_star"], r["hurst"], r["eps_f"]) for r in runs}):
        counted, edge, gap = (at.get((hurst, eps_f, p_star)) for at in found.values())
        row: dict[str, Any] = {"hurst": hurst, "eps_f": eps_f, "p_star": p_star}
        row |= dict.fromkeys(("kappa", "kappa_se"))
        if counted and edge:
            (a, a_se), (b, b_se) = counted, edge
            row |= {"kappa": (a + b) / 2, "kappa_se": float(np.hypot(max(a_se, b_se), (a - b) / 2))}
            row |= {"kappa_counted": a, "kappa_counted_se": a_se}
            row |= {"kappa_edge": b, "kappa_edge_se": b_se}
        row |= dict(zip((GAP, f"{GAP}_se"), gap or (None, None)))
        row["persson_kappa"] = float(persson.kappa(p_star))
        row[f"persson_{GAP}"] = float(persson.mean_gap(p_star, hurst, eps_f))
        rows.append(row)
    return rows


def findings(rows: Rows) -> Iterator[dict]:
    """Say how precise it is, how far theory is off, how the two routes agree."""
    known = [row for row in rows if row["kappa"]]
    gaps = [row for row in rows if row[GAP] and row["p_star"] <= PRESSURES["high"] * 1.01]
    if not known or not gaps:
        return

    def worst(part, name, low):
        errors = [row[f"{name}_se"] / row[name] for row in part if row["p_star"] >= low]
        return f"{max(errors, default=0):.1%} from p* = {low:.3g}"

    for part, name, what in ((known, "kappa", "kappa"), (gaps, GAP, "the mean gap up to 0.354")):
        found = ", ".join(worst(part, name, low) for low in FROM)
        yield saying(f"largest standard error of {what}", found)
    apart = [
        abs(row["kappa_counted"] - row["kappa_edge"])
        / np.hypot(row["kappa_counted_se"], row["kappa_edge_se"])
        for row in known
    ]
    yield saying(
        "as counted and edge-corrected, which must meet",
        f"apart by {np.median(apart):.1f} standard errors in the median, {max(apart):.1f} at most",
    )
    for part, name in ((known, "kappa"), (gaps, GAP)):
        over = [row[name] / row[f"persson_{name}"] for row in part]
        yield saying(f"{name} over Persson's theory", f"{min(over):.2f} to {max(over):.2f}")


def draw(rows: Rows, path: Path) -> None:
    """Draw kappa and gap/h_rms against p_star, a column for each eps_f; lines: Persson."""
    columns = groups(rows, "eps_f") or {1.0: []}
    p_star = np.geomspace(LOADS[0], 1.6, 60)
    with panels(path, len(columns), 2, sharex=True, sharey="row") as axes:
        for (area, gap), (eps_f, part) in zip(axes.T, reversed(columns.items())):
            for hurst, curve in groups(part, "hurst").items():
                how = of_h(hurst)
                for ax, name in ((area, "kappa"), (gap, GAP)):
                    points(ax, curve, "p_star", name, linestyle="-", **how)
                theory = persson.mean_gap(p_star, hurst, eps_f)
                gap.plot(p_star, theory, color=how["color"], linestyle="--", linewidth=0.7)
            area.plot(p_star, persson.kappa(p_star), linestyle="--", label="Persson", **THEORY)
            first = area is axes[0, 0]
            title = f"$\\epsilon_f = 1/{1 / eps_f:g}$"
            named(area, "", "kappa" if first else "", xscale="log", title=title)
            named(gap, "p_star", GAP if first else "", yscale="log", ylim=(1e-5, 6))


DIGITS = 5  # of values and uncertainties
WORST = 0.25  # relative standard error of a load that is still of use
NOTE = (
    "Means over realisations of periodic, self-affine, isotropic surfaces with random amplitudes"
    " and sharp cutoffs, extrapolated to large cells (eps_t -> 0) and fine grids (eps_c -> 0)."
    " sigma: relative standard errors of realisations, solver and extrapolation. The mean gap ends"
    " at p_star = {end:g}: above, it closes (contact everywhere) in some cells or is open at a"
    f" few last spots, whose mean over surfaces is not known to {WORST:.0%} at every H and eps_f."
)


def reference_data(runs: Rows, level: str) -> str:
    """Write the data file of hpc_gfmd.reference as text. Raises SceneError where there are not all
    curves."""
    runs = [run for run in runs if run["status"] == "converged"]
    rows = limits(runs, level)
    axes = {name: sorted({row[name] for row in rows}) for name in ("hurst", "eps_f")}
    at = {(row["hurst"], row["eps_f"], row["p_star"]): row for row in rows}
    tables: dict[str, dict] = {"p_star": {}, "value": {}, "sigma": {}}
    for name, column in (("a_r", "kappa"), (GAP, GAP)):
        loads = _loads(rows, column, len(axes["hurst"]) * len(axes["eps_f"]))
        if len(loads) < 2:
            raise SceneError("--reference: found no curves, allowed: a folder with stored runs")

        rough = [at[H, e, p] for H in axes["hurst"] for e in axes["eps_f"] for p in loads]
        factors = [row["p_star"] if name == "a_r" else 1 for row in rough]
        value = [row[column] * factor for row, factor in zip(rough, factors)]
        sigma = [row[f"{column}_se"] / row[column] for row in rough]
        tables["p_star"][name] = loads
        for what, flat in (("value", value), ("sigma", sigma)):
            rounded = [float(f"{x:.{DIGITS}g}") for x in flat]
            shape = (*map(len, axes.values()), len(loads))
            tables[what][name] = np.reshape(rounded, shape).tolist()
    data = {
        "format": FORMAT,
        "note": NOTE.format(end=tables["p_star"][GAP][-1]),
        "provenance": {
            "command": f"python scripts/paper curves --level {level} --no-run --reference FILE",
            "level": level,
            "versions": sorted({run["version"] for run in runs}),
            "accuracy": sorted({run["accuracy"] for run in runs}),
            "runs": len(runs),
            "date": time.strftime("%Y-%m-%d", time.gmtime()),
        },
    }
    return json.dumps(data | axes | tables) + "\n"


def _loads(rows, column, curves):
    """List the loads at which all curves are known well enough, up to the first where not."""
    loads: list[float] = []
    for p_star, part in groups(rows, "p_star").items():
        known = [r for r in part if r[column] and r[f"{column}_se"] < WORST * r[column]]
        if len(known) == curves:
            loads.append(p_star)
        elif loads:
            break
    return loads


STUDIES = (Study("curves", limits, draw, findings),)
