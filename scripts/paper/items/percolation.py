"""The contact area at which the contact first percolates, by finite-size scaling."""

from collections.abc import Iterator
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize
from scipy.special import ndtr, ndtri

from hpc_gfmd.plotting.style import THEORY

from ..estimates import jackknife, power_law, weighted_mean
from ..pictures import draw_points, hurst_style, label_axes, panels
from ..rows import Rows, by_hurst, comparison, filled_with_each, groups, longest, where
from ..study import Study

SYSTEM = ("hurst", "L_over_lam_l", "lam_l_over_lam_s", "lam_s_over_a")
# Events as the load grows: (column of the area, column that changes, its value after the event).
EVENTS = {
    "sides": ("a_r_edge", "contact_percolates_{}", True),
    "corners": ("a_r_edge", "contact_percolates_{}_8", True),
    "counted_sides": ("a_r", "contact_percolates_{}", True),
    "counted_corners": ("a_r", "contact_percolates_{}_8", True),
    "sealed": ("a_r_edge", "gap_spans_{}", False),
}
PERCOLATION = [0, 1]  # indices of EVENTS: edge-corrected areas
COUNTED = [2, 3]  # areas as counted
SEALING = 4
LITERATURE = (0.415, 0.42)  # Wang, Müser 2021; Dapp, Müser 2016
SEVERAL = 6  # surfaces that are enough for a width
NU = 4 / 3  # exponent of the correlation length in two dimensions
# Shares of square cells at the threshold: those in which a cluster wraps along a given axis
# (Newman, Ziff 2001), and those without a cluster from edge to edge (Hovi, Aharony 1996).
WRAPPED = 0.521058
SEALED = 1 - 0.6365
SHIFTS = ("shift", "shift_se", "shift_sealed", "shift_sealed_se")


def between(sweep: Rows, event: str, axis: str) -> tuple[float, float]:
    """Return the areas at the last load before an event along an axis ("x", "y") and at the first
    one after it; 0 and 1 where there is none. The runs of the sweep are in the order of their
    loads."""
    area, column, value = EVENTS[event]
    has_happened = [run[column.format(axis)] == value for run in sweep]
    index = has_happened.index(True) if True in has_happened else len(sweep)
    areas = [0.0, *(run[area] for run in sweep), 1.0]
    return areas[index], areas[index + 1]


def fitted_quantile(bounds: ArrayLike, share: float = 0.5) -> tuple[float, float]:
    """Fit a normal distribution to the areas of an event, each between two bounds (..., 2), by
    maximum likelihood. Return the area at which the event has happened on a share of the surfaces,
    and the standard deviation."""
    low, high = np.reshape(bounds, (-1, 2)).T
    inside = (low > 0) & (high < 1)
    start_mean = np.mean((low + high)[inside]) / 2 if inside.any() else 0.4
    start = start_mean, np.log(0.03)

    def misfit(x):
        below, above = (ndtr((area - x[0]) / np.exp(x[1])) for area in (low, high))
        return -np.sum(np.log(np.maximum(above - below, 1e-12)))

    options = {"xatol": 1e-5, "fatol": 1e-4}
    mean, log_width = minimize(misfit, start, method="Nelder-Mead", options=options).x
    width = np.exp(log_width)
    return float(mean + width * ndtri(share)), float(width)


def thresholds(runs: Rows, level: str) -> Rows:
    """Return the critical areas for each H, system and grid.

    a_c: edge-corrected contact area at which a share WRAPPED of the surfaces percolates along a
    given axis, for points connected by sides (a_c_sides), by corners (a_c_corners) and for both
    together. a_c_counted: the same for the area as counted. width: standard deviation over
    surfaces. a_c_sealed: area at which in a share SEALED of the surfaces no gap reaches from edge
    to edge. SHIFTS: what to add to a_c and a_c_sealed for a -> 0.
    """
    bounds = {
        system: {
            seed: np.array([[between(sweep, event, axis) for axis in "xy"] for event in EVENTS])
            for seed, sweep in groups(part, "seed").items()
        }
        for system, part in groups(sorted(runs, key=itemgetter("p_star")), *SYSTEM).items()
    }
    rows: Rows = []
    fine: dict[tuple, dict] = {}
    for system, surfaces in bounds.items():
        areas = np.array(list(surfaces.values()))  # (surfaces, EVENTS, axes, 2)
        row: dict[str, Any] = dict(zip(SYSTEM, system)) | {"surfaces": len(areas)}
        row |= {"eps_t": 1 / system[1], "eps_c": 1 / system[3]}
        row["a_c"], row["a_c_se"] = _quantile_and_error(areas[:, PERCOLATION], WRAPPED)
        row["width"] = fitted_quantile(areas[:, PERCOLATION])[1]
        for name, events in (("sides", 0), ("corners", 1), ("counted", COUNTED)):
            row[f"a_c_{name}"] = fitted_quantile(areas[:, events], WRAPPED)[0]
        row["a_c_sealed"], row["a_c_sealed_se"] = _quantile_and_error(areas[:, SEALING], SEALED)
        if system[:3] not in fine:
            grids = {key[3]: part for key, part in bounds.items() if key[:3] == system[:3]}
            fine[system[:3]] = shifts_to_fine_grids(grids)
        rows.append(row | fine[system[:3]].get(system[3], dict.fromkeys(SHIFTS)))
    return rows


def _quantile_and_error(bounds, share):
    value, error = jackknife(
        lambda surfaces: fitted_quantile(bounds[surfaces], share)[0], len(bounds)
    )
    return float(value), float(error)


def shifts_to_fine_grids(grids: dict) -> dict[float, dict[str, float]]:
    """Extrapolate critical areas to a -> 0 with surfaces that are solved on several grids.

    The areas by sides and by corners, edge-corrected and as counted, are parabolas in a/lam_s with
    the same limit; the error contains half their largest difference. `grids` has the areas between
    which the EVENTS happen (EVENTS, axes, 2) by lam_s/a and seed. Return {lam_s/a: SHIFTS}, empty
    for less than three grids or SEVERAL surfaces.
    """
    shared = sorted(set.intersection(*map(set, grids.values())))
    if len(grids) < 3 or len(shared) < SEVERAL:
        return {}
    eps_c = 1 / np.array(list(grids))
    bounds = np.array([[part[seed] for seed in shared] for part in grids.values()])
    quantiles: list[tuple[Any, float]] = [(k, WRAPPED) for k in (0, 1, 2, 3, PERCOLATION)]
    quantiles.append((SEALING, SEALED))

    def shifts(surfaces):
        areas = np.array(
            [
                [fitted_quantile(grid[:, k], share)[0] for k, share in quantiles]
                for grid in bounds[:, surfaces]
            ]
        )
        limits = np.polyfit(eps_c, areas, 2)[-1]
        half_range = np.full(len(areas), np.ptp(limits[:4]) / 2)
        return np.array([np.mean(limits[:4]) - areas[:, 4], limits[5] - areas[:, 5], half_range])

    (wrap, sealed, half_range), (wrap_se, sealed_se, _) = jackknife(shifts, len(shared))
    columns = [wrap, np.hypot(wrap_se, half_range), sealed, sealed_se]
    values = np.stack(columns, axis=1).tolist()
    return {grid: dict(zip(SHIFTS, row)) for grid, row in zip(grids, values)}


def sizes(rows: Rows) -> Rows:
    """Return the rows at the lam_l/lam_s and lam_s/a with most sizes of the cell."""
    keyed = [row | {"grid": (row["lam_l_over_lam_s"], row["lam_s_over_a"])} for row in rows]
    return sorted(longest(keyed, "eps_t", "grid"), key=itemgetter("L_over_lam_l"))


def large(rows: Rows) -> Rows:
    """Return the critical areas of each H for large cells and a -> 0.

    a_c and a_c_sealed are the mean over cells of two lam_l and more, where the size hardly matters,
    plus the mean shift of all sizes; None without a shift. exponent: of the width as a power of
    L/lam_l, or None.
    """
    limits = []
    for hurst, family in by_hurst(rows).items():
        part = sizes(family)
        limit: dict[str, Any] = {"hurst": hurst}
        for name, shift in (("a_c", "shift"), ("a_c_sealed", "shift_sealed")):
            large_cells = [
                row for row in part if row["L_over_lam_l"] >= 2 and (row["a_c_se"] or 0) > 0
            ]
            shifted = [row for row in part if row[shift] is not None]
            limit |= {name: None, f"{name}_se": None}
            if large_cells and shifted:
                area, area_se = _weighted_mean_of(large_cells, name)
                mean_shift, shift_se = _weighted_mean_of(shifted, shift)
                sigma = float(np.hypot(area_se, shift_se))
                limit |= {name: area + mean_shift, f"{name}_se": sigma}
        with_width = [row for row in part if row["surfaces"] >= SEVERAL]
        limit["exponent"] = power_law(with_width, "L_over_lam_l", "width")[0]
        limits.append(limit)
    return limits


def _weighted_mean_of(rows, column):
    return weighted_mean([row[column] for row in rows], [row[f"{column}_se"] for row in rows])


def findings(rows: Rows) -> Iterator[dict]:
    """Compare our critical area, by two definitions, with the literature, and the decrease of the
    width with the size."""
    limits = large(rows)
    with_area = [row for row in limits if row["a_c"]]
    for claim, name in (
        ("critical contact area of large cells, a -> 0", "a_c"),
        (f"the same from fluids, which get through {1 - SEALED:.1%} of the cells", "a_c_sealed"),
    ):
        if with_area:
            mean = {key: np.mean([row[key] for row in with_area]) for key in (name, f"{name}_se")}
            ours = filled_with_each(f"{{{name}:±}} (H = {{hurst:g}})", with_area)
            ours += f"; mean {{{name}:±}}"
            yield comparison(claim, ours, "literature: {:g} to {:g}".format(*LITERATURE), **mean)
    if limits and limits[0]["exponent"]:
        yield comparison(
            f"width falls as L^-{1 / NU:g} in two dimensions",
            filled_with_each("L^{exponent:.2f} (H = {hurst:g})", limits),
        )


def draw(rows: Rows, path: Path) -> None:
    """Draw a_c and the width against L/lam_l, and the effect of the grid on the same surfaces."""
    with panels(path, 3) as (left, centre, right):
        for hurst, family in by_hurst(rows).items():
            part = sizes(family)
            style = hurst_style(hurst)
            draw_points(left, part, "L_over_lam_l", "a_c", linestyle="-", **style)
            with_width = [row for row in part if row["surfaces"] >= SEVERAL]
            draw_points(centre, with_width, "L_over_lam_l", "width", linestyle="-", **style)
            grids = [row for row in where(family, L_over_lam_l=2) if row["shift"] is not None]
            grids.sort(key=itemgetter("eps_c"))
            for name, mark in (("sides", "o"), ("corners", "s"), ("counted", "^")):
                errors = [{"eps_c": 0, "error": 0}] if grids else []
                errors += [
                    row | {"error": row[f"a_c_{name}"] - row["a_c"] - row["shift"]} for row in grids
                ]
                line = {"linestyle": "-", "color": style["color"]}
                draw_points(right, errors, "eps_c", "error", mark, **line)
                right.plot([], [], marker=mark, color="0.35", linestyle="", label=name)
        ends = np.array([1.0, max((row["L_over_lam_l"] for row in rows), default=2)])
        left.axhspan(*LITERATURE, color="0.85", zorder=0, label="literature")
        centre.plot(ends, 0.08 * ends ** (-1 / NU), label=r"$\propto L^{-3/4}$", **THEORY)
        for ax, y in ((left, "contact area at percolation"), (centre, "width")):
            label_axes(ax, "L_over_lam_l", y, yscale="log" if ax is centre else "linear")
            ax.set_xscale("log", base=2)
        label_axes(right, "eps_c", r"area minus limit for $a \to 0$")


STUDIES = (Study("percolation", thresholds, draw, findings),)
