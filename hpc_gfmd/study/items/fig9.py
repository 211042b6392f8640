"""Figure 9: a_r against p* at low pressures."""

from ...theory import elastic, persson
from .. import draw as draw_with
from .. import paper
from ..averages import average
from ..compare import by_hurst
from ..levels import pressure_series
from ..paper import quoted, saying

LOW = 0.1  # p* up to which the area is called linear

NAME = "fig9"
TITLE = "a_r against p* at low pressures"
PAPER = "linear with slopes 1.93 to 2.16, Persson theory 1.6; H matters little"


def cases(level):
    """The contacts that it is made of."""
    return pressure_series(level)


def tabulate(runs, level):
    """Means over realisations of a_r and kappa, as counted and edge-corrected, with Persson's theory."""
    rows = average(runs, ("a_r", "a_r_edge", "kappa", "kappa_edge"))
    return [row | {"persson": float(persson.contact_area(row["p_star"]))} for row in rows]


def draw(rows, path):
    """a_r and a_r/p* against p*."""
    draw_with.areas(path, rows, high=False)


def compare(rows):
    """The slope at low pressure, and how little H matters."""
    low = [row for row in rows if row["p_star"] <= LOW]
    if not low:
        return []
    text = {}
    for name in ("kappa", "kappa_edge"):
        at = {hurst: min(part, key=lambda row: abs(row["p_star"] - 0.01)) for hurst, part in by_hurst(low).items()}
        text[name] = ", ".join(f"{quoted(row[name], row[name + '_se'])} (H = {hurst:g})" for hurst, row in at.items())
    slope, spread = paper.numbers()["slope"], []
    for p_star in sorted({row["p_star"] for row in rows}):
        areas = [row["a_r_edge"] for row in rows if row["p_star"] == p_star]
        spread.append(max(areas) / min(areas) - 1)
    return [
        saying(
            f"slope {slope['low']:g} to {slope['high']:g}, Persson theory {slope['theory']:g}",
            f"as counted {text['kappa']}; edge-corrected {text['kappa_edge']}; theory {persson.KAPPA_LOW_LOAD:.3f} (BGT "
            f"{elastic.KAPPA_BGT:.3f})",
            "ours are at finite eps_f, eps_t, eps_c; the limits are in table 5",
        ),
        saying(
            f"a_r between H near 0 and near 1 differs by at most {paper.numbers()['area_spread_in_hurst']:.0%}",
            f"edge-corrected: {max(spread):.0%} at most over all loads, {min(spread):.1%} at least",
            f"the paper's own slopes, {slope['high']:g} and {slope['low']:g}, differ by {slope['high'] / slope['low'] - 1:.0%}",
        ),
    ]
