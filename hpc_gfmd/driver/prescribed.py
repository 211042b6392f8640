"""A mean pressure that is not given but found: at which the mean gap, the contact area or the approach is as prescribed.

All three are monotone in the mean pressure, and a solver goes on at another one without a transform. So the pressure is corrected while
the solver iterates, whenever the quantity is known better than it is met: on the coarse grids of a nested start first, and then on the
grid itself, where little is left to correct. By how much the pressure changed from the last coarse grid helps the next load. The steps
are secants in variables in which the curves are nearly straight, between pressures known to be too small and too large.

The area of a grid is a number of points. It is met to the accuracy asked for or to one point; where it jumps by more, as in ordered
walls whose asperities touch all at once, the nearer side of the jump is taken, and `note` says so.
"""

from dataclasses import dataclass
from math import exp, inf, isfinite, log
from statistics import NormalDist

from ..errors import SceneError

SHARE = 0.9  # of the tolerance: what is met better needs no correction
# times the estimated error of the quantity: what is missed by less is not known. That of the mean gap is about the true one, and the
# area is known a little better than the pressure field, whose error stands for its own
TRUST = {"gap_mean": 5.0, "a_r": 1.5, "approach": 2.0}
FIELD = 0.1  # of the error of the pressure field, beside that of the mean gap: the error of the approach
KNOWN = 8.0  # times better than they differ must two points be known for the slope between them
COARSE = {"gap_mean": 0.005, "a_r": 0.03, "approach": 0.005}  # tolerance on coarser grids
TREND = {"gap_mean": 0.3, "a_r": 0.7, "approach": 0.3}  # of the last change of log p0 from grid to grid: the next one
DOUBT = 0.5  # share of the estimated error that has to be as small, on coarser grids
SLOPE = {"gap_mean": 0.6, "a_r": 1.0, "approach": 0.8}  # before anything is known
FAR = log(3.0)  # log p0 of two loads, that have to do with each other no more
BEND = 0.3  # by which a slope may differ from that of the last secant, relative
SLOPES = 0.05, 20.0  # that are believed
STEP, COARSE_STEP = log(2.0), log(4.0)  # the longest, in log p0
SECANTS, MOST = 6, 100  # corrections of a load on a grid: from then on by bisection, of what is known for sure, and at most
RANGE = log(1e-99), log(1e99)  # of p0
SHARP = 0.1  # times the tolerance: no curve but that of the area rises within such an interval of log p0
POINT = 1.001  # by which the area may be missed


@dataclass(frozen=True)
class Prescribed:
    """What a load is to give. quantity: "gap_mean", "a_r" or "approach"; value: in the scene's units."""

    quantity: str
    value: float

    @property
    def closes(self):
        """Whether that is full contact."""
        return self.value == (1.0 if self.quantity == "a_r" else 0.0)


def prescribed(name, values, surface, top, closes):
    """Prescribed loads from the key of a scene's [load] and its values; top: mean gap where the highest peak touches, over the unit of
    slopes; closes: whether a gap of 0 can be had. Raises SceneError for what no pressure gives."""
    if name == "approach":
        return tuple(Prescribed(name, float(value)) for value in values)
    if name == "a_r":
        for value in values:
            if value * surface.grid.N < 0.5:
                raise SceneError(f"load.a_r: found {value:g}, less than half of one of {surface.grid.N} points, "
                                 f"allowed: {1 / surface.grid.N:.3g} to 1")
        return tuple(Prescribed(name, float(value)) for value in values)
    unit = surface.h_rms if name == "gap_over_h_rms" else 1.0
    largest = top * surface.slope / unit
    for value in values:
        if not value < largest:
            raise SceneError(f"load.{name}: found {value:g}, allowed: below {largest:.6g}, where the highest peak touches")
        if value == 0 and not closes:
            raise SceneError(f"load.{name}: found 0 with free boundaries or low_memory, allowed: above 0")
    return tuple(Prescribed("gap_mean", float(value) * unit) for value in values)


@dataclass
class Search:
    """The state of a search: plain numbers, which make a checkpoint.

    target: an area, or a length over the unit of slopes; tolerance: relative; x: log p0; slope: of the straightened curve; points: of
    the surface on this grid, top: its mean gap where the highest peak just touches, as target; offset: of x from the next coarser grid,
    as it was found at another load; grids: how many so far, coarser: x at the end of the one before; low, high: (x, quantity) that are
    too small and too large; known: (x, straightened quantity, relative error) of the last correction; looked: iteration of the last
    look; missed: by how much the target was missed then; side: the area on the chosen side of a jump.
    """

    quantity: str
    target: float
    tolerance: float
    x: float
    slope: float
    points: int
    top: float
    offset: float | None = None
    grids: int = 0
    coarser: float = 0.0
    low: tuple | None = None
    high: tuple | None = None
    known: tuple | None = None
    corrections: int = 0
    looked: int = -1
    missed: float = inf
    side: float | None = None
    note: str | None = None

    @property
    def p0(self):
        """The mean pressure, in the program's units."""
        return exp(self.x)

    def on_coarsest_grid(self):
        """A nested start begins."""
        self.grids = 0

    def on_next_grid(self, points, top, finest=False):
        """Go on on the next finer grid, where other pressures are too small or too large. Returns p0 to begin with."""
        coarser, self.coarser = self.coarser, self.x
        if finest and self.grids and self.offset is not None:
            self.x += self.offset
        elif self.grids > 1:
            self.x += TREND[self.quantity] * (self.x - coarser)
        self.grids, self.points, self.top = self.grids + 1, points, top
        self.low = self.high = self.known = self.side = self.note = None
        self.corrections, self.looked = 0, -1
        return self.p0

    @property
    def found_offset(self):
        """Of x from the next coarser grid; None if there was none."""
        return self.x - self.coarser if self.grids > 1 else None

    def agree(self, comm):
        """All ranks go on with what rank 0 has found."""
        vars(self).update(comm.bcast(vars(self)))

    def near(self, solver, progress):
        """Whether a solution on a coarser grid is as near as it need be; if not, its load may be changed."""
        if not isfinite(self._straight(self.target)) or self.corrections == MOST or self.note is not None:
            return True
        y, error = self._state(solver, progress)
        tolerance = COARSE[self.quantity]
        return not self._correct(solver, y, error, tolerance, COARSE_STEP) and max(self._miss(y), DOUBT * error) <= tolerance

    def adjust(self, solver, progress):
        """Change the load of the solver where its own numbers say that it is wrong; returns whether."""
        if solver.iterations == self.looked:  # before a checkpoint
            return False
        self.looked = solver.iterations
        y, error = self._state(solver, progress)
        self.missed = self._miss(y)
        return self._correct(solver, y, error, self.tolerance, STEP)

    @property
    def may_be_met(self):
        """Whether it is worth asking the certificate."""
        return self.note is not None or self.missed <= self.tolerance

    def met(self, solver, certificate):
        """Whether the certificate finds the quantity as prescribed, or on the side of a jump that was chosen."""
        y = self._of(solver, certificate)
        if self.note is not None and abs(y - self.side) * self.points > POINT and self._miss(y) > self.tolerance:
            self.note = self.low = self.high = None  # there was no jump
        return self.note is not None or self._miss(y) <= self.tolerance

    def correct(self, solver, certificate, sure):
        """Change the load of the solver where the certificate says that it is wrong; returns whether. sure: whatever its errors."""
        y = self._of(solver, certificate)
        error = 0.0 if sure else self._error(y, certificate.gap_mean * solver.grid.a, *certificate.errors)
        return self._correct(solver, y, error, self.tolerance, STEP)

    # -- what is known ---------------------------------------------------------------------------------------------------------

    def _straight(self, y):
        """A function of the quantity that rises about in proportion to log p0: -inf where nothing touches, inf where all does.

        For the area it is that of Persson's theory, a_r = erf(c p0).
        """
        if self.quantity == "approach":
            return log(y) if y > 0 else -inf
        if self.quantity == "a_r":
            y = min(y, 1 - 0.25 / self.points)
            return log(NormalDist().inv_cdf((1 + y) / 2)) if y > 0 else -inf
        return log((self.top - y) / y) if 0 < y < self.top else (-inf if y > 0 else inf)

    def _miss(self, y):
        """Relative; a point more or less is nothing."""
        miss = abs(y / self.target - 1)
        return 0.0 if self.quantity == "a_r" and miss * self.target * self.points <= POINT else miss

    def _state(self, solver, progress):
        """The quantity by the numbers of the solver, and its estimated relative error."""
        if progress.estimates is None or not progress.finite:
            return self.target, inf
        grid, gap = solver.grid, progress.gap_mean
        y = progress.contact / solver.N if self.quantity == "a_r" else gap * grid.a
        if self.quantity == "approach":
            rising = grid.comm.sum([solver.g.sum(dtype=float)])[0] / grid.cell_points if grid.padded else gap
            y = solver.p_cell / solver.elastic.multipliers.uniform * grid.a - rising * grid.a + self.top * grid.N / grid.cell_points
        gap_error, pressure_error = progress.estimates
        return y, self._error(y, gap * grid.a, pressure_error, gap_error, pressure_error)

    def _of(self, solver, certificate):
        """The quantity, as the certificate finds it."""
        if self.quantity == "a_r":
            return certificate.contact / solver.N
        return (certificate.approach if self.quantity == "approach" else certificate.gap_mean) * solver.grid.a

    def _error(self, y, gap, area_error, gap_error, pressure_error):
        """Relative, of the quantity."""
        if self.quantity == "approach":
            return gap_error * gap / y + FIELD * pressure_error if y > 0 else inf
        return area_error if self.quantity == "a_r" else gap_error

    # -- corrections -----------------------------------------------------------------------------------------------------------

    def _correct(self, solver, y, error, tolerance, longest):
        miss = self._miss(y)
        known = error < tolerance if self.corrections > SECANTS else miss > TRUST[self.quantity] * error
        if miss <= SHARE * tolerance or not known or self.note or self.corrections == MOST:
            return False
        self.corrections += 1
        x, f, wanted = self.x, self._straight(y), self._straight(self.target)
        self._enclose(x, y, f > wanted)
        self._learn(x, f, error)
        step = (wanted - f) / self.slope if isfinite(f) else (longest if f < wanted else -longest)
        x += min(max(step, -longest), longest)
        if self.low and self.high:
            low, high = self.low[0], self.high[0]
            if self.quantity == "a_r" and high - low < tolerance:
                x, self.side = min(self.low, self.high, key=lambda end: abs(end[1] - self.target))
                self.note = f"a_r jumps from {self.low[1]:.4g} to {self.high[1]:.4g} at this pressure: the nearer to what was asked for"
            elif high - low < SHARP * tolerance:  # the older bound was none
                self.low, self.high = (None, self.high) if f > wanted else (self.low, None)
            elif not low < x < high or self.corrections > SECANTS:
                x = 0.5 * (low + high)
        self.x = min(max(x, RANGE[0]), RANGE[1])
        solver.continue_at(self.p0)
        return True

    def _enclose(self, x, y, too_much):
        """A bound on the other side that this contradicts was none."""
        if too_much:
            self.high, self.low = (x, y), self.low if self.low and self.low[0] < x else None
        else:
            self.low, self.high = (x, y), self.high if self.high and self.high[0] > x else None

    def _learn(self, x, f, error):
        """The slope between this point of the curve and the one before, if both are known well enough."""
        if self.known and isfinite(f) and x != self.known[0]:
            grain = 2 / (self.target * self.points) if self.quantity == "a_r" else 0.0
            difference = f - self.known[1]
            slope = difference / (x - self.known[0])
            if abs(difference) > KNOWN * (error + self.known[2] + grain) and SLOPES[0] < slope < SLOPES[1]:
                self.slope = slope
        self.known = (x, f, error) if isfinite(f) else None


class Curve:
    """What a sweep knows of the loads before, for a first guess: points, the last three of {"x": log p0, quantity: value}; slopes and
    offsets, {quantity: Search.slope and found_offset}."""

    def __init__(self, points=(), slopes=None, offsets=None):
        self.points, self.slopes, self.offsets = list(points), dict(slopes or {}), dict(offsets or {})

    def add(self, x, contact, search=None):
        """A load that was solved: log p0, its Contact, and the Search where that found it."""
        certificate, a = contact.certificate, contact.surface.grid.a
        self.points = [*self.points[-2:], {"x": x, "a_r": contact.contact_points / contact.N, "gap_mean": certificate.gap_mean * a,
                                           "approach": certificate.approach * a}]
        if search is not None:
            self.slopes[search.quantity] = search.slope
            if search.found_offset is not None:
                self.offsets[search.quantity] = search.found_offset

    def search(self, load, surface, top, tolerance):
        """The Search for a Prescribed load on a surface.Surface; top: see Search."""
        kind, area = load.quantity, load.quantity == "a_r"
        target = load.value if area else load.value / surface.slope
        slope = self.slopes.get(kind, SLOPE[kind])
        search = Search(kind, target, tolerance, 0.0, slope, surface.grid.N, top, self.offsets.get(kind))
        known = [(point["x"], f) for point in self.points if isfinite(f := search._straight(point[kind]))]
        if not known:
            search.x = log(target / 2) if area else log(target / max(surface.sizes))
            if kind == "gap_mean":
                search.x = -1 - 3 * load.value / surface.h_rms  # self-affine walls
            return search
        wanted, (x, f) = search._straight(target), known[-1]
        near = [point for point in known if abs(point[0] - x) < FAR or kind not in self.slopes]  # slopes elsewhere are of no use
        secants = [((x0 + x1) / 2, (f1 - f0) / (x1 - x0)) for (x0, f0), (x1, f1) in zip(near, near[1:]) if x0 != x1]
        if secants and SLOPES[0] < secants[-1][1] < SLOPES[1]:
            middle, search.slope = secants[-1]
            bend = (search.slope - secants[0][1]) / (middle - secants[0][0]) if len(secants) > 1 and middle != secants[0][0] else 0.0
            change = bend * (x + 0.5 * (wanted - f) / search.slope - middle)
            search.slope *= 1 + min(max(change / search.slope, -BEND), BEND)
        search.x = x + (wanted - f) / search.slope
        return search
