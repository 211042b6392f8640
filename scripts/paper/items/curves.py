"""kappa and mean gap against p_star for many H and three eps_f in the limit of fine grids and large
cells, and the data of hpc_gfmd.reference."""

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
from ..pictures import draw_points, hurst_style, label_axes, panels
from ..rows import PRESSURES, Rows, at_load, comparison, groups
from ..study import Study

LOADS, LIGHT = (CATALOGUE["series"]["curves"]["loads"][name] for name in ("all", "light"))
RESOLVED = 4  # lam_s/a from which a grid resolves single contacts, on which it then acts alike
ERRORS_FROM = (0.0, 0.001, PRESSURES["low"], 0.03, 0.12)  # loads above which errors are quoted
GAP = "gap_over_h_rms"


def limits(runs: Rows, level: str) -> Rows:
    """Return the limits for each H, eps_f and p_star, with persson_NAME (theory).

    Areas at light loads are fitted together. kappa is the mean of the areas as counted and
    edge-corrected; its error is at least half their difference. The gap is None if it is closed in
    some realisation.
    """
    estimates: dict[str, dict] = {}
    resolved = [run for run in runs if run["lam_s_over_a"] >= RESOLVED]
    for name in GRID_TERMS:
        light = LIGHT if name.startswith("kappa") else ()
        parts = [[run for p_star in light for run in at_load(resolved, p_star)]]
        parts += [at_load(runs, p_star) for p_star in LOADS if p_star not in light]
        estimates[name] = {}
        for part in parts:
            try:
                estimates[name] |= continuum(part, name)
            except SceneError:  # not enough runs yet, or closed gaps
                continue
    rows = []
    for p_star, hurst, eps_f in sorted({(r["p_star"], r["hurst"], r["eps_f"]) for r in runs}):
        counted, edge, gap = (of.get((hurst, eps_f, p_star)) for of in estimates.values())
        row: dict[str, Any] = {"hurst": hurst, "eps_f": eps_f, "p_star": p_star}
        row |= dict.fromkeys(("kappa", "kappa_se"))
        if counted and edge:
            kappa_counted, counted_se = counted
            kappa_edge, edge_se = edge
            half_difference = (kappa_counted - kappa_edge) / 2
            row["kappa"] = (kappa_counted + kappa_edge) / 2
            row["kappa_se"] = float(np.hypot(max(counted_se, edge_se), half_difference))
            row |= {"kappa_counted": kappa_counted, "kappa_counted_se": counted_se}
            row |= {"kappa_edge": kappa_edge, "kappa_edge_se": edge_se}
        row |= dict(zip((GAP, f"{GAP}_se"), gap or (None, None)))
        row["persson_kappa"] = float(persson.kappa(p_star))
        row[f"persson_{GAP}"] = float(persson.mean_gap(p_star, hurst, eps_f))
        rows.append(row)
    return rows


def findings(rows: Rows) -> Iterator[dict]:
    """Report the precision, the agreement of the two areas, and the error of theory."""
    areas = [row for row in rows if row["kappa"]]
    gaps = [row for row in rows if row[GAP] and row["p_star"] <= PRESSURES["high"] * 1.01]
    if not areas or not gaps:
        return

    def worst(part, name, low):
        errors = [row[f"{name}_se"] / row[name] for row in part if row["p_star"] >= low]
        return f"{max(errors, default=0):.1%} from p* = {low:.3g}"

    for part, name, title in ((areas, "kappa", "kappa"), (gaps, GAP, "the mean gap up to 0.354")):
        largest = ", ".join(worst(part, name, low) for low in ERRORS_FROM)
        yield comparison(f"largest standard error of {title}", largest)
    differences = [
        abs(row["kappa_counted"] - row["kappa_edge"])
        / np.hypot(row["kappa_counted_se"], row["kappa_edge_se"])
        for row in areas
    ]
    yield comparison(
        "as counted and edge-corrected, which must meet",
        f"apart by {np.median(differences):.1f} standard errors in the median,"
        f" {max(differences):.1f} at most",
    )
    for part, name in ((areas, "kappa"), (gaps, GAP)):
        ratios = [row[name] / row[f"persson_{name}"] for row in part]
        yield comparison(f"{name} over Persson's theory", f"{min(ratios):.2f} to {max(ratios):.2f}")


def draw(rows: Rows, path: Path) -> None:
    """Draw kappa and gap/h_rms against p_star, a column for each eps_f, with Persson's theory."""
    columns = groups(rows, "eps_f") or {1.0: []}
    p_star = np.geomspace(LOADS[0], 1.6, 60)
    with panels(path, len(columns), 2, sharex=True, sharey="row") as axes:
        for (area, gap), (eps_f, part) in zip(axes.T, reversed(columns.items())):
            for hurst, curve in groups(part, "hurst").items():
                style = hurst_style(hurst)
                for ax, name in ((area, "kappa"), (gap, GAP)):
                    draw_points(ax, curve, "p_star", name, linestyle="-", **style)
                theory = persson.mean_gap(p_star, hurst, eps_f)
                gap.plot(p_star, theory, color=style["color"], linestyle="--", linewidth=0.7)
            area.plot(p_star, persson.kappa(p_star), linestyle="--", label="Persson", **THEORY)
            is_left = area is axes[0, 0]
            title = f"$\\epsilon_f = 1/{1 / eps_f:g}$"
            label_axes(area, "", "kappa" if is_left else "", xscale="log", title=title)
            label_axes(gap, "p_star", GAP if is_left else "", yscale="log", ylim=(1e-5, 6))


DIGITS = 5  # significant digits of values and uncertainties
WORST = 0.25  # largest relative standard error of a load in the data
NOTE = (
    "Means over realisations of periodic, self-affine, isotropic surfaces with random amplitudes"
    " and sharp cutoffs, extrapolated to large cells (eps_t -> 0) and fine grids (eps_c -> 0)."
    " sigma: relative standard errors of realisations, solver and extrapolation. The mean gap ends"
    " at p_star = {end:g}: above, it closes (contact everywhere) in some cells or is open at a"
    f" few last spots, whose mean over surfaces is not known to {WORST:.0%} at every H and eps_f."
)


def reference_data(runs: Rows, level: str) -> str:
    """Return the data file of hpc_gfmd.reference as text, from the runs of all curves that
    converged. Raises SceneError if a curve is missing."""
    runs = [run for run in runs if run["status"] == "converged"]
    rows = limits(runs, level)
    axes = {name: sorted({row[name] for row in rows}) for name in ("hurst", "eps_f")}
    row_at = {(row["hurst"], row["eps_f"], row["p_star"]): row for row in rows}
    tables: dict[str, dict] = {"p_star": {}, "value": {}, "sigma": {}}
    for name, column in (("a_r", "kappa"), (GAP, GAP)):
        loads = _loads(rows, column, len(axes["hurst"]) * len(axes["eps_f"]))
        if len(loads) < 2:
            raise SceneError("--reference: found no curves, allowed: a folder with stored runs")

        points = [row_at[H, e, p] for H in axes["hurst"] for e in axes["eps_f"] for p in loads]
        factors = [row["p_star"] if name == "a_r" else 1 for row in points]
        value = [row[column] * factor for row, factor in zip(points, factors)]
        sigma = [row[f"{column}_se"] / row[column] for row in points]
        tables["p_star"][name] = loads
        for key, numbers in (("value", value), ("sigma", sigma)):
            rounded = [float(f"{x:.{DIGITS}g}") for x in numbers]
            shape = (*map(len, axes.values()), len(loads))
            tables[key][name] = np.reshape(rounded, shape).tolist()
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
    """Return the loads at which all curves are precise enough, up to the first where one is not."""
    loads: list[float] = []
    for p_star, part in groups(rows, "p_star").items():
        precise = [row for row in part if row[column] and row[f"{column}_se"] < WORST * row[column]]
        if len(precise) == curves:
            loads.append(p_star)
        elif loads:
            break
    return loads


STUDIES = (Study("curves", limits, draw, findings),)
