"""Figure 8: gap/(g_rms lam_s) against eps_f over 15 decades."""

import numpy as np

from ...theory import persson
from .. import draw as draw_with
from .. import paper
from ..averages import average, low_high, near
from ..compare import with_theory
from ..levels import P_LOW, eps_f_series
from ..paper import saying

NAME = "fig8"
TITLE = "gap/(g_rms lam_s) against eps_f over 15 decades"
PAPER = "Persson theory converges in the fractal limit, far below any eps_f that can be solved"


def cases(level):
    """The contacts that it is made of."""
    return eps_f_series(level)


OBSERVABLE = "gap_over_g_rms_lam_s"
WIDEST = (1e-16, 0.5)  # of eps_f
CONVERGED = 0.1  # this near the fractal limit counts as converged


def tabulate(runs, level):
    """Means over realisations of gap/(g_rms lam_s), and Persson's theory beside them."""
    return with_theory(average(runs, (OBSERVABLE,)), OBSERVABLE)


def draw(rows, path):
    """gap/(g_rms lam_s) against eps_f with Persson's theory over 15 decades."""
    draw_with.two_pressures(
        path, rows, "eps_f", OBSERVABLE, "lam_s_over_a", theory=draw_with.gap_lines(OBSERVABLE, WIDEST), log_y=True, wide=True
    )


def compare(rows):
    """How many decades of roughness the fractal limit needs for H = 0.8 at the low pressure."""
    claim = paper.numbers()["decades_to_fractal_limit"]
    if not any(near(row["hurst"], claim["hurst"]) for row in low_high(rows)["low"]):
        return []
    decades = np.arange(1, 41) / 2
    gap = np.array([float(persson.mean_gap(P_LOW, claim["hurst"], 10.0**-d, unit="g_rms_lam_s")) for d in decades])
    limit = float(persson.mean_gap(P_LOW, claim["hurst"], 1e-60, unit="g_rms_lam_s"))
    needed = decades[np.argmax(gap >= (1 - CONVERGED) * limit)]
    return [
        saying(
            f"H = {claim['hurst']:g}, a_r of order 0.01: self-affine over {claim['decades']} decades before the gap has its fractal "
            f"limit",
            f"corrected theory: within {CONVERGED:.0%} after {needed:g} decades; after three it has "
            f"{gap[decades == 3][0] / limit:.1g} of it",
            "no simulation can show the limit; theory that fits the data at large eps_f says where it lies",
        )
    ]
