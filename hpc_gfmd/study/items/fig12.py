"""Figure 12: p* against gap at several eps_f, H = 0.5."""

from ..levels import gap_pressure_series
from .fig11 import compare, draw, tabulate

__all__ = ["NAME", "PAPER", "TITLE", "cases", "compare", "draw", "tabulate"]

NAME = "fig12"
TITLE = "p* against gap at several eps_f, H = 0.5"
PAPER = "theory within 20 % but at the highest p*; a logarithmic region at low p*"


def cases(level):
    """The contacts that it is made of."""
    return gap_pressure_series(level, (0.5,))
