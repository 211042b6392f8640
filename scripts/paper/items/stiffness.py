"""Tangent stiffness at low pressures: the power law of finite systems and its range."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.stats import sem

from hpc_gfmd.plotting.style import COLOURS, THEORY
from hpc_gfmd.theory import persson

from ..estimates import power_law
from ..pictures import draw_points, label_axes, panels
from ..rows import Rows, by_hurst, comparison, groups
from ..study import Study

SYSTEM = ("hurst", "L_over_lam_l", "lam_l_over_lam_s")
GRID = (*SYSTEM, "lam_s_over_a")
LOW = 0.0005  # p_star up to which exponents are averaged


def means(runs: Rows, level: str) -> Rows:
    """Average the stiffness K over surfaces, for each H, system, grid and p_star.

    stiffness is the geometric mean in units of E* g_rms/h_rms, exponent d ln K/d ln p between the
    neighbouring loads of the same surfaces, persson the theory.
    """
    rows = []
    for system, part in groups(runs, *GRID).items():
        sweeps = [
            {
                run["p_star"]: np.log(run["stiffness"] * run["h_rms"] / run["g_rms"])
                for run in sweep
                if run["stiffness"]
            }
            for sweep in groups(part, "seed").values()
        ]
        loads = sorted({p for sweep in sweeps for p in sweep})
        for p, below, above in zip(loads, loads[:1] + loads, loads[1:] + loads[-1:]):
            mean, error = _mean([sweep[p] for sweep in sweeps if p in sweep])
            with_neighbours = [sweep for sweep in sweeps if {below, above} <= set(sweep)]
            step = np.log(above / below)
            slopes = [(sweep[above] - sweep[below]) / step for sweep in with_neighbours]
            slope, slope_error = _mean(slopes)
            row = dict(zip(GRID, system)) | {"p_star": p}
            row |= {"surfaces": sum(p in sweep for sweep in sweeps)}
            row |= {"stiffness": float(np.exp(mean)), "stiffness_se": float(np.exp(mean)) * error}
            row |= {"exponent": slope, "exponent_se": slope_error}
            row |= {"persson": float(persson.stiffness(p, system[0], 1 / system[2]))}
            rows.append(row)
    return rows


def _mean(values):
    """Return the mean and its standard error, nan for a single value."""
    return float(np.mean(values)), float(sem(values)) if len(values) > 1 else np.nan


def power_laws(rows: Rows) -> Rows:
    """Return the mean exponent of each system up to LOW, and the p_star at which its power law
    ends: interpolated to an exponent halfway between 1/(1 + H) and 1, or None.

    Errors of the exponents at neighbouring loads are not independent.
    """
    laws = []
    for system, part in groups(rows, *SYSTEM).items():
        inner = [row for row in part if (row["exponent_se"] or 0) > 0]
        law = dict(zip(SYSTEM, system)) | {"surfaces": part[0]["surfaces"]}
        law |= _load_of_exponent((1 / (1 + system[0]) + 1) / 2, inner)
        low = [row for row in inner[1:] if row["p_star"] <= LOW]
        for name in ("exponent", "exponent_se"):
            law[name] = float(np.mean([row[name] for row in low])) if low else None
        laws.append(law)
    return laws


def _load_of_exponent(exponent, rows):
    """Return the p_star at which the exponent first rises to a value, as ends and ends_se."""
    for a, b in zip(rows, rows[1:]):
        if a["exponent"] < exponent <= b["exponent"]:
            slope = np.log(b["p_star"] / a["p_star"]) / (b["exponent"] - a["exponent"])
            p_star = float(a["p_star"] * np.exp(slope * (exponent - a["exponent"])))
            error = float(p_star * slope * max(a["exponent_se"], b["exponent_se"]))
            return {"ends": p_star, "ends_se": error}
    return {"ends": None, "ends_se": None}


def findings(rows: Rows) -> Iterator[dict]:
    """Compare the exponents with 1/(1 + H) and report where the power laws end."""
    laws = [law for law in power_laws(rows) if law["exponent"] is not None]
    for law in laws:
        yield comparison(
            "H = {hurst:g}, L/lam_l = {L_over_lam_l:g}, eps_f = 1/{lam_l_over_lam_s:g}: K as p^1/(1"
            f" + H) = p^{1 / (1 + law['hurst']):.3f}",
            f"exponent {{exponent:±}} up to p* = {LOW:g}; halfway to 1 at p* = {{ends:±}}",
            "{surfaces} surfaces",
            **law,
        )
    for (hurst, waves), part in groups(laws, "hurst", "lam_l_over_lam_s").items():
        power, error = power_law(part, "L_over_lam_l", "ends")
        if power is not None:
            yield comparison(
                f"H = {hurst:g}, eps_f = 1/{waves:g}: with the size of the cell, p* halfway to 1",
                "goes as L^x with x = {power:±}",
                "as the number of highest hills would: -2",
                power=power,
                power_se=error,
            )


def draw(rows: Rows, path: Path) -> None:
    """Draw K/p_star, which is constant where K is linear, and the local exponent below it."""
    families = by_hurst(rows) or {0.5: []}
    with panels(path, len(families), 2, sharex=True, sharey="row") as axes:
        for (above, below), (hurst, family) in zip(axes.T, families.items()):
            for ((size, waves), part), color in zip(groups(family, *SYSTEM[1:]).items(), COLOURS):
                over_load = [row | _over_load(row) for row in part]
                label = f"$L/\\lambda_l = {size:g}$, $\\epsilon_f = 1/{waves:g}$"
                line = {"linestyle": "-", "color": color}
                draw_points(above, over_load, "p_star", "stiffness", label=label, **line)
                draw_points(above, over_load, "p_star", "persson", "", **line | {"linestyle": "--"})
                draw_points(below, part, "p_star", "exponent", **line)
            below.axhline(1 / (1 + hurst), label="1/(1 + H)", **THEORY)
            below.axhline(1, linestyle=":", **THEORY)
            label_axes(above, "", "", xscale="log", yscale="log", title=f"$H = {hurst:g}$")
            label_axes(below, "p_star", "", ylim=(0.4, 1.8))
        axes[0, 0].set_ylabel(r"$K h_\mathrm{rms}/(E^* g_\mathrm{rms} p^*)$")
        axes[1, 0].set_ylabel(r"$d\,\ln K/d\,\ln p$")


def _over_load(row):
    """Return the columns of stiffness over p_star."""
    return {key: row[key] / row["p_star"] for key in ("stiffness", "stiffness_se", "persson")}


STUDIES = (Study("stiffness", means, draw, findings),)
