"""Errors of the solution from the error of its energy.

With e = u - u* the distance from the solution, E(u) - E* = <p*, g> + 1/2 <e, K e> <= G, the duality gap of any admissible pressure.
So <e, K e> <= 2 G, which bounds the pressure: |p - p*|^2 = |K e|^2 <= K_max <e, K e>. The mean gap is wrong by mean(e). For a pressure
w of zero mean, <w, e> is at most |w|_S |e|_K; two of them give mean(e):

- w = p* - p0: <p*, e> = <p*, g> is between 0 and G - 1/2 <e, K e>, so |mean(e)| <= |u*|_K sqrt(2 G)/(N p0), a bound;
- w = -1 out of contact and constant in contact, where e vanishes but at points that change sides: |mean(e)| <= |w|_S sqrt(2 G)/N,
  which is far smaller where little is out of contact.

Where the surface ends within the cell these are bounds of the mean of e over the cell. That over the surface alone is different by
<w, e>/N, w = 1 on the surface (less its mean): |w|_S is known beforehand, it is the self-energy of the nominal area.
"""

import numpy as np

PRESSURE = 0.65  # of the bound with kap in place of 1/K_max
RESPONSE = 0.8  # of the second bound of the mean gap


def field_errors(energy, uKu, closed, N, p0, gap, kap, response, surface):
    """Relative errors of the mean gap and of the pressure field (L2).

    energy: 2 G; uKu: <u, K u>; closed: sum of p^2 in contact; N: points; gap: its mean; kap: 1/K of the shortest waves, as
    bodies/base.py has it; response: |w|_S out of contact; surface: |w|_S of the nominal area, 0 where that is all.
    """
    e = np.sqrt(max(energy, 0.0))
    shift = e * (min((np.sqrt(max(uKu, 0.0)) + e) / p0, RESPONSE * response) + surface) / N
    mean_gap = shift / (gap - shift) if shift < gap else (0.0 if shift == 0 else np.inf)
    return float(mean_gap), float(PRESSURE * e / np.sqrt(kap * closed))
