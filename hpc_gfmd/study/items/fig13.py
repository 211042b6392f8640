"""Figure 13: p* against gap at several eps_f, H = 0.8."""

from .. import draw as draw_with
from ..averages import average
from ..compare import gap_curves, with_theory
from ..levels import gap_pressure_series

NAME = "fig13"
TITLE = "p* against gap at several eps_f, H = 0.8"
PAPER = "theory within 20 % but at the highest p*; a logarithmic region at low p*"


def cases(level):
    """The contacts that it is made of."""
    return gap_pressure_series(level, (0.8,))


def tabulate(runs, level):
    """Means over realisations of gap/h_rms at every load, and Persson's theory beside them."""
    return with_theory(average(runs, ("gap_over_h_rms",)))


def draw(rows, path):
    """p* against gap/h_rms at several eps_f."""
    draw_with.pressure_against_gap(path, rows)


def compare(rows):
    """How well theory fits, corrected and as printed."""
    return gap_curves(rows)
