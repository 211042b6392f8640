"""Figure 4: gap/h_rms against eps_c."""

from .. import draw as draw_with
from ..averages import average, low_high
from ..compare import PRINTED, by_hurst, coarsest, finest, longest
from ..levels import eps_c_series
from ..paper import of_hurst, saying

NAME = "fig4"
TITLE = "gap/h_rms against eps_c"
PAPER = "linear in eps_c; three times the limit at eps_c = 1/2 for H = 0, p* = 0.353, 20 % above it for H = 0.8"


def cases(level):
    """The contacts that it is made of."""
    return eps_c_series(level)


def tabulate(runs, level):
    """Means over realisations of gap/h_rms."""
    return average(runs, ("gap_over_h_rms",))


def draw(rows, path):
    """gap/h_rms against eps_c; marks tell eps_f."""
    draw_with.two_pressures(path, rows, "eps_c", "gap_over_h_rms")


def compare(rows):
    """How much a coarse grid changes the gap at the high pressure."""
    lines = []
    for hurst, chosen in by_hurst(low_high(rows)["high"]).items():
        printed = of_hurst("gap_ratio_eps_c", hurst)
        series = longest(chosen, "eps_c", "lam_l_over_lam_s")
        if printed and len(series) > 1:
            ratio = coarsest(series, "eps_c")["gap_over_h_rms"] / finest(series, "eps_c")["gap_over_h_rms"]
            lines.append(
                saying(
                    f"H = {hurst:g}, {PRINTED['high']}: gap {'almost ' if printed > 2 else 'roughly '}{printed:g} times the limit at "
                    f"eps_c = 1/2",
                    f"{ratio:.4f} times that at eps_c = 1/{1 / finest(series, 'eps_c')['eps_c']:g} (lam_l/lam_s = "
                    f"{series[0]['lam_l_over_lam_s']:g})",
                    "the same surfaces on finer grids, the error of every gap bounded by its duality gap: this is what the grid "
                    "alone does",
                )
            )
    return lines
