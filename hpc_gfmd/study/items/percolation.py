"""The contact area at which contact first percolates, by finite-size scaling."""

from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.stats import norm

from ...plotting.style import COLOURS, THEORY, figure
from ..draw import points
from ..levels import series_of
from ..markdown import table
from ..paper import quoted, saying
from ..rows import Rows, by_hurst, longest
from ..study import Study

HURST = (0.3, 0.5, 0.8)
LOADS = (0.12, 0.15, 0.18, 0.2, 0.22, 0.24, 0.26, 0.28, 0.31, 0.35, 0.4)
ROWS = {  # as in levels.py
    "quick": ((1, 4, 4, 3, (0.5,)), (2, 4, 4, 3, (0.5,))),
    "desk": ((1, 16, 8, 40), (2, 16, 8, 80), (4, 16, 8, 30), (8, 16, 8, 6), (4, 16, 4, 12), (4, 16, 16, 4)),
    "paper": ((1, 64, 16, 200), (2, 64, 16, 200), (4, 64, 16, 100), (8, 64, 16, 50), (16, 64, 8, 16), (4, 64, 8, 100), (4, 64, 4, 100)),
}
SYSTEM = ("hurst", "L_over_lam_l", "lam_l_over_lam_s", "lam_s_over_a")
RULES = {"along_x_or_y": np.logical_or, "along_x_and_y": np.logical_and}
SEVERAL = 6  # surfaces from which on their width means something
NU = 4 / 3  # of the correlation length in two dimensions
HALF = 0.521058  # share of square cells in which a cluster wraps along a given axis, at the threshold of large ones (Newman, Ziff 2001)


def thresholds(runs: Rows, level: str) -> Rows:
    """A row for each H and size.

    Columns a_c and a_c_se, the edge-corrected contact area at which HALF of the surfaces percolate along a given axis, of points that
    share sides (a_c_sides), corners (a_c_corners) and of both together; width: standard deviation of the area at which single surfaces
    do; a_c_shared: a_c of those surfaces that were solved on all grids; for each of RULES the area at which half of the surfaces fulfil
    it.
    """
    systems: dict[tuple, dict[int, Rows]] = defaultdict(lambda: defaultdict(list))
    for run in sorted(runs, key=lambda run: run["p_star"]):
        systems[tuple(run[name] for name in SYSTEM)][run["seed"]].append(run)
    rows = []
    for system, surfaces in sorted(systems.items()):
        row = dict(zip(SYSTEM, system, strict=True)) | {"surfaces": len(surfaces)}
        row |= {"eps_t": 1 / system[1], "eps_c": 1 / system[3], "grid": f"{system[2]:g} {system[3]:g}"}
        bounds = {end: [[_between(sweep, f"contact_percolates_{axis}{end}") for axis in "xy"] for sweep in surfaces.values()]
                  for end in ("", "_8")}
        both = np.concatenate([bounds[""], bounds["_8"]], axis=1)  # two axes of two kinds for each surface
        row["a_c"], row["width"] = _middle(both, HALF)
        row["a_c_se"] = _jackknife(both)
        for name, end in (("a_c_sides", ""), ("a_c_corners", "_8")):
            row[name] = _middle(np.array(bounds[end]), HALF)[0]
        shared = set.intersection(*(set(other) for key, other in systems.items() if key[:3] == system[:3]))
        row["a_c_shared"] = _middle(both[[seed in shared for seed in surfaces]], HALF)[0] if shared else None
        for name, rule in RULES.items():
            of = np.min if rule is np.logical_or else np.max
            row[name] = _middle(np.concatenate([of(bounds[end], axis=1)[:, None] for end in bounds], axis=1), 0.5)[0]
        rows.append(row)
    return rows


def _between(sweep: Rows, name: str) -> tuple[float, float]:
    """(area at the last load without, area at the first load with percolation), 0 and 1 where there is none."""
    first = next((k for k, run in enumerate(sweep) if run[name]), len(sweep))
    area = [0.0, *(run["a_r_edge"] for run in sweep), 1.0]
    return area[first], area[first + 1]


def _middle(bounds: Any, share: float) -> tuple[float, float]:
    """(area at which `share` of the surfaces percolate, standard deviation) of a normal distribution, the likeliest for these bounds,
    shape (surfaces, ..., 2)."""
    low, high = np.reshape(bounds, (-1, 2)).T
    inside = (low > 0) & (high < 1)
    start = np.mean((low + high)[inside]) / 2 if inside.any() else 0.4, np.log(0.03)

    def misfit(x: np.ndarray) -> float:
        return -np.sum(np.log(np.maximum(norm.cdf((high - x[0]) / np.exp(x[1])) - norm.cdf((low - x[0]) / np.exp(x[1])), 1e-12)))

    mean, log = minimize(misfit, start, method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-4}).x
    return float(mean + np.exp(log) * norm.ppf(share)), float(np.exp(log))


def _jackknife(bounds: np.ndarray) -> float:
    """Standard error of the area, from what each of at most 20 groups of surfaces changes."""
    groups = np.array_split(np.arange(len(bounds)), min(len(bounds), 20))
    left = [_middle(np.delete(bounds, group, axis=0), HALF)[0] for group in groups]
    return float(np.sqrt((len(groups) - 1) * np.var(left)))


def large(rows: Rows) -> dict[float, dict]:
    """{H: limit of large cells}, from the sizes at the lam_l/lam_s and lam_s/a with most of them: a_c and a_c_se, the mean over cells
    of at least two lam_l, where a_c hardly depends on the size; exponent: of the width in L/lam_l; surfaces: all of them."""
    found = {}
    for hurst, part in by_hurst(rows).items():
        part = longest(part, "eps_t", "grid")
        many = [row for row in part if row["surfaces"] >= SEVERAL]
        size, width, count = (np.array([row[name] for row in many], dtype=float) for name in ("L_over_lam_l", "width", "surfaces"))
        big = [row for row in part if row["L_over_lam_l"] >= 2]
        area, error = np.array([row["a_c"] for row in big]), np.array([row["a_c_se"] for row in big])
        if not len(big) or not (error > 0).all():
            continue
        mean = float(np.average(area, weights=error**-2))
        chi2 = float(np.sum(((area - mean) / error) ** 2)) / max(len(big) - 1, 1)
        found[hurst] = {"a_c": mean, "a_c_se": float(np.sqrt(max(1.0, chi2) / np.sum(error**-2))),
                        "surfaces": sum(row["surfaces"] for row in part), "exponent": None}
        if len(many) > 1:
            found[hurst]["exponent"] = float(np.polyfit(np.log(size), np.log(width), 1, w=np.sqrt(count))[0])
    return found


def findings(rows: Rows) -> Rows:
    """The critical area, what grid and connectivity do to it, the width."""
    limit, sides = large(rows), [row["a_c_sides"] - row["a_c_corners"] for row in rows]
    if not limit:
        return []
    lines = [saying("critical contact area 0.42 (Dapp, Müser 2016), 0.415 (Wang, Müser 2021)",
                    ", ".join(f"{quoted(x['a_c'], x['a_c_se'])} (H = {hurst:g}, {x['surfaces']} surfaces)"
                              for hurst, x in limit.items()),
                    "edge-corrected area at which a cluster of contact goes around the cell along a given axis in "
                    f"{HALF:.1%} of the cells, cells of two lam_l and more"),
             saying("points that share corners instead of sides",
                    f"percolate {min(sides):.3f} to {max(sides):.3f} earlier; a_c is the mean of both",
                    "contact that shares corners percolates where gap that shares sides ceases to"),
             saying(f"width falls as L^-{1 / NU:g} in two dimensions",
                    ", ".join(f"L^{x['exponent']:.2f} (H = {hurst:g})" for hurst, x in limit.items() if x["exponent"]))]
    for hurst, part in by_hurst(rows).items():
        grids = longest([row for row in part if row["a_c_shared"]], "eps_c", "L_over_lam_l")
        if len({row["eps_c"] for row in grids}) > 1:
            lines.append(saying(f"finer grids, H = {hurst:g}, L/lam_l = {grids[0]['L_over_lam_l']:g}", ", ".join(
                f"{row['a_c_shared']:.4f} (lam_s/a = {row['lam_s_over_a']:g})"
                for row in sorted(grids, key=lambda row: -row["eps_c"])), "the same surfaces on all grids"))
    return lines


def numbers(rows: Rows) -> str:
    """All systems."""
    lines = [{"H": f"{row['hurst']:g}", "L": f"{row['L_over_lam_l']:g}", "F": f"1/{row['lam_l_over_lam_s']:g}",
              "C": f"1/{row['lam_s_over_a']:g}", "n": row["surfaces"], "a_c": quoted(row["a_c"], row["a_c_se"])}
             | {name: f"{row[name]:.3f}" for name in ("a_c_sides", "a_c_corners", *RULES, "width")} for row in rows]
    return table(lines, {"H": "H", "L": "L/lam_l", "F": "eps_f", "C": "eps_c", "n": "surfaces", "a_c": "a_c", "a_c_sides": "sides",
                         "a_c_corners": "corners", "along_x_or_y": "x or y", "along_x_and_y": "x and y", "width": "width"})


def draw(rows: Rows, path: Path) -> None:
    """a_c and its width against L/lam_l, the two rules as thin lines."""
    with figure(path, 7.6, 3.2) as fig:
        left, right = fig.subplots(1, 2)
        for (hurst, part), shade in zip(by_hurst(rows).items(), COLOURS, strict=False):
            part = sorted(longest(part, "eps_t", "grid"), key=lambda row: row["L_over_lam_l"])
            size = [row["L_over_lam_l"] for row in part]
            points(left, part, "L_over_lam_l", "a_c", shade, label=f"$H = {hurst:g}$", line="-")
            for name in RULES:
                left.plot(size, [row[name] for row in part], color=shade, linewidth=0.6, linestyle="--")
            many = [row for row in part if row["surfaces"] >= SEVERAL]
            right.plot([row["L_over_lam_l"] for row in many], [row["width"] for row in many], color=shade, marker="o")
        left.axhspan(0.415, 0.42, color="0.85", zorder=0, label="literature")
        if rows:
            ends = np.array([1.0, max(row["L_over_lam_l"] for row in rows)])
            right.plot(ends, 0.08 * ends ** (-1 / NU), label=r"$\propto\mathcal{L}^{-3/4}$", **THEORY)
        left.set(xscale="log", xlabel=r"$\mathcal{L}/\lambda_l$", ylabel="contact area at percolation")
        right.set(xscale="log", yscale="log", xlabel=r"$\mathcal{L}/\lambda_l$", ylabel="width")
        sizes = sorted({row["L_over_lam_l"] for row in rows})
        for ax in (left, right):
            ax.set_xticks(sizes, [f"{size:g}" for size in sizes])
            ax.set_xticks([], minor=True)
        left.legend()
        right.legend()


QUESTION = """At which contact area does contact first go around the periodic cell, so that no fluid passes any more, and does
that depend on H? Surfaces are loaded in small steps; the area at percolation lies between two loads, and a normal
distribution is fitted to these bounds (largest likelihood). Dashed in the picture: along x or y, along x and y."""

STUDIES = (
    Study("percolation", "The contact area at which contact percolates", "critical area near 0.42",
          series_of(ROWS, HURST, LOADS, observables=("percolation", "percolation_8")), thresholds, draw, findings, QUESTION, numbers),
)
