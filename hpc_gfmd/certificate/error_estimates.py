"""Errors of the solution from the error of its energy, without knowing the solution.

With e = u - u* the distance from the solution, E(u) - E* = <p*, g> + 1/2 <e, K e> <= G, the duality
gap of any admissible pressure. So <e, K e> <= 2 G, which bounds the pressure: |p - p*|^2 = |K e|^2
<= K_max <e, K e>. The mean gap is wrong by mean(e). For a test pressure v of zero mean, <v, e> is
at most |v|_S |e|_K; two of them give mean(e):

- v = p* - p0: <p*, e> = <p*, g> is between 0 and G - 1/2 <e, K e>, so |mean(e)| <= |u*|_K sqrt(2
  G)/(N p0), a bound;
- v = -1 out of contact and constant in contact, where e vanishes but at points that change sides:
  |mean(e)| = |<v, S (p - p*)>|/N, which is far smaller where little is out of contact. Here p* is
  p^ but for a part that is at most half of the bound |v|_S sqrt(2 G)/N, because 1/2 <e, K e> is
  nearly all of G; and <v, S (p - p^)> is known.

Where the surface ends within the cell the first is a bound of the mean of e over the cell. That
over the surface alone is different by <v, e>/N, v = 1 on the surface (less its mean): |v|_S is
known beforehand, it is the self-energy of the nominal area. The second v is -1 on the surface out
of contact, constant in contact and 0 beyond: on every level t N/n - s, t and s being the indicators
of the n points in contact and of the surface.

An error dS of S itself (Body.error) acts as heights wrong by dS p, smooth ones: the pressure is
wrong by about -K dS p where all is closed, elsewhere by less. The mean gap follows it as it follows
the load, by |v|_S^2 with the second v: of the open points alone by less than that, unless they are
at the edges of the surface, where most of that error is. All of it may be where the last m points
are open, as in corners: it opens them by the root of m times its norm, times the compliance of m
points.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..kernels.certify import BINS, PER_OCTAVE, count_uncertain
from ..operators.multilevel import EQUIVALENCE
from ..operators.problem import ROUNDING
from ..parallel.halo import next_row

if TYPE_CHECKING:
    from ..operators.multilevel import Multilevel
    from ..operators.problem import Problem

# The error of the pressure over the bound with the compliance in place of 1/K_max; more on small
# grids, by TINY over the root of their points, and with few points in contact, by LONE over their
# number
PRESSURE, TINY, LONE = 0.55, 5.0, 1.0
# of the relative error of the pressure by S: one of the load that changes the mean gap as much
# (0.04 was seen)
LOADED = 0.05
CORNER = 0.3  # of the norm of that error: where the last points are open (0.22 was seen)
# times the root of m: the compliance of m points with contact all around them, 8/(3 pi^1.5) for a
# disc; of one it is 1
POCKET = 0.5
# in the second expression for the mean gap: share of the bound, at most; S over the sum over levels
# for long waves
UNKNOWN, ALIGNED = 0.5, 1.2

# times the rms of rounding errors in double precision: a difference of pressures that means nothing
TIE = 4.0
# The error of the pressure of a point is at most FAR times the rms, of EDGE points; of more it is
# at most NEAR times, and what it takes less than CLOSE times to move is moved; where it moves edges
# together, TOGETHER. Of the points that are near a SHARE is on the wrong side; ASPERITY may change
# sides at once.
FAR, NEAR, CLOSE, TOGETHER, EDGE = 12.0, 1.8, 0.5, 1.5, 3
# Edges move together where the error has one sign, as long waves have (total^2 over squares and
# spread: from ANY_SIGN to ONE_SIGN), or chords of the contact are LONG (points), but not where the
# error is one of single asperities (FEW: share of the contact's points).
ANY_SIGN, ONE_SIGN, LONG, FEW = 0.2, 0.4, 16, 0.02
SHARE, ASPERITY = 0.08, 10
# of all that take as little or less: so many within an octave of squares are alike (at an edge 0.2
# to 0.5 are)
ALIKE = 0.75
SURE = (
    3.0  # times the same in single precision: the heights that were rounded might be on either side
)


class State(NamedTuple):
    """Sums over all points, and all ranks, of a state at the mean pressure p0.

    open_p, open_pp: of p and p^2 out of contact; closed_pp: of p^2 in contact; contact: points;
    uKu: <u, K u>; rr, tt, rt, ts, rs: what Multilevel.sweep returns of p out of contact.
    """

    p0: float
    open_p: float
    open_pp: float
    closed_pp: float
    contact: float
    gap: float
    uKu: float
    rr: float
    tt: float
    rt: float
    ts: float
    rs: float


class Estimate(NamedTuple):
    """Relative errors of the mean gap and of the pressure field; attainable: of both, where most of
    it is what no iteration makes smaller, that part, else 0; squares: of the pressure's error,
    summed over points; shift: of the sum of gaps, by the load that is missing or misplaced."""

    gap: float = np.inf
    pressure: float = np.inf
    attainable: tuple[float, float] = (0.0, 0.0)
    squares: float = np.inf
    shift: float = np.nan


def estimate(problem: Problem, levels: Multilevel, state: State) -> Estimate:
    """The Estimate of a state, for solver and certificate alike.

    p^ is the pressure in contact, more by as much at each point as makes up for what is left out of
    contact. Rounding errors of the working precision are those of the heights, which are
    independent from point to point, and those of the pressure, as a load that is wrong by as much.
    """
    p0, N, body = state.p0, problem.grid.N, problem.body
    contact, gap, closed_pp = state.contact, state.gap, state.closed_pp
    if not (contact > 0 and closed_pp > 0 and np.isfinite([state.open_pp, gap, state.uKu]).all()):
        return Estimate()
    compliance, share = 1.0 / body.scale(problem.grid), contact / N
    residual, test, product = levels.test_products(
        state.open_p, state.open_pp, contact, *state[-5:]
    )
    e, response = np.sqrt(EQUIVALENCE * compliance * residual), np.sqrt(compliance * test) / share
    squares = (PRESSURE * (1 + TINY / np.sqrt(N) + LONE / contact) * e) ** 2 * body.typical(
        problem.grid
    )

    eps = ROUNDING * float(np.finfo(problem.dtype).eps)
    relative = float(np.sqrt(squares / closed_pp))
    floor = float(
        np.linalg.norm([problem.rounding / np.sqrt(closed_pp / contact), eps, body.error])
    )
    pressure, floor = float(np.hypot(relative, floor)), floor if relative < floor else 0.0
    if contact == N:  # nothing is open
        return Estimate(0.0, pressure, (0.0, floor), squares, 0.0)
    shift = compliance * product / share
    norm = np.sqrt(max(state.uKu, 0.0))
    wrong = min(
        e * ((norm + e) / p0 + problem.self_energy), UNKNOWN * response * e + ALIGNED * abs(shift)
    )
    wide = np.sqrt(N - contact)
    last = CORNER * np.sqrt(N) * wide * max(1, POCKET * wide)
    least = body.error * p0 * min(LOADED * (response**2 + compliance * N), last)
    least += eps * (p0 * response**2 + gap) + problem.rounding * (N - contact)
    attainable = _relative(least, gap) if wrong < least else 0.0, floor
    return Estimate(_relative(wrong + least, gap), pressure, attainable, squares, shift)


def _relative(shift: float, gap: float) -> float:
    return float(shift / (gap - shift)) if shift < gap else (0.0 if shift == 0 else np.inf)


class Pattern(NamedTuple):
    """How the error of the pressure is spread: participation number, and whether it has one sign
    (1, else 0; or between)."""

    spread: float
    coherence: float


def error_pattern(total: float, squares: float, fourth: float, contact: float, N: int) -> Pattern:
    """Pattern of the error of the pressure: as that of what is left out of contact (sums of p, p^2,
    p^4), over no more points than are in contact, or out of it."""
    spread = max(min(squares**2 / fourth if fourth > 0 else 1.0, contact, N - contact), 1.0)
    alike = total**2 / (squares * spread) if squares > 0 else 0.0
    return Pattern(spread, min(max((alike - ANY_SIGN) / (ONE_SIGN - ANY_SIGN), 0.0), 1.0))


def misclassified_points(
    problem: Problem,
    g: np.ndarray,
    p: np.ndarray,
    squares: float,
    pattern: Pattern,
) -> float:
    """How many points may be in the wrong set, in contact or out of it; squares: sum of squares of
    the error of the pressure, pattern: how it is spread. Collective.

    No more than it takes to use `squares` up, the easiest first. Of the points that are near few
    are in the wrong set if they differ; of those that are alike, as in ordered walls, all may be.
    Points in contact and out of it are counted apart: they change the area in opposite ways.
    """
    double, rounding = problem.dtype == np.float64, problem.rounding
    mean_square = squares / pattern.spread
    sure = 0.0 if double else SURE * rounding
    largest = max(min(mean_square * FAR**2, squares), sure**2)
    if largest <= 0:
        return 0.0
    bins = np.zeros((2, BINS))
    grid, compliance = problem.grid, 1.0 / problem.body.scale(problem.grid)
    below = next_row(
        grid.comm, g[: min(grid.inside[0], 1)], np.minimum(grid.starts, grid.nominal[0])
    )
    found = count_uncertain(
        g, p, grid.inside, below, compliance, TIE * rounding if double else 0.0, sure, largest, bins
    )
    *counts, contact, along, across = grid.comm.sum([*bins.ravel(), *found])
    edges = min(along, across)  # of the longer chords
    together = (
        max(pattern.coherence, 2 * contact > LONG * edges)
        if pattern.spread > FEW * contact
        else 0.0
    )
    moved = CLOSE + (TOGETHER - CLOSE) * together
    takes = largest * 2.0 ** (-(np.arange(BINS) + 1) / PER_OCTAVE)
    takes[-1] = 0.0
    wrong = 0.0
    near = takes < mean_square * NEAR**2
    for points in np.reshape(counts, (2, BINS)):
        affordable = np.floor(
            np.interp(squares, np.cumsum((points * takes)[::-1]), np.cumsum(points[::-1]))
        )
        easy = points * near
        at_once = max(
            (easy[1:] + easy[:-1]).max(),
            min(easy.sum(), ASPERITY),
            min(points.sum(), EDGE),
            _alike(points, takes, squares),
        )
        likely = max(SHARE * easy.sum() + at_once, easy[takes < mean_square * moved**2].sum())
        wrong = max(wrong, min(likely, affordable))
    return wrong


def _alike(points: np.ndarray, takes: np.ndarray, squares: float) -> float:
    """The most points that take about the same while hardly any take less, as in ordered walls, if
    `squares` is enough for them."""
    octave = np.ones(PER_OCTAVE)
    alike, spent = (np.convolve(x, octave)[PER_OCTAVE - 1 :] for x in (points, points * takes))
    easier = np.cumsum(points[::-1])[::-1]
    return float(alike[(alike > ALIKE * easier) & (spent <= squares)].max(initial=0.0))


def full_contact_error(problem: Problem) -> float:
    """Relative error of the pressure field where all points touch: of S and of storing heights and
    pressures in the working precision."""
    eps = ROUNDING * float(np.finfo(problem.dtype).eps)
    return float(np.linalg.norm([problem.rounding / problem.p0, eps, problem.body.error]))


def relative_area(wrong: float, contact: float) -> float:
    """Relative error of the area if `wrong` of the points in contact may be too many, or too
    few."""
    return float(wrong / (contact - wrong)) if wrong < contact else np.inf
