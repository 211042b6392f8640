"""Tangent stiffness at low pressures: the power law of finite systems, and where it ends."""

from collections import defaultdict
from pathlib import Path

import numpy as np

from ...plotting.style import COLOURS, THEORY, figure
from ...theory import persson
from ..draw import points
from ..levels import series_of
from ..markdown import table
from ..paper import quoted, saying
from ..rows import Rows, by_hurst
from ..study import Study

HURST = (0.3, 0.5, 0.8)
LOADS = tuple(1e-4 * 2**k for k in range(11))
LOWER = (2.5e-5, 5e-5, *LOADS)  # of larger cells, where the power law ends earlier
WIDE = tuple(1e-5 * 4**k for k in range(7))  # of cells with more decades of roughness
ROWS = {  # as in levels.py; at the end other loads
    "quick": ((1, 16, 2, 2, (0.5,)), (2, 16, 2, 2, (0.5,))),
    "desk": (
        (1, 128, 2, 40), (2, 128, 2, 20, HURST, LOWER), (4, 128, 2, 20, HURST, LOWER),
        (1, 256, 2, 30), (1, 512, 2, 10, HURST, WIDE),
    ),
    "paper": ((1, 1024, 2, 100), (2, 1024, 2, 50), (4, 1024, 2, 20), (8, 1024, 2, 10)),
}
LOW, LINEAR = 0.0005, 0.01  # p_star up to which the power law is fitted, and about which K is compared with a line


def means(runs: Rows, level: str) -> Rows:
    """A row for each H, size and p_star: stiffness in units of E* g_rms/h_rms, the geometric mean over surfaces and its standard error;
    exponent, exponent_se: d ln K/d ln p between the neighbouring loads of the same surfaces; persson: theory."""
    systems: dict[tuple, dict[int, dict]] = defaultdict(lambda: defaultdict(dict))
    for run in runs:
        if run["stiffness"]:
            key = run["hurst"], run["L_over_lam_l"], run["lam_l_over_lam_s"], run["lam_s_over_a"]
            systems[key][run["seed"]][run["p_star"]] = np.log(run["stiffness"] * run["h_rms"] / run["g_rms"])
    rows = []
    for (hurst, L, F, C), surfaces in sorted(systems.items()):
        loads = sorted({p for sweep in surfaces.values() for p in sweep})
        for k, p_star in enumerate(loads):
            values = [sweep[p_star] for sweep in surfaces.values() if p_star in sweep]
            below, above = loads[max(k - 1, 0)], loads[min(k + 1, len(loads) - 1)]
            slopes = [(sweep[above] - sweep[below]) / np.log(above / below) for sweep in surfaces.values()
                      if {below, above} <= set(sweep)]
            (mean, error), (slope, slope_error) = _mean(values), _mean(slopes)
            stiffness = float(np.exp(mean))
            rows.append({"hurst": hurst, "L_over_lam_l": L, "lam_l_over_lam_s": F, "lam_s_over_a": C, "p_star": p_star,
                         "surfaces": len(values), "stiffness": stiffness, "stiffness_se": stiffness * error, "exponent": slope,
                         "exponent_se": slope_error, "persson": float(persson.stiffness(p_star, hurst, 1 / F))})
    return rows


def _mean(values: list[float]) -> tuple[float, float]:
    return float(np.mean(values)), float(np.std(values, ddof=1) / np.sqrt(len(values))) if len(values) > 1 else np.nan


def power_laws(rows: Rows) -> Rows:
    """For each system the mean exponent at the lowest loads, up to LOW, with its standard error; `longer`: up to 3 LOW; `ends`: p_star
    at which it is halfway between 1/(1 + H) and 1, `linear`: at which it is 1, by interpolation, each with its standard error; None
    where it is so nowhere or everywhere."""
    found = []
    for key in sorted({(row["hurst"], row["L_over_lam_l"], row["lam_l_over_lam_s"]) for row in rows}):
        part = [row for row in rows if (row["hurst"], row["L_over_lam_l"], row["lam_l_over_lam_s"]) == key]
        inner = [row for row in part if np.isfinite(row["exponent_se"]) and row["exponent_se"] > 0]
        low = [row for row in inner[1:] if row["p_star"] <= LOW]
        line = dict(zip(("hurst", "L_over_lam_l", "lam_l_over_lam_s"), key, strict=True)) | {"surfaces": part[0]["surfaces"]}
        line["exponent"] = float(np.mean([row["exponent"] for row in low])) if low else None
        line["longer"] = float(np.mean([row["exponent"] for row in inner[1:] if row["p_star"] <= 3 * LOW])) if low else None
        line["exponent_se"] = float(np.mean([row["exponent_se"] for row in low])) if low else None  # of one surface, not independent
        found.append(line | {"ends": _rises_to((1 / (1 + key[0]) + 1) / 2, inner), "linear": _rises_to(1.0, inner)})
    return found


def _rises_to(exponent: float, rows: Rows) -> tuple[float, float] | None:
    for a, b in zip(rows, rows[1:], strict=False):
        if a["exponent"] < exponent <= b["exponent"]:
            slope = np.log(b["p_star"] / a["p_star"]) / (b["exponent"] - a["exponent"])
            p_star = float(a["p_star"] * np.exp(slope * (exponent - a["exponent"])))
            return p_star, float(p_star * slope * max(a["exponent_se"], b["exponent_se"]))
    return None


def ends_with_size(laws: Rows) -> dict[tuple[float, float], tuple[float, float]]:
    """{(H, lam_l/lam_s): (power of L/lam_l with which p_star at the end of the power law goes, standard error)}, of several cells."""
    ends = defaultdict(list)
    for law in laws:
        if law["ends"]:
            p_star, error = law["ends"]
            ends[law["hurst"], law["lam_l_over_lam_s"]].append((np.log(law["L_over_lam_l"]), np.log(p_star), p_star / error))
    found = {}
    for key, of_sizes in ends.items():
        if len(of_sizes) > 1:
            size, end, weight = np.transpose(of_sizes)
            line, covariance = np.polyfit(size, end, 1, w=weight, cov="unscaled")
            found[key] = float(line[0]), float(np.sqrt(covariance[0, 0]))
    return found


def findings(rows: Rows) -> Rows:
    """The exponents beside 1/(1 + H), where they end, the stiffness beside theory."""
    lines = []
    laws = power_laws(rows)
    for law in laws:
        if law["exponent"] is None:
            continue
        what = f"H = {law['hurst']:g}, L/lam_l = {law['L_over_lam_l']:g}, eps_f = 1/{law['lam_l_over_lam_s']:g}"
        ends = f"; halfway to 1 at p* = {quoted(*law['ends'])}" if law["ends"] else ""
        ends += f", 1 at {quoted(*law['linear'])}" if law["linear"] else ""
        lines.append(saying(f"{what}: K as p^{1 / (1 + law['hurst']):.3f} = p^1/(1 + H)",
                            f"exponent {quoted(law['exponent'], law['exponent_se'])} up to p* = {LOW:g}, {law['longer']:.2f} up to "
                            f"{3 * LOW:g}{ends}",
                            f"{law['surfaces']} surfaces"))
    for (hurst, waves), power in ends_with_size(laws).items():
        lines.append(saying(f"H = {hurst:g}, eps_f = 1/{waves:g}: with the size of the cell, p* halfway to 1 goes",
                            f"as (L/lam_l)^({quoted(*power)})", "as the number of highest hills would: -2"))
    for hurst, part in by_hurst(rows).items():
        near_line = [row["stiffness"] / row["persson"] for row in part if LINEAR / 2 < row["p_star"] < 2 * LINEAR]
        if near_line:
            lines.append(saying(f"H = {hurst:g}: stiffness over Persson's theory (large systems) near p* = {LINEAR:g}",
                                f"{min(near_line):.2f} to {max(near_line):.2f}"))
    return lines


def numbers(rows: Rows) -> str:
    """Stiffness and exponent at every load."""
    lines = [{"H": f"{row['hurst']:g}", "L": f"{row['L_over_lam_l']:g}", "F": f"1/{row['lam_l_over_lam_s']:g}", "n": row["surfaces"],
              "p": f"{row['p_star']:.4g}", "K": quoted(row["stiffness"], row["stiffness_se"]),
              "x": quoted(row["exponent"], row["exponent_se"]), "ratio": f"{row['stiffness'] / row['persson']:.3f}"} for row in rows]
    return table(lines, {"H": "H", "L": "L/lam_l", "F": "eps_f", "n": "surfaces", "p": "p*", "K": "K h_rms/(E* g_rms)",
                         "x": "d ln K/d ln p", "ratio": "K over Persson"})


def draw(rows: Rows, path: Path) -> None:
    """K over p_star, which is even where K is linear, and its local exponent, a panel for each H above and below."""
    hursts = list(by_hurst(rows)) or [HURST[0]]
    with figure(path, 2.8 * len(hursts), 4.8) as fig:
        axes = fig.subplots(2, len(hursts), sharex=True, sharey="row", squeeze=False)
        for (above, below), hurst in zip(axes.T, hursts, strict=True):
            systems = defaultdict(list)
            for row in rows:
                if row["hurst"] == hurst:
                    systems[row["L_over_lam_l"], row["lam_l_over_lam_s"]].append(row)
            for (key, part), shade in zip(sorted(systems.items()), COLOURS, strict=False):
                over = [row | {name: row[name] / row["p_star"] for name in ("stiffness", "stiffness_se", "persson")} for row in part]
                label = f"$\\mathcal{{L}}/\\lambda_l = {key[0]:g}$, $\\epsilon_f = 1/{key[1]:g}$"
                points(above, over, "p_star", "stiffness", shade, label=label, line="-", size=3)
                points(above, over, "p_star", "persson", shade, "", line="--")
                points(below, part, "p_star", "exponent", shade, line="-", size=3)
            below.axhline(1 / (1 + hurst), **THEORY)
            below.axhline(1, linestyle=":", **THEORY)
            above.set(xscale="log", yscale="log", title=f"$H = {hurst:g}$")
            below.set(xlabel=r"$p^* = p/(E^*\bar g)$", ylim=(0.4, 1.8))
        axes[0][0].set_ylabel(r"$K \bar h/(E^* \bar g p^*)$")
        axes[1][0].set_ylabel(r"$d\,\ln K/d\,\ln p$")
        axes[0][0].legend()


QUESTION = """How does the stiffness -dp/d(mean gap) of a finite rough contact fall at low pressures, and where does the power law
end, also in larger cells? In large systems Persson's theory (dashed) makes it proportional to the pressure; Pastewka,
Prodanov, Lorenz, Müser, Robbins and Persson (2013) find p^1/(1 + H) (line in the lower panels) where the contact is one
clump on the highest hill. The local exponent rises all the way, so that its mean depends on how far up one goes: two are
given. The stiffness is the tangent while no point changes sides; means over surfaces are geometric."""

STUDIES = (
    Study("stiffness", "Tangent stiffness at low pressures", "a power law with exponent 1/(1 + H) in finite systems",
          series_of(ROWS, HURST, LOADS, observables=("stiffness",)), means, draw, findings, QUESTION, numbers),
)
