"""Figure 10: 1 - a_r against 1/p*."""

from ...theory import persson
from .. import draw as draw_with
from ..averages import average
from ..levels import pressure_series
from ..paper import saying

NEAR_FULL = 0.5  # p* from which the contact is nearly full

NAME = "fig10"
TITLE = "1 - a_r against 1/p*"
PAPER = "close to full contact Persson theory is near the simulations"


def cases(level):
    """The contacts that it is made of."""
    return pressure_series(level)


def tabulate(runs, level):
    """Means over realisations of 1 - a_r, as counted and edge-corrected, with Persson's theory; 1/p* is p_inverse."""
    opened = [run | {"open_area": 1 - run["a_r"], "open_area_edge": 1 - run["a_r_edge"]} for run in runs]
    return [
        row | {"p_inverse": 1 / row["p_star"], "persson": float(persson.noncontact_area(row["p_star"]))}
        for row in average(opened, ("open_area", "open_area_edge"))
        if row["open_area"] > 0
    ]


def draw(rows, path):
    """1 - a_r against 1/p*."""
    draw_with.areas(path, rows, high=True)


def compare(rows):
    """The ratio of simulation to theory near full contact."""
    chosen = [row for row in rows if row["p_star"] > NEAR_FULL]
    if not chosen:
        return []
    parts = []
    for p_star in sorted({row["p_star"] for row in chosen}):
        ratios = [row["open_area_edge"] / row["persson"] for row in chosen if row["p_star"] == p_star]
        parts.append(f"{min(ratios):.2f} to {max(ratios):.2f} at p* = {p_star:g}")
    return [
        saying(
            "close to full contact Persson theory is closer to the simulations than at low loads",
            f"1 - a_r edge-corrected over theory: {'; '.join(parts)}",
            "the ratio of the small open areas is a sharper test than that of the areas, both near 1",
        )
    ]
