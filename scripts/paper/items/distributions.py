"""Distributions of pressure, gap and patch size, over many surfaces, beside Persson's theory."""

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import sem

from hpc_gfmd.plotting.style import COLOURS, THEORY, figure
from hpc_gfmd.theory import persson

from ..catalogue import Study
from ..draw import points
from ..levels import P_HIGH, P_LOW, series_of
from ..paper import Sayings, saying
from ..rows import Rows, at_load, by_hurst, where
from ..text import quoted

HURST = (0.3, 0.5, 0.8)
LOADS = (P_LOW, 0.06, P_HIGH)
ROWS = {
    "quick": ((2, 8, 4, 3, (0.5,)),),
    "desk": ((2, 64, 4, 200),),
    "paper": ((4, 256, 8, 200),),
}  # as in levels.py
KINDS = {  # what it is a distribution of: (its unit in terms of a run, edges of bins in that unit)
    "pressure": (lambda run: run["g_rms"], np.arange(0, 4.0001, 0.05)),
    "gap": (lambda run: run["h_rms"], np.geomspace(1e-3, 8, 40)),
    "patches": (lambda run: run["lam_s"] ** 2, np.geomspace(1 / 16, 65536, 41)),
}
QUANTILES = (0.1, 0.5, 0.9)
SHOWN = {"pressure": (1e-4, 5), "gap": (1e-5, 20), "patches": (1e-7, 10)}  # range of the densities
UNITS = {"pressure": r"$p/(E^*\bar g)$", "gap": r"$g/\bar h$", "patches": r"$A/\lambda_s^2$"}
POWER_LAW = (1.0, 100.0)  # patches, in lam_s^2, whose sizes may follow a power law


def means(runs: Rows, level: str) -> Rows:
    """A row for each H, p_star, kind and bin: low, high, density (integrates to 1), density_se,
    surfaces.

    Of pressure: of points in contact, in units of E* g_rms; of gap: of points that do not touch, in
    units of h_rms; of patches: number of patches, in units of lam_s^2. Surfaces count as they have
    points or patches.
    """
    rows = []
    for (hurst, part), p_star, (kind, (unit, edges)) in product(
        by_hurst(runs).items(), LOADS, KINDS.items()
    ):
        found = [
            _binned(run, kind, unit(run), edges)
            for run in at_load(part, p_star)
            if run[f"{kind}_distribution"]
        ]
        if len(found) > 1:
            bins = zip(
                *(x.tolist() for x in (edges[:-1], edges[1:], np.mean(found, axis=0), sem(found))),
                strict=True,
            )
            rows += [
                {
                    "hurst": hurst,
                    "p_star": p_star,
                    "kind": kind,
                    "low": low,
                    "high": high,
                    "density": density,
                    "density_se": se,
                    "surfaces": len(found),
                }
                for low, high, density, se in bins
                if density > 0
            ]
    return rows


def _binned(run: dict, kind: str, unit: float, edges: np.ndarray) -> np.ndarray:
    """The density of a run in other bins, in units of `unit`; it is even within each of its own."""
    own, density = (
        np.array(run[f"{kind}_distribution"]["edges"]) / unit,
        np.array(run[f"{kind}_distribution"]["density"]) * unit,
    )
    below = np.append(0.0, np.cumsum(density * np.diff(own)))
    return np.diff(np.interp(edges, own, below)) / np.diff(edges)


def of(rows: Rows, hurst: float, p_star: float, kind: str) -> Rows:
    """The bins of one distribution."""
    return where(at_load(rows, p_star), hurst=hurst, kind=kind)


def patch_exponent(rows: Rows) -> tuple[float | None, float | None]:
    """tau of n(A) ~ A^-tau for the bins of POWER_LAW, and its standard error; None of too few."""
    part = [
        row
        for row in rows
        if POWER_LAW[0] <= row["low"] < row["high"] <= POWER_LAW[1]
        and row["density"] > 3 * row["density_se"]
    ]
    if len(part) < 4:
        return None, None
    at = np.log([np.sqrt(row["low"] * row["high"]) for row in part])
    error = np.array([row["density_se"] / row["density"] for row in part])
    line, covariance = np.polyfit(
        at, np.log([row["density"] for row in part]), 1, w=1 / error, cov=True
    )
    return float(-line[0]), float(np.sqrt(covariance[0, 0]))


def theory(p_star: float, low: Any, high: Any) -> np.ndarray:
    """Persson's P(p) of points in contact, means over bins from low to high (units of E* g_rms)."""
    inside = np.linspace(low, high, 17)
    return np.mean(persson.pressure_distribution(inside, p_star), axis=0) / float(
        persson.contact_area(p_star)
    )


def _columns(rows: Rows, *names: str) -> list[np.ndarray]:
    return [np.array([row[name] for row in rows]) for name in names]


def findings(rows: Rows) -> Sayings:
    """Pressure beside theory, exponents of the patch sizes."""
    for hurst, p_star in product(by_hurst(rows), LOADS):
        pressure, patches = of(rows, hurst, p_star, "pressure"), of(rows, hurst, p_star, "patches")
        if pressure and patches:
            low, high, density = _columns(pressure, "low", "high", "density")
            apart = np.sum(np.abs(density - theory(p_star, low, high)) * (high - low)) / 2
            yield saying(
                f"H = {hurst:g}, p* = {p_star:.3g}",
                f"{apart:.1%} of the contact is at other pressures than in Persson's theory; patch"
                f" sizes as A^-tau with tau = {quoted(*patch_exponent(patches))}",
                f"{pressure[0]['surfaces']} surfaces, patches of {POWER_LAW[0]:g} to"
                f" {POWER_LAW[1]:g} lam_s²",
            )


def quantiles(rows: Rows) -> Rows:
    """Of every distribution, in columns named by them."""
    lines = []
    for kind, hurst, p_star in product(KINDS, by_hurst(rows), LOADS):
        if part := of(rows, hurst, p_star, kind):
            low, high, density = _columns(part, "low", "high", "density")
            below = np.append(0.0, np.cumsum(density * (high - low)))
            at = np.interp(np.multiply(QUANTILES, below[-1]), below, np.append(low[0], high))
            lines.append(part[0] | dict(zip(map(str, QUANTILES), at.tolist(), strict=True)))
    return lines


def draw(rows: Rows, path: Path) -> None:
    """A row for each kind, a column for each load; colours: H; line: Persson's P(p)."""
    with figure(path, 8.4, 7.2) as fig:
        axes = fig.subplots(len(KINDS), len(LOADS), sharey="row", sharex="row")
        for line, kind in zip(axes, KINDS, strict=True):
            middle = (
                (lambda low, high: (low + high) / 2)
                if kind == "pressure"
                else (lambda low, high: np.sqrt(low * high))
            )
            for ax, p_star in zip(line, LOADS, strict=True):
                for hurst, shade in zip(by_hurst(rows), COLOURS, strict=False):
                    part = [
                        row
                        for row in of(rows, hurst, p_star, kind)
                        if row["density"] > 2 * row["density_se"]
                    ]
                    points(
                        ax,
                        [row | {"at": middle(row["low"], row["high"])} for row in part],
                        "at",
                        "density",
                        shade,
                        "",
                        label=f"$H = {hurst:g}$",
                        line="-",
                    )
                if kind == "pressure":
                    edges = KINDS[kind][1]
                    ax.plot(
                        (edges[1:] + edges[:-1]) / 2,
                        theory(p_star, edges[:-1], edges[1:]),
                        label="Persson",
                        **THEORY,
                    )
                    ax.set(title=f"$p^* = {p_star:.3g}$")
                ax.set(
                    yscale="log",
                    xscale="linear" if kind == "pressure" else "log",
                    xlabel=UNITS[kind],
                    ylim=SHOWN[kind],
                )
            line[0].set_ylabel("density")
        axes[0][0].legend()


QUESTION = """How are pressure, gap and the sizes of contact patches distributed, and how far is Persson's theory off? Means over
surfaces; pressure: of points in contact, in units of E* g_rms; gap: of points out of contact, in units of h_rms;
patches: by number, in units of lam_s² (points that share sides)."""

STUDIES = (
    Study(
        "distributions",
        "Distributions of pressure, gap and patch size",
        "Persson's P(p); patch sizes follow a power law",
        series_of(ROWS, HURST, LOADS, distributions=tuple(KINDS)),
        means,
        draw,
        findings,
        QUESTION,
        {"of": "{kind}", "H": "{hurst:g}", "p*": "{p_star:.3g}", "surfaces": "{surfaces}"}
        | {f"{q:.0%} below": f"{{{q}:.3g}}" for q in QUANTILES},
        quantiles,
    ),
)
