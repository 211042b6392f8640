"""kappa and mean gap against p_star for many H and three eps_f, in the limit of fine grids and
large cells: hpc_gfmd.reference."""

from pathlib import Path
from typing import Any

import numpy as np

from hpc_gfmd.plotting.style import THEORY, figure, shade
from hpc_gfmd.theory import persson
from hpc_gfmd.util.errors import SceneError

from ..catalogue import Study
from ..continuum import POWERS, continuum
from ..draw import points
from ..levels import P_HIGH, P_LOW, series_of
from ..paper import Sayings, saying
from ..rows import Rows, at_load, groups, where
from ..text import filled

HURST = (0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 1.0)
LOADS = (1e-4, 3e-4, 0.001, P_LOW, 0.03, 0.06, 0.12, 0.2, P_HIGH, 0.6, 1.0, 1.5, 2.0)
FEW, HEAVY, LIGHT = (
    (0.3, 0.5, 0.8),
    LOADS[2:],
    LOADS[:4],
)  # what is solved of the finest grids, and of more surfaces
ROWS: dict[str, Any] = {  # as in levels.py; at the end the loads, if not all
    "quick": tuple(
        (*row, (0.3, 0.8))
        for row in ((2, 4, 2, 3), (2, 4, 4, 3), (2, 4, 8, 2), (2, 4, 16, 2), (4, 4, 2, 2))
    ),
    "desk": (
        (8, 16, 2, 4),
        (8, 16, 4, 4),
        (8, 16, 8, 4),
        (8, 16, 16, 1, (0.1, 0.5, 1.0)),
        (32, 16, 2, 2),
        *((8, 16, C, 8, HURST, LIGHT) for C in (2, 4, 8)),
        (2, 64, 2, 8),
        (2, 64, 4, 8),
        (2, 64, 8, 1),
        (2, 64, 16, 4, FEW, HEAVY),
        (8, 64, 2, 2),
        (1, 256, 2, 4),
        (1, 256, 4, 2),
        (2, 256, 8, 4, FEW, HEAVY),
        (4, 256, 2, 2),
        *(
            (*row, HURST, LIGHT)
            for row in (
                (8, 16, 16, 4),
                (32, 16, 2, 5),
                (32, 16, 4, 2),
                (2, 64, 8, 8),
                (2, 64, 16, 4),
                (8, 64, 4, 4),
                (16, 64, 2, 2),
                (1, 256, 2, 6),
                (1, 256, 4, 8),
                (1, 256, 8, 4),
                (4, 256, 4, 1),
            )
        ),
        (4, 256, 4, 2, (0.7, 0.8, 0.9, 1.0), LIGHT),
    ),
    "paper": (
        (8, 64, 2, 16),
        (8, 64, 4, 16),
        (8, 64, 8, 8),
        (8, 64, 16, 4),
        (32, 64, 2, 4),
        (8, 256, 2, 16),
        (8, 256, 4, 8),
        (8, 256, 8, 4),
        (8, 256, 16, 1),
        (32, 256, 2, 2),
        (4, 1024, 2, 16),
        (4, 1024, 4, 4),
        (4, 1024, 8, 1),
        (16, 1024, 2, 2),
    ),
}
series = series_of(ROWS, HURST, LOADS)
POOLED = (
    "kappa",
    "kappa_edge",
)  # at light loads single contacts meet the grid alike; the gap is known well enough at each load
RESOLVED = 4  # lam_s/a from which on a grid resolves them: on coarser ones many are of one point
SHOWN = (1e-4, 0.001, P_LOW, 0.06, P_HIGH, 1.0)
FROM = (0.001, P_LOW, 0.03, 0.12)  # loads from which on errors are quoted


def limits(runs: Rows, level: str) -> Rows:
    """A row for each H, eps_f and p_star: kappa (mean of what its two routes give, its error half
    their difference and more), gap_over_h_rms, NAME_se, Persson's; None where the gap is closed in
    some realisation."""
    found: dict[str, dict] = {name: {} for name in POWERS}
    for name, at in found.items():
        together = LIGHT if name in POOLED else ()
        at |= _limit(
            [
                run
                for p_star in together
                for run in at_load(runs, p_star)
                if run["lam_s_over_a"] >= RESOLVED
            ],
            name,
        )
        for p_star in LOADS:
            if p_star not in together:
                at |= _limit(at_load(runs, p_star), name)
    rows = []
    for p_star in LOADS:
        for hurst, eps_f in sorted({(run["hurst"], run["eps_f"]) for run in at_load(runs, p_star)}):
            one = {name: at.get((hurst, eps_f, p_star)) for name, at in found.items()}
            row = {
                "hurst": hurst,
                "eps_f": eps_f,
                "p_star": p_star,
                "kappa": None,
                "kappa_se": None,
            }
            if one["kappa"] and one["kappa_edge"]:
                (a, a_se), (b, b_se) = one["kappa"], one["kappa_edge"]
                row |= {
                    "kappa": (a + b) / 2,
                    "kappa_se": float(np.hypot(max(a_se, b_se), (a - b) / 2)),
                    "kappa_counted": a,
                    "kappa_counted_se": a_se,
                    "kappa_edge": b,
                    "kappa_edge_se": b_se,
                }
            row |= dict(
                zip(
                    ("gap_over_h_rms", "gap_over_h_rms_se"),
                    one["gap_over_h_rms"] or (None, None),
                    strict=True,
                )
            )
            rows.append(
                row
                | {
                    "persson_kappa": float(persson.kappa(p_star)),
                    "persson_gap_over_h_rms": float(persson.mean_gap(p_star, hurst, eps_f)),
                }
            )
    return rows


def _limit(runs: Rows, name: str) -> dict[tuple, tuple[float, float]]:
    """{(H, eps_f, p_star): (limit, standard error)}; {} where there is none."""
    try:
        found = continuum(runs, name)
    except SceneError:  # not enough runs yet, or closed gaps
        return {}
    return {key: (value, value * found.error[key]) for key, value in found.value.items()}


def findings(rows: Rows) -> Sayings:
    """How precise it is, how far theory is off, how the two routes agree."""
    known = [row for row in rows if row["kappa"]]
    gaps = [row for row in rows if row["gap_over_h_rms"]]
    if not known or not gaps:
        return

    def worst(part: Rows, name: str, low: Any = 0.0, high: Any = np.inf) -> str:
        return f"{max((row[f'{name}_se'] / row[name] for row in part if low <= row['p_star'] <= high), default=0):.1%}"

    apart = [
        (row["kappa_counted"] - row["kappa_edge"])
        / np.hypot(row["kappa_counted_se"], row["kappa_edge_se"])
        for row in known
    ]
    ratios = {
        p_star: [row["kappa"] / row["persson_kappa"] for row in part]
        for p_star, part in groups(known, "p_star").items()
    }
    over = [
        row["gap_over_h_rms"] / row["persson_gap_over_h_rms"]
        for row in gaps
        if row["p_star"] <= P_HIGH
    ]
    yield saying(
        "standard error of kappa",
        f"at most {worst(known, 'kappa')}; "
        + ", ".join(f"{worst(known, 'kappa', p)} from p* = {p:.3g}" for p in FROM),
    )
    yield saying(
        "standard error of the mean gap",
        f"at most {worst(gaps, 'gap_over_h_rms', 0, P_HIGH)} up to p* = {P_HIGH:.3g}, "
        f"{worst(gaps, 'gap_over_h_rms', 1, 1)} at p* = 1",
    )
    yield saying(
        "as counted and edge-corrected, both extrapolated to fine grids",
        f"apart by {np.sqrt(np.mean(np.square(apart))):.1f} of their standard errors (rms),"
        f" {max(np.abs(apart)):.1f} at most",
    )
    yield saying(
        "kappa over Persson's theory",
        "; ".join(
            f"{min(ratios[p]):.2f} to {max(ratios[p]):.2f} at p* = {p:.3g}"
            for p in SHOWN
            if p in ratios
        ),
    )
    yield saying(
        "gap over Persson's theory (gamma = 0.42, corrected)",
        f"{min(over):.2f} to {max(over):.2f} up to p* = {P_HIGH:.3g}",
    )


def at_some_loads(rows: Rows) -> Rows:
    """A row for each observable, eps_f and H, with a column for each of SHOWN."""
    return [
        {"what": label, "eps_f": eps_f, "hurst": hurst}
        | {
            str(row["p_star"]): filled(f"{{{name}:±}}", row)
            for row in part
            if row["p_star"] in SHOWN
        }
        for name, label in (("kappa", "kappa"), ("gap_over_h_rms", "gap/h_rms"))
        for (eps_f, hurst), part in reversed(groups(rows, "eps_f", "hurst").items())
    ]


def draw(rows: Rows, path: Path) -> None:
    """kappa and gap/h_rms against p_star, a column for each eps_f; lines: Persson."""
    eps = sorted({row["eps_f"] for row in rows}, reverse=True) or [1.0]
    p_star = np.geomspace(LOADS[0], 1.6, 60)
    with figure(path, 3.0 * len(eps), 5.2) as fig:
        axes = fig.subplots(2, len(eps), sharex=True, sharey="row", squeeze=False)
        for column, eps_f in zip(axes.T, eps, strict=True):
            for ax, name, label in zip(
                column,
                ("kappa", "gap_over_h_rms"),
                (r"$\kappa$", r"$\Delta\bar u/\bar h$"),
                strict=True,
            ):
                for hurst in sorted({row["hurst"] for row in rows}):
                    part = where(rows, eps_f=eps_f, hurst=hurst)
                    points(
                        ax,
                        part,
                        "p_star",
                        name,
                        shade(0.9 * hurst),
                        label=f"$H = {hurst:g}$",
                        line="-",
                        size=3,
                    )
                    if name != "kappa":
                        ax.plot(
                            p_star,
                            persson.mean_gap(p_star, hurst, eps_f),
                            color=shade(0.9 * hurst),
                            linestyle="--",
                            linewidth=0.7,
                        )
                ax.set(xscale="log", ylabel=label if eps_f == eps[0] else None)
            column[0].plot(
                p_star, persson.kappa(p_star), label="Persson", **(THEORY | {"linestyle": "--"})
            )
            column[0].set_title(f"$\\epsilon_f = 1/{1 / eps_f:g}$")
            column[1].set(yscale="log", ylim=(1e-5, 6), xlabel=r"$p^* = p/(E^*\bar g)$")
        fig.legend(*axes[0][0].get_legend_handles_labels(), loc="outside right upper")


QUESTION = """How do kappa = a_r/p\\* and the mean gap depend on the load, in a large cell and on a fine grid, for H from 0.1 to 1
and three eps_f = lam_s/lam_l? Each pressure is fitted as a whole (the area at light loads, up to 0.007, together and
from lam_s/a = 4 on: there single contacts meet the grid alike, and are of one point or two on coarser ones): ln value = its
limit at this H and eps_f + a term in eps_t + terms in eps_c common to all H and eps_f; surfaces are common along each
series. `hpc_gfmd.reference` interpolates these numbers; the gap ends at p\\* = 1.5, above which it closes (contact
everywhere) in some cells. Dashed: Persson's theory with the missing factor 2."""

STUDIES = (
    Study(
        "curves",
        "Contact area and mean gap against the load, for many H",
        "Persson's theory, and the paper at a few H",
        series,
        limits,
        draw,
        findings,
        QUESTION,
        {"": "{what}", "eps_f": "{eps_f:1/}", "H": "{hurst:g}"}
        | {f"p* = {p:.3g}": f"{{{p}}}" for p in SHOWN},
        at_some_loads,
    ),
)
