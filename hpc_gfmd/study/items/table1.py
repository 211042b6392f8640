"""Table 1: coefficients of eq. tfc for kappa at p* = 0.007."""

from .. import coefficients
from .. import draw as draw_with
from ..levels import HURST_GAP, P_LOW, tfc_series

NAME = "table1"
TITLE = "coefficients of eq. tfc for kappa at p* = 0.007"
PAPER = "C_i, alpha_i for H = 0.3, 0.5, 0.8"


def cases(level):
    """The contacts that it is made of."""
    return tfc_series(level, HURST_GAP)


def tabulate(runs, level):
    """Coefficients, exponents and limits with their uncertainties, ours and the paper's."""
    return coefficients.table_rows(runs, level, "kappa", P_LOW)


def draw(rows, path):
    """The three corrections at the reference system."""
    draw_with.coefficients(path, rows)


def compare(rows):
    """Our coefficients beside the paper's."""
    return coefficients.compare(rows, "kappa", P_LOW)
