"""Distributions of pressure, gap and patch size, over many surfaces, beside Persson's theory."""

from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np
from scipy.stats import sem

from hpc_gfmd.plotting.style import THEORY
from hpc_gfmd.theory import persson

from ..cases import CATALOGUE
from ..estimates import power_law
from ..pictures import named, of_h, panels, points
from ..rows import Rows, at_load, by_hurst, groups, quoted, saying, where
from ..study import Study

LOADS = CATALOGUE["series"]["distributions"]["loads"]["all"]
# of what: (its unit and the power of it, edges of bins in it, its label, range of the densities)
KINDS = {
    "pressure": ("g_rms", 1, np.arange(0, 4.0001, 0.05), r"$p/(E^* g_\mathrm{rms})$", (1e-4, 5)),
    "gap": ("h_rms", 1, np.geomspace(1e-3, 8, 40), r"$g/h_\mathrm{rms}$", (1e-5, 20)),
    "patches": ("lam_s", 2, np.geomspace(1 / 16, 65536, 41), r"$A/\lambda_s^2$", (1e-7, 10)),
}
POWER_LAW = (1.0, 100.0)  # patches, in lam_s^2, whose sizes may follow a power law


def means(runs: Rows, level: str) -> Rows:
    """Average over surfaces: a row for each H, p_star, kind and bin.

    low, high, density (integrates to 1), density_se, surfaces. Of pressure: of points in contact,
    in units of E* g_rms; of gap: of points that do not touch, in units of h_rms; of patches: number
    of patches, in units of lam_s^2. Surfaces count as they have points or patches.
    """
    rows = []
    for (hurst, part), p_star, (kind, (unit, power, edges, *_)) in product(
        by_hurst(runs).items(), LOADS, KINDS.items()
    ):
        found = [
            _binned(run[f"{kind}_distribution"], run[unit] ** power, edges)
            for run in at_load(part, p_star)
            if run[f"{kind}_distribution"]
        ]
        if len(found) > 1:
            head = {"hurst": hurst, "p_star": p_star, "kind": kind}
            names = ("low", "high", "density", "density_se")
            bins = np.stack([edges[:-1], edges[1:], np.mean(found, axis=0), sem(found)], axis=1)
            rows += [
                head | dict(zip(names, one)) | {"surfaces": len(found)}
                for one in bins.tolist()
                if one[2] > 0
            ]
    return rows


def _binned(found, unit, edges):
    """Compute the density in other bins, in units of `unit`; it is even within each of its own."""
    own, density = np.array(found["edges"]) / unit, np.array(found["density"]) * unit
    below = np.append(0.0, np.cumsum(density * np.diff(own)))
    return np.diff(np.interp(edges, own, below)) / np.diff(edges)


def middles(rows: Rows) -> Rows:
    """Add the middles of bins as column "at"."""

    def middle(low, high, kind, **_):
        return (low + high) / 2 if kind == "pressure" else (low * high) ** 0.5

    return [row | {"at": middle(**row)} for row in rows]


def patch_exponent(rows: Rows) -> tuple[float | None, float | None]:
    """Fit tau of n(A) ~ A^-tau to the bins of POWER_LAW; (tau, standard error)."""
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
    """Compute Persson's P(p) of points in contact, means over bins (units of E* g_rms)."""
    inside = np.mean(persson.pressure_distribution(np.linspace(low, high, 17), p_star), axis=0)
    return inside / float(persson.contact_area(p_star))


def findings(rows: Rows) -> Iterator[dict]:
    """Compare pressure with theory, and find the exponents of the patch sizes."""
    for (hurst, p_star), part in groups(rows, "hurst", "p_star").items():
        pressure, patches = where(part, kind="pressure"), where(part, kind="patches")
        if pressure and patches:
            names = ("low", "high", "density")
            low, high, density = np.array([[row[name] for name in names] for row in pressure]).T
            apart = np.sum(np.abs(density - theory(p_star, low, high)) * (high - low)) / 2
            yield saying(
                f"H = {hurst:g}, p* = {p_star:.3g}",
                f"{apart:.1%} of the contact is at other pressures than in Persson's theory; patch"
                f" sizes as A^-tau with tau = {quoted(*patch_exponent(patches))}",
                f"{pressure[0]['surfaces']} surfaces, patches of {POWER_LAW[0]:g} to"
                f" {POWER_LAW[1]:g} lam_s²",
            )


def draw(rows: Rows, path: Path) -> None:
    """Draw a line for each kind, a column for each load; line: Persson's P(p)."""
    known = middles([row for row in rows if row["density"] > 2 * row["density_se"]])
    with panels(path, len(LOADS), len(KINDS), sharey="row", sharex="row") as axes:
        for line, (kind, (*_, label, span)) in zip(axes, KINDS.items()):
            scale = "linear" if kind == "pressure" else "log"
            for ax, p_star in zip(line, LOADS):
                for hurst, part in by_hurst(at_load(where(known, kind=kind), p_star)).items():
                    points(ax, part, "at", "density", "", linestyle="-", **of_h(hurst))
                named(ax, label, "", yscale="log", xscale=scale, ylim=span)
            line[0].set_ylabel("density")
        low, high = KINDS["pressure"][2][:-1], KINDS["pressure"][2][1:]
        for ax, p_star in zip(axes[0], LOADS):
            ax.plot((low + high) / 2, theory(p_star, low, high), label="Persson", **THEORY)
            ax.set(title=f"$p^* = {p_star:.3g}$")


STUDIES = (Study("distributions", means, draw, findings),)
