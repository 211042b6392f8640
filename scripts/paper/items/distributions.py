"""Distributions of pressure, gap and patch size over many surfaces, with Persson's theory."""

from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np
from scipy.stats import sem

from hpc_gfmd.plotting.style import THEORY
from hpc_gfmd.theory import persson

from ..cases import CATALOGUE
from ..estimates import power_law
from ..pictures import draw_points, hurst_style, label_axes, panels
from ..rows import Rows, at_load, by_hurst, comparison, groups, quoted, where
from ..study import Study

LOADS = CATALOGUE["series"]["distributions"]["loads"]["all"]
# {kind: (unit, its power, edges of bins in it, label, range of the densities in the picture)}
KINDS = {
    "pressure": ("g_rms", 1, np.arange(0, 4.0001, 0.05), r"$p/(E^* g_\mathrm{rms})$", (1e-4, 5)),
    "gap": ("h_rms", 1, np.geomspace(1e-3, 8, 40), r"$g/h_\mathrm{rms}$", (1e-5, 20)),
    "patches": ("lam_s", 2, np.geomspace(1 / 16, 65536, 41), r"$A/\lambda_s^2$", (1e-7, 10)),
}
POWER_LAW = (1.0, 100.0)  # range of patch sizes, in lam_s^2, in which a power law is fitted


def means(runs: Rows, level: str) -> Rows:
    """Average the distributions over surfaces; return a row for each H, p_star, kind and bin: low,
    high, density (its integral is 1), density_se, surfaces.

    Kinds: pressure of points in contact in units of E* g_rms, gap of open points in units of h_rms,
    number of patches by area in units of lam_s^2.
    """
    rows = []
    for (hurst, part), p_star, (kind, (unit, power, edges, *_)) in product(
        by_hurst(runs).items(), LOADS, KINDS.items()
    ):
        densities = [
            _binned(run[f"{kind}_distribution"], run[unit] ** power, edges)
            for run in at_load(part, p_star)
            if run[f"{kind}_distribution"]
        ]
        if len(densities) > 1:
            head = {"hurst": hurst, "p_star": p_star, "kind": kind}
            names = ("low", "high", "density", "density_se")
            mean = np.mean(densities, axis=0)
            bins = np.stack([edges[:-1], edges[1:], mean, sem(densities)], axis=1)
            rows += [
                head | dict(zip(names, values)) | {"surfaces": len(densities)}
                for values in bins.tolist()
                if values[2] > 0
            ]
    return rows


def _binned(histogram, unit, edges):
    """Return the density of a stored histogram in other bins, in units of `unit`.

    The density is taken as constant within each stored bin.
    """
    stored_edges = np.array(histogram["edges"]) / unit
    density = np.array(histogram["density"]) * unit
    cumulative = np.append(0.0, np.cumsum(density * np.diff(stored_edges)))
    return np.diff(np.interp(edges, stored_edges, cumulative)) / np.diff(edges)


def middles(rows: Rows) -> Rows:
    """Return the rows with the middles of their bins as column "at"."""

    def middle(low, high, kind, **_):
        return (low + high) / 2 if kind == "pressure" else (low * high) ** 0.5

    return [row | {"at": middle(**row)} for row in rows]


def patch_exponent(rows: Rows) -> tuple[float | None, float | None]:
    """Fit n(A) ~ A^-tau to the bins in POWER_LAW; return tau and its standard error."""
    part = [
        row
        for row in middles(rows)
        if POWER_LAW[0] <= row["low"] < row["high"] <= POWER_LAW[1]
        and row["density"] > 3 * row["density_se"]
    ]
    if len(part) < 4:
        return None, None
    slope, sigma = power_law(part, "at", "density", cov=True)
    return -slope, sigma


def theory(p_star: float, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return Persson's distribution of the pressure of points in contact, averaged over the bins
    with edges low and high in units of E* g_rms."""
    inside = np.mean(persson.pressure_distribution(np.linspace(low, high, 17), p_star), axis=0)
    return inside / float(persson.contact_area(p_star))


def findings(rows: Rows) -> Iterator[dict]:
    """Compare the pressures with theory and report the exponents of the patch sizes."""
    for (hurst, p_star), part in groups(rows, "hurst", "p_star").items():
        pressure = where(part, kind="pressure")
        patches = where(part, kind="patches")
        if pressure and patches:
            names = ("low", "high", "density")
            low, high, density = np.array([[row[name] for name in names] for row in pressure]).T
            excess = np.abs(density - theory(p_star, low, high))
            difference = np.sum(excess * (high - low)) / 2
            yield comparison(
                f"H = {hurst:g}, p* = {p_star:.3g}",
                f"{difference:.1%} of the contact is at other pressures than in Persson's theory;"
                f" patch sizes as A^-tau with tau = {quoted(*patch_exponent(patches))}",
                f"{pressure[0]['surfaces']} surfaces, patches of {POWER_LAW[0]:g} to"
                f" {POWER_LAW[1]:g} lam_s²",
            )


def draw(rows: Rows, path: Path) -> None:
    """Draw a row of panels for each kind and a column for each load, with Persson's P(p)."""
    significant = middles([row for row in rows if row["density"] > 2 * row["density_se"]])
    with panels(path, len(LOADS), len(KINDS), sharey="row", sharex="row") as axes:
        for axes_of_kind, (kind, (*_, label, span)) in zip(axes, KINDS.items()):
            rows_of_kind = where(significant, kind=kind)
            scale = "linear" if kind == "pressure" else "log"
            for ax, p_star in zip(axes_of_kind, LOADS):
                for hurst, part in by_hurst(at_load(rows_of_kind, p_star)).items():
                    style = hurst_style(hurst) | {"linestyle": "-"}
                    draw_points(ax, part, "at", "density", "", **style)
                label_axes(ax, label, "", yscale="log", xscale=scale, ylim=span)
            axes_of_kind[0].set_ylabel("density")
        edges = KINDS["pressure"][2]
        low = edges[:-1]
        high = edges[1:]
        for ax, p_star in zip(axes[0], LOADS):
            ax.plot((low + high) / 2, theory(p_star, low, high), label="Persson", **THEORY)
            ax.set(title=f"$p^* = {p_star:.3g}$")


STUDIES = (Study("distributions", means, draw, findings),)
