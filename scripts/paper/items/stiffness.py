"""Tangent stiffness at low pressures: the power law of finite systems, and where it ends."""

from pathlib import Path

import numpy as np
from scipy.stats import sem

from hpc_gfmd.plotting.style import COLOURS, THEORY, figure
from hpc_gfmd.theory import persson

from ..catalogue import Study
from ..draw import points
from ..levels import series_of
from ..paper import Sayings, saying
from ..rows import Rows, by_hurst, groups, where

HURST = (0.3, 0.5, 0.8)
LOADS = tuple(1e-4 * 2**k for k in range(11))
LOWER = (2.5e-5, 5e-5, *LOADS)  # of larger cells, where the power law ends earlier
WIDE = tuple(1e-5 * 4**k for k in range(7))  # of cells with more decades of roughness
ROWS = {  # as in levels.py; at the end other loads
    "quick": ((1, 16, 2, 2, (0.5,)), (2, 16, 2, 2, (0.5,))),
    "desk": (
        (1, 128, 2, 40),
        (2, 128, 2, 20, HURST, LOWER),
        (4, 128, 2, 10, HURST, LOWER),
        (1, 256, 2, 30),
        (1, 512, 2, 10, HURST, WIDE),
    ),
    "paper": ((1, 1024, 2, 100), (2, 1024, 2, 50), (4, 1024, 2, 20), (8, 1024, 2, 10)),
}
SYSTEM = ("hurst", "L_over_lam_l", "lam_l_over_lam_s")
LOW, LINEAR = (
    0.0005,
    0.01,
)  # p_star up to which the power law is fitted, and about which K is compared with a line


def means(runs: Rows, level: str) -> Rows:
    """A row for each H, size and p_star: stiffness in units of E* g_rms/h_rms, the geometric mean
    over surfaces and its standard error; exponent, exponent_se: d ln K/d ln p between the
    neighbouring loads of the same surfaces; persson: theory."""
    runs = [
        run | {"log": np.log(run["stiffness"] * run["h_rms"] / run["g_rms"])}
        for run in runs
        if run["stiffness"]
    ]
    rows = []
    for system, part in groups(runs, *SYSTEM, "lam_s_over_a").items():
        sweeps = [
            {run["p_star"]: run["log"] for run in sweep} for sweep in groups(part, "seed").values()
        ]
        loads = sorted({p for sweep in sweeps for p in sweep})
        for p_star, below, above in zip(
            loads, [loads[0], *loads], [*loads[1:], loads[-1]], strict=False
        ):
            mean, error = _mean([sweep[p_star] for sweep in sweeps if p_star in sweep])
            slope, slope_error = _mean(
                [
                    (sweep[above] - sweep[below]) / np.log(above / below)
                    for sweep in sweeps
                    if {below, above} <= set(sweep)
                ]
            )
            stiffness = float(np.exp(mean))
            rows.append(
                dict(zip((*SYSTEM, "lam_s_over_a"), system, strict=True))
                | {
                    "p_star": p_star,
                    "surfaces": sum(p_star in sweep for sweep in sweeps),
                    "stiffness": stiffness,
                    "stiffness_se": stiffness * error,
                    "exponent": slope,
                    "exponent_se": slope_error,
                    "persson": float(persson.stiffness(p_star, system[0], 1 / system[2])),
                }
            )
    return rows


def _mean(values: list[float]) -> tuple[float, float]:
    return float(np.mean(values)), float(sem(values)) if len(values) > 1 else np.nan


def power_laws(rows: Rows) -> Rows:
    """For each system the mean exponent at the lowest loads, up to LOW, with its standard error;
    `longer`: up to 3 LOW; `ends`: p_star at which it is halfway between 1/(1 + H) and 1, `linear`:
    at which it is 1, by interpolation, and their _se; None where it is so nowhere or everywhere."""
    found = []
    for system, part in groups(rows, *SYSTEM).items():
        inner = [row for row in part if np.isfinite(row["exponent_se"]) and row["exponent_se"] > 0]
        low, longer = (
            [row for row in inner[1:] if row["p_star"] <= p_star] for p_star in (LOW, 3 * LOW)
        )
        found.append(
            dict(zip(SYSTEM, system, strict=True))
            | {
                "surfaces": part[0]["surfaces"],
                **_rises_to("ends", (1 / (1 + system[0]) + 1) / 2, inner),
                **_rises_to("linear", 1.0, inner),
                "exponent": float(np.mean([row["exponent"] for row in low])) if low else None,
                "exponent_se": (
                    float(np.mean([row["exponent_se"] for row in low])) if low else None
                ),  # of one surface, not independent
                "longer": float(np.mean([row["exponent"] for row in longer])) if low else None,
            }
        )
    return found


def _rises_to(name: str, exponent: float, rows: Rows) -> dict[str, float | None]:
    for a, b in zip(rows, rows[1:], strict=False):
        if a["exponent"] < exponent <= b["exponent"]:
            slope = np.log(b["p_star"] / a["p_star"]) / (b["exponent"] - a["exponent"])
            p_star = float(a["p_star"] * np.exp(slope * (exponent - a["exponent"])))
            return {
                name: p_star,
                f"{name}_se": float(p_star * slope * max(a["exponent_se"], b["exponent_se"])),
            }
    return {name: None, f"{name}_se": None}


def ends_with_size(laws: Rows) -> Rows:
    """For each H and lam_l/lam_s of which several cells are known: power of L/lam_l with which
    `ends` goes, power_se."""
    found = []
    for (hurst, waves), part in groups(
        [law for law in laws if law["ends"]], "hurst", "lam_l_over_lam_s"
    ).items():
        if len(part) > 1:
            size, end, error = (
                np.array([law[name] for law in part])
                for name in ("L_over_lam_l", "ends", "ends_se")
            )
            (power, _), covariance = np.polyfit(
                np.log(size), np.log(end), 1, w=end / error, cov="unscaled"
            )
            found.append(
                {
                    "hurst": hurst,
                    "lam_l_over_lam_s": waves,
                    "power": float(power),
                    "power_se": float(covariance[0, 0] ** 0.5),
                }
            )
    return found


def findings(rows: Rows) -> Sayings:
    """The exponents beside 1/(1 + H), where they end, the stiffness beside theory."""
    laws = power_laws(rows)
    for law in laws:
        if law["exponent"] is not None:
            yield saying(
                "H = {hurst:g}, L/lam_l = {L_over_lam_l:g}, eps_f = 1/{lam_l_over_lam_s:g}: K as"
                " p^{expected:.3f} = p^1/(1 + H)",
                f"exponent {{exponent:±}} up to p* = {LOW:g}, {{longer:.2f}} up to {3 * LOW:g}"
                + ("; halfway to 1 at p* = {ends:±}" if law["ends"] else "")
                + (", 1 at {linear:±}" if law["linear"] else ""),
                "{surfaces} surfaces",
                **law,
                expected=1 / (1 + law["hurst"]),
            )
    for size in ends_with_size(laws):
        yield saying(
            "H = {hurst:g}, eps_f = 1/{lam_l_over_lam_s:g}: with the size of the cell, p* halfway"
            " to 1 goes",
            "as L^x with x = {power:±}",
            "as the number of highest hills would: -2",
            **size,
        )
    for hurst, part in by_hurst(rows).items():
        if near_line := [
            row["stiffness"] / row["persson"]
            for row in part
            if LINEAR / 2 < row["p_star"] < 2 * LINEAR
        ]:
            yield saying(
                f"H = {hurst:g}: stiffness over Persson's theory (large systems) near p* ="
                f" {LINEAR:g}",
                f"{min(near_line):.2f} to {max(near_line):.2f}",
            )


def over_theory(rows: Rows) -> Rows:
    """The rows with the stiffness over Persson's."""
    return [row | {"ratio": row["stiffness"] / row["persson"]} for row in rows]


def draw(rows: Rows, path: Path) -> None:
    """K over p_star, which is even where K is linear, and its local exponent, a panel for each H
    above and below."""
    hursts = list(by_hurst(rows)) or [HURST[0]]
    with figure(path, 2.8 * len(hursts), 4.8) as fig:
        axes = fig.subplots(2, len(hursts), sharex=True, sharey="row", squeeze=False)
        for (above, below), hurst in zip(axes.T, hursts, strict=True):
            systems = groups(where(rows, hurst=hurst), *SYSTEM[1:])
            for (key, part), shade in zip(systems.items(), COLOURS, strict=False):
                over = [
                    row
                    | {
                        name: row[name] / row["p_star"]
                        for name in ("stiffness", "stiffness_se", "persson")
                    }
                    for row in part
                ]
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
    Study(
        "stiffness",
        "Tangent stiffness at low pressures",
        "a power law with exponent 1/(1 + H) in finite systems",
        series_of(ROWS, HURST, LOADS, observables=("stiffness",)),
        means,
        draw,
        findings,
        QUESTION,
        {
            "H": "{hurst:g}",
            "L/lam_l": "{L_over_lam_l:g}",
            "eps_f": "1/{lam_l_over_lam_s:g}",
            "surfaces": "{surfaces}",
            "p*": "{p_star:.4g}",
            "K h_rms/(E* g_rms)": "{stiffness:±}",
            "d ln K/d ln p": "{exponent:±}",
            "K over Persson": "{ratio:.3f}",
        },
        over_theory,
    ),
)
