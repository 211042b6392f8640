"""Figures 9 to 13: contact area and mean gap against the load, with Persson's theory."""

from functools import partial

from hpc_gfmd.theory import elastic, persson

from .. import paper
from ..averages import average
from ..catalogue import Study
from ..draw import areas, pressure_against_gap
from ..levels import gap_pressure_series, pressure_series
from ..paper import Sayings, saying
from ..rows import Rows, by_hurst, groups
from ..text import filled
from .gap import with_theory

LOW = 0.1  # p* up to which the area is called linear
NEAR_FULL = 0.5  # p* from which the contact is nearly full
HIGHEST = 0.25  # p* from which on it is "the highest" that the paper excepts
AREAS = (
    ("p_star", "a_r", persson.contact_area, {"xscale": "log", "yscale": "log"}),
    ("p_star", "kappa", persson.kappa, {"xscale": "log"}),
)
OPEN_AREA = (
    (
        "p_inverse",
        "open_area",
        persson.noncontact_area,
        {"yscale": "log", "xlim": (0, 6), "ylim": (1e-4, 1)},
    ),
)


def contact_area(runs: Rows, level: str) -> Rows:
    """Means over realisations of a_r and kappa, as counted and edge-corrected, with Persson's
    a_r."""
    rows = average(runs, ("a_r", "a_r_edge", "kappa", "kappa_edge"))
    return [row | {"persson": float(persson.contact_area(row["p_star"]))} for row in rows]


def open_area(runs: Rows, level: str) -> Rows:
    """Means over realisations of 1 - a_r, as counted and edge-corrected, with Persson's; 1/p* is
    p_inverse."""
    rows = average(
        [
            run | {"open_area": 1 - run["a_r"], "open_area_edge": 1 - run["a_r_edge"]}
            for run in runs
        ],
        ("open_area", "open_area_edge"),
    )
    return [
        row
        | {
            "p_inverse": 1 / row["p_star"],
            "persson": float(persson.noncontact_area(row["p_star"])),
        }
        for row in rows
        if row["open_area"] > 0
    ]


def slope(rows: Rows) -> Sayings:
    """The slope at low pressure, and how little H matters."""
    low = by_hurst([row for row in rows if row["p_star"] <= LOW])
    if not low:
        return
    at = [min(part, key=lambda row: abs(row["p_star"] - 0.01)) for part in low.values()]
    counted, edge = (
        ", ".join(filled(f"{{{name}:±}} (H = {{hurst:g}})", row) for row in at)
        for name in ("kappa", "kappa_edge")
    )
    areas = [[row["a_r_edge"] for row in part] for part in groups(rows, "p_star").values()]
    spread = [max(part) / min(part) - 1 for part in areas]
    printed = paper.numbers()["slope"]
    yield saying(
        f"slope {printed['low']:g} to {printed['high']:g}, Persson theory {printed['theory']:g}",
        f"as counted {counted}; edge-corrected {edge}; theory {persson.KAPPA_LOW_LOAD:.3f} (BGT"
        f" {elastic.KAPPA_BGT:.3f})",
        "ours are at finite eps_f, eps_t, eps_c; the limits are in table 5",
    )
    yield saying(
        "a_r between H near 0 and near 1 differs by at most"
        f" {paper.numbers()['area_spread_in_hurst']:.0%}",
        f"edge-corrected: {max(spread):.0%} at most over all loads, {min(spread):.1%} at least",
        f"the paper's own slopes, {printed['high']:g} and {printed['low']:g}, differ by"
        f" {printed['high'] / printed['low'] - 1:.0%}",
    )


def near_full_contact(rows: Rows) -> Sayings:
    """The ratio of simulation to theory near full contact."""
    parts = []
    for p_star, part in groups(
        [row for row in rows if row["p_star"] > NEAR_FULL], "p_star"
    ).items():
        ratios = [row["open_area_edge"] / row["persson"] for row in part]
        parts.append(f"{min(ratios):.2f} to {max(ratios):.2f} at p* = {p_star:g}")
    if parts:
        yield saying(
            "close to full contact Persson theory is closer to the simulations than at low loads",
            f"1 - a_r edge-corrected over theory: {'; '.join(parts)}",
            "the ratio of the small open areas is a sharper test than that of the areas, both"
            " near 1",
        )


def theory_within(rows: Rows) -> Sayings:
    """How well theory and simulation agree on p* against gap at one H, without the highest
    loads."""
    within = paper.numbers()["theory_within"]["curves"]
    chosen = [
        row
        for row in rows
        if row["p_star"] < HIGHEST and row["over_persson"] and row["over_persson_printed"]
    ]
    if not chosen:
        return
    parts = []
    for name, label in (("persson", "corrected"), ("persson_printed", "as printed")):
        ratios = [row[f"over_{name}"] for row in chosen]
        share = sum(abs(ratio - 1) <= within for ratio in ratios) / len(ratios)
        parts.append(
            f"{label}: {share:.0%} of the loads within {within:.0%}, simulation/theory"
            f" {min(ratios):.2f} to {max(ratios):.2f}"
        )
    yield saying(
        f"H = {chosen[0]['hurst']:g}: theory within {within:.0%} over almost the whole range,"
        " except for the highest p*",
        "; ".join(parts),
        f"loads below p* = {HIGHEST:g}; printed and corrected differ by the missing factor 2",
    )


def _gap(name: str, hurst: float) -> Study:
    return Study(
        name,
        f"p* against gap at several eps_f, H = {hurst}",
        "theory within 20 % but at the highest p*; a logarithmic region at low p*",
        partial(gap_pressure_series, hurst=(hurst,)),
        with_theory,
        pressure_against_gap,
        theory_within,
    )


STUDIES = (
    Study(
        "fig9",
        "a_r against p* at low pressures",
        "linear with slopes 1.93 to 2.16, Persson theory 1.6; H matters little",
        pressure_series,
        contact_area,
        partial(areas, panels=AREAS, width=8.4),
        slope,
    ),
    Study(
        "fig10",
        "1 - a_r against 1/p*",
        "close to full contact Persson theory is near the simulations",
        pressure_series,
        open_area,
        partial(areas, panels=OPEN_AREA, width=5.6),
        near_full_contact,
    ),
    _gap("fig11", 0.3),
    _gap("fig12", 0.5),
    _gap("fig13", 0.8),
)
