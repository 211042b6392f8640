"""Figure 2: kappa against eps_f."""

from .. import draw as draw_with
from .. import paper
from ..averages import average, low_high, near
from ..compare import finest
from ..levels import eps_f_series
from ..paper import saying

NAME = "fig2"
TITLE = "kappa against eps_f"
PAPER = "kappa falls as eps_f^0.67, by up to 30 % for H = 0.8 at p* = 0.007, hardly at 0.353; eps_t = eps_c = 1/2"


def cases(level):
    """The contacts that it is made of."""
    return eps_f_series(level)


def tabulate(runs, level):
    """Means over realisations of kappa, as counted and edge-corrected."""
    return average(runs, ("kappa", "kappa_edge"))


def draw(rows, path):
    """kappa against eps_f."""
    draw_with.two_pressures(path, rows, "eps_f", "kappa", "lam_s_over_a", edge=True, theory=draw_with.kappa_lines)


def compare(rows):
    """The fractal error that the text gives for H = 0.8."""
    claim = paper.numbers()["fractal_error"]
    chosen = [row for row in low_high(rows)["low"] if near(row["hurst"], claim["hurst"])]
    at = next((row for row in chosen if near(row["eps_f"], claim["eps_f"])), None)
    best = finest(chosen, "eps_f")
    if at is None or best is at:
        return []
    coefficient = paper.coefficients("kappa", best["p_star"], claim["hurst"])
    by_table = coefficient["C_f"] * claim["eps_f"] ** coefficient["alpha_f"] / paper.of_hurst("kappa_tfc", claim["hurst"])
    by_text = claim["coefficient"] * claim["eps_f"] ** paper.numbers()["alpha_f"]
    ours = {name: at[name] / best[name] - 1 for name in ("kappa", "kappa_edge")}
    return [
        saying(
            f"H = 0.8, lam_l/lam_s = {1 / claim['eps_f']:g}: kappa {claim['error']:.0%} too large, from {claim['coefficient']:g} "
            f"eps_f^0.67",
            f"{ours['kappa']:.0%} above lam_l/lam_s = {1 / best['eps_f']:g} as counted, {ours['kappa_edge']:.0%} edge-corrected",
            f"{claim['coefficient']:g} eps_f^0.67 is {by_text:.2f} in kappa, not {claim['error']:.0%} of it; the table's "
            f"C_f = {coefficient['C_f']:g} makes it {by_table:.0%}; counting grid points at eps_c = 1/2 enlarges the fractal "
            f"correction",
        )
    ]
