"""How steeply area and mean gap change with the mean pressure, at most: what the error of one makes
of that of another. Simple laws, for contacts of all kinds; nothing here needs SciPy.
"""

from math import exp, inf, pi, sqrt
from statistics import NormalDist


def pressure_by_area(a_r: float) -> float:
    """Return d log p/d log a_r: 3/2, as in Hertz' contact, times that of Persson's theory,
    a_r = erf(c p); inf at full contact.
    """
    if not 0 < a_r < 1:
        return inf
    x = NormalDist().inv_cdf((1 + a_r) / 2) / sqrt(2)
    return 1.5 * sqrt(pi) * a_r * exp(x * x) / (2 * x)


def gap_by_pressure(gap_over_h_rms: float) -> float:
    """Return -d log gap/d log p: p falls like exp(-2 gap/h_rms), and next to full contact of a wave
    by the root of the gap.
    """
    return min(0.5 / gap_over_h_rms, gap_over_h_rms**-0.5)
