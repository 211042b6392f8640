"""Figure 7: gap/(g_rms lam_s) against eps_f, with Persson theory."""

from .. import draw as draw_with
from ..averages import average
from ..compare import gap_exponents, theory_factors, with_theory
from ..levels import eps_f_series

NAME = "fig7"
TITLE = "gap/(g_rms lam_s) against eps_f, with Persson theory"
PAPER = "theory scaled by 3.3, 3.1, 2.75, 2 (H = 0, 0.3, 0.5, 0.8) at p* = 0.353 and not at 0.007"


def cases(level):
    """The contacts that it is made of."""
    return eps_f_series(level)


OBSERVABLE = "gap_over_g_rms_lam_s"


def tabulate(runs, level):
    """Means over realisations of gap/(g_rms lam_s), and Persson's theory beside them."""
    return with_theory(average(runs, (OBSERVABLE,)), OBSERVABLE)


def draw(rows, path):
    """gap/(g_rms lam_s) against eps_f with Persson's theory, corrected and as printed."""
    draw_with.two_pressures(path, rows, "eps_f", OBSERVABLE, "lam_s_over_a", theory=draw_with.gap_lines(OBSERVABLE), log_y=True)


def compare(rows):
    """Exponents, and the factor between theory and simulation at the high pressure."""
    return gap_exponents(rows, OBSERVABLE, "gap_exponents_g_rms_lam_s") + theory_factors(rows, "theory_factor_g_rms_lam_s")
