"""Figures 9 to 13: contact area and mean gap against the load, with Persson's theory."""

from collections.abc import Iterator
from functools import partial

from hpc_gfmd.theory import elastic, persson

from ..estimates import average
from ..pictures import areas, pressure_against_gap
from ..printed import NUMBERS
from ..rows import Rows, by_hurst, comparison, filled_with_each, groups
from ..study import Study
from .gap import span, with_theory

LOW = 0.1  # p* up to which the area is proportional to the load
NEAR_FULL = 0.5  # p* above which the contact is nearly full
HIGHEST = 0.25  # p* from which a load belongs to "the highest" that the paper excludes
AREAS = (  # (x, y, theory, settings) of pictures.areas
    ("p_star", "a_r", persson.contact_area, {"xscale": "log", "yscale": "log"}),
    ("p_star", "kappa", persson.kappa, {"xscale": "log"}),
)
OPEN = {"yscale": "log", "xlim": (0, 6), "ylim": (1e-4, 1)}
OPEN_AREA = (("p_inverse", "open_area", persson.noncontact_area, OPEN),)


def contact_area(runs: Rows, level: str) -> Rows:
    """Average a_r and kappa, as counted and edge-corrected, and add Persson's a_r."""
    rows = average(runs, "a_r", "a_r_edge", "kappa", "kappa_edge")
    return [row | {"persson": float(persson.contact_area(row["p_star"]))} for row in rows]


def open_area(runs: Rows, level: str) -> Rows:
    """Average 1 - a_r, as counted and edge-corrected, and add Persson's, and 1/p* as p_inverse."""
    with_open_area = [
        run | {"open_area": 1 - run["a_r"], "open_area_edge": 1 - run["a_r_edge"]} for run in runs
    ]
    rows = average(with_open_area, "open_area", "open_area_edge")
    for row in rows:
        theory = float(persson.noncontact_area(row["p_star"]))
        row |= {"p_inverse": 1 / row["p_star"], "persson": theory}
    return [row for row in rows if row["open_area"] > 0]


def slope(rows: Rows) -> Iterator[dict]:
    """Compare the slope at low pressures and the influence of H."""
    low = by_hurst([row for row in rows if row["p_star"] <= LOW])
    if not low:
        return
    light = [min(part, key=lambda row: abs(row["p_star"] - 0.01)) for part in low.values()]
    loads = [[row["a_r_edge"] for row in part] for part in groups(rows, "p_star").values()]
    spread = [max(part) / min(part) - 1 for part in loads]
    claim = NUMBERS["slope"]
    counted = filled_with_each("{kappa:±} (H = {hurst:g})", light)
    edge = filled_with_each("{kappa_edge:±} (H = {hurst:g})", light)
    yield comparison(
        f"slope {claim['low']:g} to {claim['high']:g}, Persson theory {claim['theory']:g}",
        f"as counted {counted}; edge-corrected {edge}; theory {persson.KAPPA_LOW_LOAD:.3f} (BGT"
        f" {elastic.KAPPA_BGT:.3f})",
        "ours are at finite eps_f, eps_t, eps_c; the limits are in table 5",
    )
    yield comparison(
        f"a_r between H near 0 and near 1 differs by at most {NUMBERS['area_spread_in_hurst']:.0%}",
        f"edge-corrected: {max(spread):.0%} at most over all loads, {min(spread):.1%} at least",
        f"the paper's own slopes differ by {claim['high'] / claim['low'] - 1:.0%}",
    )


def near_full_contact(rows: Rows) -> Iterator[dict]:
    """Compare simulation and theory near full contact."""
    parts = [
        f"{span([row['open_area_edge'] / row['persson'] for row in part])} at p* = {p_star:g}"
        for p_star, part in groups(rows, "p_star").items()
        if p_star > NEAR_FULL
    ]
    if parts:
        yield comparison(
            "close to full contact Persson theory is closer to the simulations than at low loads",
            f"1 - a_r edge-corrected over theory: {'; '.join(parts)}",
            "the ratio of the small open areas is a sharper test than that of the areas, near 1",
        )


def theory_within(rows: Rows) -> Iterator[dict]:
    """Compare p* against the gap at one H with theory, without the highest loads."""
    within = NUMBERS["theory_within"]["curves"]
    parts = []
    chosen = [row for row in rows if row["p_star"] < HIGHEST]
    for name, label in (("persson", "corrected"), ("persson_printed", "as printed")):
        if ratios := [row[f"over_{name}"] for row in chosen if row[f"over_{name}"]]:
            share = sum(abs(ratio - 1) <= within for ratio in ratios) / len(ratios)
            parts.append(
                f"{label}: {share:.0%} of the loads within {within:.0%}, simulation/theory"
                f" {span(ratios)}"
            )
    if parts:
        yield comparison(
            f"H = {{hurst:g}}: theory within {within:.0%} over almost the whole range, except for"
            " the highest p*",
            "; ".join(parts),
            f"loads below p* = {HIGHEST:g}; printed and corrected differ by the missing factor 2",
            **chosen[0],
        )


STUDIES = (
    Study("fig9", contact_area, partial(areas, specs=AREAS), slope),
    Study("fig10", open_area, partial(areas, specs=OPEN_AREA), near_full_contact),
    *(
        Study(name, with_theory, pressure_against_gap, theory_within)
        for name in ("fig11", "fig12", "fig13")
    ),
)
