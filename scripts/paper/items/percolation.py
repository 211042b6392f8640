"""The contact area at which contact first percolates, by finite-size scaling."""

from collections.abc import Callable
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

from hpc_gfmd.plotting.style import COLOURS, THEORY, figure

from ..catalogue import Study
from ..draw import points
from ..levels import series_of
from ..paper import Sayings, saying
from ..rows import Rows, by_hurst, groups, longest, where
from ..text import filled
from ..thresholds import between, jackknife, middle

HURST = (0.3, 0.5, 0.8)
LOADS = (0.12, 0.15, 0.18, 0.2, 0.22, 0.24, 0.26, 0.28, 0.31, 0.35, 0.4)
ROWS = {  # as in levels.py
    "quick": ((1, 4, 4, 3, (0.5,)), (2, 4, 4, 3, (0.5,))),
    "desk": (
        (1, 16, 4, 120),
        (1, 16, 8, 120),
        (1, 16, 16, 120),
        (1, 16, 32, 120),
        (2, 16, 4, 100),
        (2, 16, 8, 200),
        (2, 16, 16, 100),
        (2, 16, 32, 30),
        (4, 16, 4, 12),
        (4, 16, 8, 60),
        (8, 16, 8, 20),
        (2, 64, 4, 30),
        (4, 64, 4, 8),
    ),
    "paper": (
        (1, 64, 16, 200),
        (2, 64, 16, 200),
        (4, 64, 16, 100),
        (8, 64, 16, 50),
        (16, 64, 8, 16),
        (4, 64, 8, 100),
        (4, 64, 4, 100),
    ),
}
SYSTEM = ("hurst", "L_over_lam_l", "lam_l_over_lam_s", "lam_s_over_a")
AREAS, ENDS = (
    ("a_r_edge", "a_r"),
    ("", "_8"),
)  # edge-corrected or counted, of points that share sides or corners
LITERATURE = (0.42, 0.005)  # 0.42 (Dapp, Müser 2016), 0.415 (Wang, Müser 2021)
SHIFTS = ("shift", "shift_se", "shift_sealed", "shift_sealed_se")
SEVERAL = 6  # surfaces from which on their width means something
NU = 4 / 3  # of the correlation length in two dimensions
# share of square cells in which a cluster wraps along a given axis, at the threshold of large ones
# (Newman, Ziff 2001)
HALF = 0.521058
SEALED = (
    1 - 0.6365
    # share of those in which none goes from edge to edge, cells being periodic across (Hovi, Aharony
    # 1996)
)
series = series_of(ROWS, HURST, LOADS, observables=("percolation", "percolation_8", "spanning"))


def thresholds(runs: Rows, level: str) -> Rows:
    """A row for each H, size and grid.

    a_c, a_c_se: edge-corrected contact area at which HALF of the surfaces percolate along a given
    axis, of points that share sides (a_c_sides), corners (a_c_corners) and of both together;
    a_c_counted: the same in counted points; width: standard deviation of the area at which single
    surfaces do; a_c_sealed, a_c_sealed_se: area at which no gap reaches from edge to edge any more
    in SEALED of the surfaces; half_sealed, half_sealed_se: in half of them; SHIFTS: what must be
    added to a_c, and to both of these, for a -> 0 (to_fine_grids); more_waves, more_waves_se: by
    how much a_c differs from that at the smallest lam_l/lam_s, seeds of both.
    """
    bounds = {
        system: {seed: _bounds(sweep) for seed, sweep in groups(part, "seed").items()}
        for system, part in groups(sorted(runs, key=itemgetter("p_star")), *SYSTEM).items()
    }
    rows: Rows = []
    fine: dict[tuple, dict] = {}
    for system, surfaces in bounds.items():
        hurst, L, F, C = system
        wraps = np.array([one for one, _ in surfaces.values()])  # (surfaces, AREAS, ENDS, axes, 2)
        row: dict[str, Any] = dict(zip(SYSTEM, system, strict=True)) | {"surfaces": len(surfaces)}
        row |= {"eps_t": 1 / L, "eps_c": 1 / C, "grid": f"{F:g} {C:g}"}
        row["a_c"], row["a_c_se"] = _known(wraps[:, 0], HALF)
        row["width"] = middle(wraps[:, 0])[1]
        for name, part in (
            ("sides", wraps[:, 0, 0]),
            ("corners", wraps[:, 0, 1]),
            ("counted", wraps[:, 1]),
        ):
            row[f"a_c_{name}"] = middle(part, HALF)[0]
        sealed = np.array([one for _, one in surfaces.values()])
        row["a_c_sealed"], row["a_c_sealed_se"] = _known(sealed, SEALED)
        row["half_sealed"], row["half_sealed_se"] = _known(sealed)
        if system[:3] not in fine:
            fine[system[:3]] = to_fine_grids(
                {key[3]: part for key, part in bounds.items() if key[:3] == system[:3]}
            )
        row |= fine[system[:3]].get(C, dict.fromkeys(SHIFTS))
        few_waves = bounds.get((hurst, L, min(key[2] for key in bounds), C), {})
        row["more_waves"], row["more_waves_se"] = (
            _apart(surfaces, few_waves) if few_waves is not surfaces else (None, None)
        )
        rows.append(row)
    return rows


def to_fine_grids(grids: dict) -> dict[float, dict[str, float]]:
    """{lam_s/a: SHIFTS} from surfaces that were solved on three grids or more, {} if there are less
    than SEVERAL.

    grids: {lam_s/a: {seed: _bounds}}.

    The areas of AREAS and ENDS, each a parabola in a/lam_s, must meet there; the error contains
    half of what they differ by.
    """
    shared = sorted(set.intersection(*map(set, grids.values())))
    if len(grids) < 3 or len(shared) < SEVERAL:
        return {}
    eps_c = 1 / np.array(list(grids))
    wraps, sealed = (
        np.array([[part[seed][k] for seed in shared] for part in grids.values()]) for k in (0, 1)
    )

    def shifts(some: np.ndarray) -> np.ndarray:
        part, closed = wraps[:, some], [middle(grid, SEALED)[0] for grid in sealed[:, some]]
        areas = np.array(
            [
                [middle(grid[:, area, end], HALF)[0] for grid in part]
                for area, end in np.ndindex(2, 2)
            ]
        )
        limits = np.polyfit(eps_c, areas.T, 2)[-1]
        return np.array(
            [
                [np.mean(limits) - middle(grid[:, 0], HALF)[0] for grid in part],
                np.polyfit(eps_c, closed, 2)[-1] - closed,
                np.full(len(part), np.ptp(limits) / 2),
            ]
        )

    (wrap, closed, apart), (wrap_se, closed_se, _) = jackknife(shifts, len(shared))
    values = np.stack([wrap, np.hypot(wrap_se, apart), closed, closed_se], axis=1).tolist()
    return {
        grid: dict(zip(SHIFTS, one, strict=True)) for grid, one in zip(grids, values, strict=True)
    }


def _bounds(sweep: Rows) -> tuple[list, list]:
    """Between which areas a surface begins to percolate, shape (AREAS, ENDS, axes, 2), and the gap
    ceases to span, (axes, 2)."""
    wraps = [
        [
            [between(sweep, itemgetter(f"contact_percolates_{axis}{end}"), area) for axis in "xy"]
            for end in ENDS
        ]
        for area in AREAS
    ]
    return wraps, [between(sweep, _sealed_along(axis), AREAS[0]) for axis in "xy"]


def _sealed_along(axis: str) -> Callable[[dict], bool]:
    return lambda run: not run[f"gap_spans_{axis}"]


def _apart(surfaces: dict, others: dict) -> tuple[float | None, float | None]:
    """(a_c of surfaces minus that of others, standard error) over the seeds of both, (None, None)
    if they are less than SEVERAL."""
    shared = sorted(set(surfaces) & set(others))
    if len(shared) < SEVERAL:
        return None, None
    bounds = np.array([[part[seed][0][0] for seed in shared] for part in (surfaces, others)])
    value, error = jackknife(
        lambda some: middle(bounds[0, some], HALF)[0] - middle(bounds[1, some], HALF)[0],
        len(shared),
    )
    return float(value), float(error)


def _known(bounds: np.ndarray, share: float = 0.5) -> tuple[float, float]:
    value, error = jackknife(lambda some: middle(bounds[some], share)[0], len(bounds))
    return float(value), float(error)


def large(rows: Rows) -> dict[float, dict]:
    """{H: limit of large cells}, from the sizes at the lam_l/lam_s and lam_s/a with most of them.

    at_grid, counted, their _se: mean a_c over cells of two lam_l and more, where it hardly depends
    on the size; a_c, a_c_se: for a -> 0, with the mean SHIFTS of all that have one, None without;
    sealed, sealed_se: the same from a_c_sealed; exponent: of the width in L/lam_l; sizes: all rows;
    surfaces: of all of them.
    """
    found = {}
    for hurst, part in by_hurst(rows).items():
        part = longest(part, "eps_t", "grid")
        many = [row for row in part if row["surfaces"] >= SEVERAL]
        big = [row for row in part if row["L_over_lam_l"] >= 2 and row["a_c_se"] > 0]
        if not big:
            continue
        one: dict[str, Any] = {
            "lam_s_over_a": big[0]["lam_s_over_a"],
            "surfaces": sum(row["surfaces"] for row in part),
            "counted": _mean(big, "a_c_counted", "a_c_se")[0],
            "exponent": None,
            "a_c": None,
            "a_c_se": None,
            "sizes": part,
        }
        one["at_grid"], one["at_grid_se"] = _mean(big, "a_c", "a_c_se")
        one["counted_se"] = one["at_grid_se"]
        if shifted := [row for row in part if row["shift"] is not None]:
            for area, at_grid, shift in (
                ("a_c", "a_c", "shift"),
                ("sealed", "a_c_sealed", "shift_sealed"),
            ):
                mean, error = _mean(big, at_grid, f"{at_grid}_se")
                one[shift], one[f"{shift}_se"] = _mean(shifted, shift, f"{shift}_se")
                one |= {
                    area: mean + one[shift],
                    f"{area}_se": float(np.hypot(error, one[f"{shift}_se"])),
                }
        if len(many) > 1:
            size, width, count = (
                np.array([row[name] for row in many], dtype=float)
                for name in ("L_over_lam_l", "width", "surfaces")
            )
            one["exponent"] = float(np.polyfit(np.log(size), np.log(width), 1, w=np.sqrt(count))[0])
        found[hurst] = one
    return found


def _mean(rows: Rows, name: str, error: str) -> tuple[float, float]:
    """(mean of independent rows, its standard error), which is enlarged where they differ by more
    than theirs."""
    value, weight = (
        np.array([row[name] for row in rows]),
        np.array([row[error] for row in rows]) ** -2.0,
    )
    mean = float(np.average(value, weights=weight))
    chi2 = float(np.sum(weight * (value - mean) ** 2)) / max(len(rows) - 1, 1)
    return mean, float(np.sqrt(max(1.0, chi2) / np.sum(weight)))


def findings(rows: Rows) -> Sayings:
    """The critical area by our definition and by that of the literature, what grid, connectivity
    and more waves do to it, the width."""
    limit = large(rows)
    if not limit:
        return

    def each(template: str, part: dict[float, dict] = limit) -> str:
        return ", ".join(
            filled(template, x | {"hurst": hurst}) + f" (H = {hurst:g})"
            for hurst, x in part.items()
        )

    def near_literature(name: str, part: dict[float, dict] = limit) -> str:
        found = [
            f"{hurst:g}"
            for hurst, x in part.items()
            if abs(x[name] - LITERATURE[0]) <= LITERATURE[1]
        ]
        return f"in {LITERATURE[0]:g} ± {LITERATURE[1]:g}: " + (
            f"H = {', '.join(found)}" if found else "none"
        )

    grid = f"lam_s/a = {next(iter(limit.values()))['lam_s_over_a']:g}"
    apart = {
        c: np.mean([row["a_c_sides"] - row["a_c_corners"] for row in part])
        for c, part in groups(rows, "lam_s_over_a").items()
    }
    if fine := {hurst: x for hurst, x in limit.items() if x["a_c"]}:
        yield saying(
            "critical contact area of large cells, a -> 0",
            each("{a_c:±}", fine),
            near_literature("a_c", fine),
        )
        yield saying(
            f"the same from fluids, which get from edge to edge in {1 - SEALED:.1%} of the cells",
            each("{sealed:±}", fine),
            near_literature("sealed", fine),
        )
        names = ("a_c", "a_c_se", "sealed", "sealed_se")
        every: dict[str, Any] = {
            name: float(np.mean([x[name] for x in fine.values()])) for name in names
        }
        yield saying(
            "mean over H (the same seeds: errors do not average out)",
            "{a_c:±}, from fluids {sealed:±}",
            **every,
        )
        yield saying(
            "half of the cells are sealed, a -> 0",
            each("{half}", half_sealed(fine)),
            f"at the threshold of large cells {1 - SEALED:.1%} of the small ones still leak: half"
            " are sealed above it",
        )
        yield saying(
            f"from {grid}, edge-corrected, to a -> 0",
            each("{shift:±}", fine),
            "the same surfaces on all grids; sides and corners, counted and edge-corrected must"
            " meet",
        )
    yield saying(
        f"at {grid}, edge-corrected",
        each("{at_grid:±}, {surfaces} surfaces"),
        near_literature("at_grid"),
    )
    yield saying(
        f"at {grid}, the same contacts as counted", each("{counted:±}"), near_literature("counted")
    )
    yield saying(
        "points that share corners instead of sides percolate earlier by",
        ", ".join(f"{mean:.4f} (lam_s/a = {c:g})" for c, mean in apart.items()),
        "edge-corrected; a_c is the mean",
    )
    if more := [row for row in rows if row["more_waves"] is not None]:
        yield saying(
            "more octaves of waves, the same seeds",
            ", ".join(
                filled(
                    "{more_waves:+.4f} ± {more_waves_se:.4f} (H = {hurst:g}, eps_f ="
                    " 1/{lam_l_over_lam_s:g}, L/lam_l = {L_over_lam_l:g}, lam_s/a ="
                    " {lam_s_over_a:g})",
                    row,
                )
                for row in more
            ),
        )
    yield saying(
        f"width falls as L^-{1 / NU:g} in two dimensions",
        ", ".join(
            (f"L^{x['exponent']:.2f}" if x["exponent"] else "-") + f" (H = {hurst:g})"
            for hurst, x in limit.items()
        ),
    )


def half_sealed(limit: dict[float, dict]) -> dict[float, dict]:
    """{H: {"half": text}}, the area at which half of the cells of each size are sealed, for a ->
    0."""
    found = {}
    for hurst, x in limit.items():
        sizes = [
            row
            | {
                "half": row["half_sealed"] + x["shift_sealed"],
                "half_se": float(np.hypot(row["half_sealed_se"], x["shift_sealed_se"])),
            }
            for row in x["sizes"]
        ]
        found[hurst] = {
            "half": ", ".join(
                filled("{half:±} at L/lam_l = {L_over_lam_l:g}", row) for row in sizes
            )
        }
    return found


def draw(rows: Rows, path: Path) -> None:
    """a_c, the area that seals half of the cells (dashed) and the width against L/lam_l; what the
    grid does to the same surfaces."""
    with figure(path, 10.6, 3.2) as fig:
        left, middle_, right = fig.subplots(1, 3)
        for (hurst, family), shade in zip(by_hurst(rows).items(), COLOURS, strict=False):
            part = sorted(longest(family, "eps_t", "grid"), key=itemgetter("L_over_lam_l"))
            size = [row["L_over_lam_l"] for row in part]
            points(left, part, "L_over_lam_l", "a_c", shade, label=f"$H = {hurst:g}$", line="-")
            left.plot(
                size,
                [row["half_sealed"] for row in part],
                color=shade,
                linewidth=0.8,
                linestyle="--",
                label="half sealed" if hurst == rows[0]["hurst"] else None,
            )
            many = [row for row in part if row["surfaces"] >= SEVERAL]
            middle_.plot(
                [row["L_over_lam_l"] for row in many],
                [row["width"] for row in many],
                color=shade,
                marker="o",
            )
            grids = [row for row in where(family, L_over_lam_l=2) if row["shift"] is not None]
            grids.sort(key=itemgetter("eps_c"))
            for name, mark in (("a_c_sides", "o"), ("a_c_corners", "s"), ("a_c_counted", "^")):
                right.plot(
                    [0, *(row["eps_c"] for row in grids)],
                    [0, *(row[name] - row["a_c"] - row["shift"] for row in grids)],
                    color=shade,
                    marker=mark,
                    markersize=4,
                    label=name.removeprefix("a_c_") if hurst == rows[0]["hurst"] else None,
                )
        left.axhspan(0.415, 0.42, color="0.85", zorder=0, label="literature")
        if rows:
            ends = np.array([1.0, max(row["L_over_lam_l"] for row in rows)])
            middle_.plot(
                ends, 0.08 * ends ** (-1 / NU), label=r"$\propto\mathcal{L}^{-3/4}$", **THEORY
            )
        left.set(
            xscale="log", xlabel=r"$\mathcal{L}/\lambda_l$", ylabel="contact area at percolation"
        )
        middle_.set(xscale="log", yscale="log", xlabel=r"$\mathcal{L}/\lambda_l$", ylabel="width")
        right.set(xlabel=r"$a/\lambda_s$", ylabel=r"area minus limit for $a \to 0$")
        sizes = sorted({row["L_over_lam_l"] for row in rows})
        for ax in (left, middle_):
            ax.set_xticks(sizes, [f"{size:g}" for size in sizes])
            ax.set_xticks([], minor=True)
        for ax in (left, middle_, right):
            if ax.get_legend_handles_labels()[0]:
                ax.legend()


QUESTION = """At which contact area does contact first go around the periodic cell along a given axis (in 52.1% of the cells, as at the
threshold of large ones), so that no fluid passes any more, and does that depend on H, on the grid and on how it is defined?
Surfaces are loaded in small steps; the area at percolation lies between two loads, and a normal distribution is fitted to
these bounds (largest likelihood). Points that share sides percolate later than points that share corners, and counted
points exceed the area by a share of its perimeter: both vanish for a -> 0, where the four areas must meet (a parabola in
a/lam_s each, the same surfaces on all grids). Literature: 0.42 (Dapp, Müser 2016), 0.415 (Wang, Müser 2021). Leakage asks
instead when no fluid gets from one edge of a cell to the other, the cell being periodic across. At the threshold of large
cells it still does in 63.6% of the small ones: where 36.4% are sealed is the same threshold in another way; half of them are
sealed at a larger area only (dashed in the picture), by about a third of the width."""

STUDIES = (
    Study(
        "percolation",
        "The contact area at which contact percolates",
        "critical area near 0.42",
        series,
        thresholds,
        draw,
        findings,
        QUESTION,
        {
            "H": "{hurst:g}",
            "L/lam_l": "{L_over_lam_l:g}",
            "eps_f": "1/{lam_l_over_lam_s:g}",
            "eps_c": "1/{lam_s_over_a:g}",
            "surfaces": "{surfaces}",
            "a_c": "{a_c:±}",
            "sides": "{a_c_sides:.3f}",
            "corners": "{a_c_corners:.3f}",
            "counted": "{a_c_counted:.3f}",
            "width": "{width:.3f}",
            "a_c from fluids": "{a_c_sealed:±}",
            "half sealed": "{half_sealed:±}",
        },
    ),
)
