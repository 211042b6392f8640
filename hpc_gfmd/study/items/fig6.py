"""Figure 6: gap/h_rms against eps_f, with Persson theory."""

from .. import draw as draw_with
from ..averages import average
from ..compare import gap_exponents, theory_factors, with_theory
from ..levels import eps_f_series

NAME = "fig6"
TITLE = "gap/h_rms against eps_f, with Persson theory"
PAPER = "power laws; theory within 10 % at p* = 0.007, 2 to 3 times too small at 0.353"


def cases(level):
    """The contacts that it is made of."""
    return eps_f_series(level)


OBSERVABLE = "gap_over_h_rms"


def tabulate(runs, level):
    """Means over realisations of gap/h_rms, and Persson's theory beside them."""
    return with_theory(average(runs, (OBSERVABLE,)), OBSERVABLE)


def draw(rows, path):
    """gap/h_rms against eps_f with Persson's theory, corrected and as printed."""
    draw_with.two_pressures(path, rows, "eps_f", OBSERVABLE, "lam_s_over_a", theory=draw_with.gap_lines(OBSERVABLE), log_y=True)


def compare(rows):
    """Exponents, and the factor between theory and simulation at the high pressure."""
    return gap_exponents(rows, OBSERVABLE, "gap_exponents_h_rms") + theory_factors(rows, "theory_factor_h_rms")
