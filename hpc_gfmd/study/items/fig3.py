"""Figure 3: kappa against eps_t."""

from .. import draw as draw_with
from .. import paper
from ..averages import average, low_high
from ..compare import PRINTED, by_hurst, coarsest, finest, relative_scatter
from ..levels import eps_t_series
from ..paper import saying

NAME = "fig3"
TITLE = "kappa against eps_t"
PAPER = "kappa nearly independent of eps_t: 1 % at p* = 0.007, 0.1 % at 0.353; eps_f = 1/1024, eps_c = 1/2"


def cases(level):
    """The contacts that it is made of."""
    return eps_t_series(level)


def tabulate(runs, level):
    """Means over realisations of kappa, as counted and edge-corrected."""
    return average(runs, ("kappa", "kappa_edge"))


def draw(rows, path):
    """kappa against eps_t; marks tell eps_f."""
    draw_with.two_pressures(path, rows, "eps_t", "kappa", "lam_l_over_lam_s", edge=True, theory=draw_with.kappa_lines)


def compare(rows):
    """The scatter that the text gives, and the trend with eps_t."""
    lines = []
    for pressure, part in low_high(rows).items():
        fine = [row for row in part if row["eps_f"] == min(row["eps_f"] for row in part)]
        scatter = {row["hurst"]: relative_scatter(row, "kappa") for row in fine if row["eps_t"] == 0.5}
        known = {hurst: x for hurst, x in scatter.items() if x}
        drift = {h: coarsest(r, "eps_t")["kappa"] / finest(r, "eps_t")["kappa"] - 1 for h, r in by_hurst(fine).items() if len(r) > 1}
        if known and drift:
            lines.append(
                saying(
                    f"{PRINTED[pressure]}: kappa fluctuates by {paper.numbers()['kappa_fluctuation'][pressure]:.1%}",
                    "one realisation, eps_t = 1/2: " + ", ".join(f"{x:.2%} (H = {h:g})" for h, x in known.items()),
                    "scatter grows with H and falls as eps_t; from the smallest cell to the largest kappa changes by "
                    + ", ".join(f"{x:+.1%} (H = {h:g})" for h, x in drift.items()),
                )
            )
    return lines
