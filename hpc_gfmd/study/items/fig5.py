"""Figure 5: gap/h_rms against eps_t."""

from .. import draw as draw_with
from .. import paper
from ..averages import average, low_high
from ..compare import PRINTED, by_hurst, coarsest, finest, longest, relative_scatter
from ..levels import eps_t_series
from ..paper import saying

NAME = "fig5"
TITLE = "gap/h_rms against eps_t"
PAPER = "linear in eps_t, scatter large at low p* and large H; eps_f = 1/1024, eps_c = 1/2"


def cases(level):
    """The contacts that it is made of."""
    return eps_t_series(level)


def tabulate(runs, level):
    """Means over realisations of gap/h_rms."""
    return average(runs, ("gap_over_h_rms",))


def draw(rows, path):
    """gap/h_rms against eps_t; marks tell eps_f."""
    draw_with.two_pressures(path, rows, "eps_t", "gap_over_h_rms")


def compare(rows):
    """The sign and size of the finite-size correction."""
    lines = []
    for pressure, part in low_high(rows).items():
        for hurst, chosen in by_hurst(part).items():
            series = longest(chosen, "eps_t", "lam_l_over_lam_s")
            printed = paper.coefficients("gap_over_h_rms", chosen[0]["p_star"], hurst)
            if printed and len(series) > 1:
                small, large = coarsest(series, "eps_t"), finest(series, "eps_t")
                slope = (small["gap_over_h_rms"] - large["gap_over_h_rms"]) / (small["eps_t"] - large["eps_t"])
                lines.append(
                    saying(
                        f"H = {hurst:g}, {PRINTED[pressure]}: C_t = {printed['C_t']:g}",
                        f"{slope:+.3g} from eps_t = {small['eps_t']:g} to {large['eps_t']:g} (lam_l/lam_s = "
                        f"{small['lam_l_over_lam_s']:g})",
                        f"one realisation scatters by {relative_scatter(small, 'gap_over_h_rms') or 0:.1%} at eps_t = "
                        f"{small['eps_t']:g}: the few "
                        "longest waves make h_rms; both cutoffs are included here, and how they are cut matters at eps_t = 1",
                    )
                )
    return lines
