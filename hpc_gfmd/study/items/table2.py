"""Table 2: coefficients of eq. tfc for kappa at p* = 0.353."""

from .. import coefficients
from .. import draw as draw_with
from ..levels import HURST_GAP, P_HIGH, tfc_series

NAME = "table2"
TITLE = "coefficients of eq. tfc for kappa at p* = 0.353"
PAPER = "C_i, alpha_i for H = 0.3, 0.5, 0.8"


def cases(level):
    """The contacts that it is made of."""
    return tfc_series(level, HURST_GAP)


def tabulate(runs, level):
    """Coefficients, exponents and limits with their uncertainties, ours and the paper's."""
    return coefficients.table_rows(runs, level, "kappa", P_HIGH)


def draw(rows, path):
    """The three corrections at the reference system."""
    draw_with.coefficients(path, rows)


def compare(rows):
    """Our coefficients beside the paper's."""
    return coefficients.compare(rows, "kappa", P_HIGH)
