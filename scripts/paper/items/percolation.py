"""The contact area at which contact first percolates, by finite-size scaling."""

from collections.abc import Iterator
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize
from scipy.special import ndtr, ndtri

from hpc_gfmd.plotting.style import THEORY

from ..estimates import jackknife, power_law, weighted
from ..pictures import named, of_h, panels, points
from ..rows import Rows, by_hurst, each, groups, longest, saying, where
from ..study import Study

SYSTEM = ("hurst", "L_over_lam_l", "lam_l_over_lam_s", "lam_s_over_a")
# what happens as the load grows: (the area at which, a column of a run, its value from then on)
EVENTS = {
    "sides": ("a_r_edge", "contact_percolates_{}", True),
    "corners": ("a_r_edge", "contact_percolates_{}_8", True),
    "counted_sides": ("a_r", "contact_percolates_{}", True),
    "counted_corners": ("a_r", "contact_percolates_{}_8", True),
    "sealed": ("a_r_edge", "gap_spans_{}", False),
}
PERCOLATION, COUNTED, LAST = [0, 1], [2, 3], 4
LITERATURE = (0.415, 0.42)  # Wang, Müser 2021; Dapp, Müser 2016
SEVERAL = 6  # surfaces from which on their width means something
NU = 4 / 3  # of the correlation length in two dimensions
HALF = 0.521058  # of square cells wrap along a given axis at the threshold (Newman, Ziff 2001)
SEALED = 1 - 0.6365  # of those have no cluster from edge to edge (Hovi, Aharony 1996)
SHIFTS = ("shift", "shift_se", "shift_sealed", "shift_sealed_se")


def between(sweep: Rows, event: str, axis: str) -> tuple[float, float]:
    """Find (area at the last load before an event, area at the first load where it has happened).

    0 and 1 where there is none. sweep: the runs of a surface in the order of their loads.
    """
    area, column, value = EVENTS[event]
    happens = [run[column.format(axis)] == value for run in sweep]
    first = happens.index(True) if True in happens else len(sweep)
    areas = [0.0, *(run[area] for run in sweep), 1.0]
    return areas[first], areas[first + 1]


def middle(bounds: ArrayLike, share: float = 0.5) -> tuple[float, float]:
    """Find (area at which it has happened to `share` of the surfaces, standard deviation) of the
    normal distribution that is the likeliest for these bounds, shape (..., 2)."""
    low, high = np.reshape(bounds, (-1, 2)).T
    inside = (low > 0) & (high < 1)
    start = np.mean((low + high)[inside]) / 2 if inside.any() else 0.4, np.log(0.03)

    def misfit(x):
        below, above = (ndtr((area - x[0]) / np.exp(x[1])) for area in (low, high))
        return -np.sum(np.log(np.maximum(above - below, 1e-12)))

    how = {"xatol": 1e-5, "fatol": 1e-4}
    mean, log = minimize(misfit, start, method="Nelder-Mead", options=how).x
    return float(mean + np.exp(log) * ndtri(share)), float(np.exp(log))


def thresholds(runs: Rows, level: str) -> Rows:
    """Find a row for each H, size and grid.

    a_c, a_c_se: edge-corrected contact area at which HALF of the surfaces percolate along a given
    axis, of points that share sides (a_c_sides), corners (a_c_corners) and of both together;
    a_c_counted: the same in counted points; width: standard deviation of the area at which single
    surfaces do; a_c_sealed, a_c_sealed_se: area at which no gap reaches from edge to edge any more
    in SEALED of the surfaces; SHIFTS: what must be added to a_c and a_c_sealed for a -> 0.
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
        found = np.array(list(surfaces.values()))  # (surfaces, EVENTS, axes, 2)
        row: dict[str, Any] = dict(zip(SYSTEM, system)) | {"surfaces": len(found)}
        row |= {"eps_t": 1 / system[1], "eps_c": 1 / system[3]}
        row["a_c"], row["a_c_se"] = _known(found[:, PERCOLATION], HALF)
        row["width"] = middle(found[:, PERCOLATION])[1]
        for name, events in (("sides", 0), ("corners", 1), ("counted", COUNTED)):
            row[f"a_c_{name}"] = middle(found[:, events], HALF)[0]
        row["a_c_sealed"], row["a_c_sealed_se"] = _known(found[:, LAST], SEALED)
        if system[:3] not in fine:
            grids = {key[3]: part for key, part in bounds.items() if key[:3] == system[:3]}
            fine[system[:3]] = to_fine_grids(grids)
        rows.append(row | fine[system[:3]].get(system[3], dict.fromkeys(SHIFTS)))
    return rows


def _known(bounds, share):
    value, error = jackknife(lambda some: middle(bounds[some], share)[0], len(bounds))
    return float(value), float(error)


def to_fine_grids(grids: dict) -> dict[float, dict[str, float]]:
    """Find {lam_s/a: SHIFTS} from surfaces solved on three grids or more; {} of less than SEVERAL.

    The areas of sides and corners, counted or not, each a parabola in a/lam_s, must meet at a -> 0;
    the error contains half of what they differ by.
    """
    shared = sorted(set.intersection(*map(set, grids.values())))
    if len(grids) < 3 or len(shared) < SEVERAL:
        return {}
    eps_c = 1 / np.array(list(grids))
    bounds = np.array([[part[seed] for seed in shared] for part in grids.values()])
    wanted: list[tuple[Any, float]] = [(k, HALF) for k in (0, 1, 2, 3, PERCOLATION)]
    wanted.append((LAST, SEALED))

    def shifts(some):
        at = np.array(
            [[middle(grid[:, k], share)[0] for k, share in wanted] for grid in bounds[:, some]]
        )
        ends = np.polyfit(eps_c, at, 2)[-1]
        apart = np.full(len(at), np.ptp(ends[:4]) / 2)
        return np.array([np.mean(ends[:4]) - at[:, 4], ends[5] - at[:, 5], apart])

    (wrap, closed, apart), (wrap_se, closed_se, _) = jackknife(shifts, len(shared))
    values = np.stack([wrap, np.hypot(wrap_se, apart), closed, closed_se], axis=1).tolist()
    return {grid: dict(zip(SHIFTS, one)) for grid, one in zip(grids, values)}


def sizes(rows: Rows) -> Rows:
    """Choose the rows at the lam_l/lam_s and lam_s/a with most sizes of the cell."""
    keyed = [row | {"grid": (row["lam_l_over_lam_s"], row["lam_s_over_a"])} for row in rows]
    return sorted(longest(keyed, "eps_t", "grid"), key=itemgetter("L_over_lam_l"))


def large(rows: Rows) -> Rows:
    """Find the limit of large cells and a -> 0 for each H: a_c, sealed, NAME_se.

    The mean over cells of two lam_l and more, where it hardly depends on the size, with the mean
    shift of all sizes; None where none is known. exponent: of the width in L/lam_l, or None.
    """
    found = []
    for hurst, family in by_hurst(rows).items():
        part = sizes(family)
        one: dict[str, Any] = {"hurst": hurst}
        for name, shift in (("a_c", "shift"), ("a_c_sealed", "shift_sealed")):
            big = [row for row in part if row["L_over_lam_l"] >= 2 and (row["a_c_se"] or 0) > 0]
            shifted = [row for row in part if row[shift] is not None]
            one |= {name: None, f"{name}_se": None}
            if big and shifted:
                (a, a_se), (b, b_se) = (
                    weighted([row[of] for row in some], [row[f"{of}_se"] for row in some])
                    for of, some in ((name, big), (shift, shifted))
                )
                one |= {name: a + b, f"{name}_se": float(np.hypot(a_se, b_se))}
        many = [row for row in part if row["surfaces"] >= SEVERAL]
        found.append(one | {"exponent": power_law(many, "L_over_lam_l", "width")[0]})
    return found


def findings(rows: Rows) -> Iterator[dict]:
    """Compare the critical area by our definition and by that of the literature, and how the width
    falls with the size."""
    limit = large(rows)
    known = [row for row in limit if row["a_c"]]
    for what, name in (
        ("critical contact area of large cells, a -> 0", "a_c"),
        (f"the same from fluids, which get through {1 - SEALED:.1%} of the cells", "a_c_sealed"),
    ):
        if known:
            mean = {k: np.mean([row[k] for row in known]) for k in (name, f"{name}_se")}
            ours = each(f"{{{name}:±}} (H = {{hurst:g}})", known) + f"; mean {{{name}:±}}"
            yield saying(what, ours, "literature: {:g} to {:g}".format(*LITERATURE), **mean)
    if limit and limit[0]["exponent"]:
        yield saying(
            f"width falls as L^-{1 / NU:g} in two dimensions",
            each("L^{exponent:.2f} (H = {hurst:g})", limit),
        )


def draw(rows: Rows, path: Path) -> None:
    """Draw a_c and the width against L/lam_l, and what the grid does to the same surfaces."""
    with panels(path, 3) as (left, centre, right):
        for hurst, family in by_hurst(rows).items():
            part, how = sizes(family), of_h(hurst)
            points(left, part, "L_over_lam_l", "a_c", linestyle="-", **how)
            many = [row for row in part if row["surfaces"] >= SEVERAL]
            points(centre, many, "L_over_lam_l", "width", linestyle="-", **how)
            grids = [row for row in where(family, L_over_lam_l=2) if row["shift"] is not None]
            grids.sort(key=itemgetter("eps_c"))
            for name, mark in (("sides", "o"), ("corners", "s"), ("counted", "^")):
                off = [{"eps_c": 0, "off": 0}] if grids else []
                off += [r | {"off": r[f"a_c_{name}"] - r["a_c"] - r["shift"]} for r in grids]
                points(right, off, "eps_c", "off", mark, linestyle="-", color=how["color"])
                right.plot([], [], marker=mark, color="0.35", linestyle="", label=name)
        ends = np.array([1.0, max((row["L_over_lam_l"] for row in rows), default=2)])
        left.axhspan(*LITERATURE, color="0.85", zorder=0, label="literature")
        centre.plot(ends, 0.08 * ends ** (-1 / NU), label=r"$\propto L^{-3/4}$", **THEORY)
        for ax, y in ((left, "contact area at percolation"), (centre, "width")):
            named(ax, "L_over_lam_l", y, yscale="log" if ax is centre else "linear")
            ax.set_xscale("log", base=2)
        named(right, "eps_c", r"area minus limit for $a \to 0$")


STUDIES = (Study("percolation", thresholds, draw, findings),)
