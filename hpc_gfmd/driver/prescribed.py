"""A mean pressure that is not given but found: at which the mean gap, the contact area or the approach is as prescribed.

All three are monotone in the mean pressure, and a solver goes on at another one without a transform. So the pressure is corrected while
the solver iterates, whenever the quantity is known better than it is met: on the coarse grids of a nested start first, and then on the
grid itself, where little is left to correct. By how much the pressure changed from grid to grid helps the next load. The steps are
secants in variables in which the curves are nearly straight, between pressures known to be too small and too large. Where a quantity is
not known yet, but likely to be missed, it is corrected too: beside what is still to be solved that costs little, later it costs more.

The area of a grid is a number of points. It is met to the accuracy asked for or to one point; where it jumps by more, as in ordered
walls whose asperities touch all at once, the nearer side of the jump is taken, and `note` says so.
"""

from dataclasses import dataclass, field
from math import copysign, exp, hypot, inf, isfinite, log
from statistics import NormalDist

from ..errors import SceneError

SHARE = 0.9  # of the tolerance: what is met better needs no correction
# times the estimated error of the quantity: what is missed by less is not known. That of the mean gap is about the true one, and the
# area is known a little better than the pressure field, whose error stands for its own
TRUST = {"gap_mean": 5.0, "a_r": 1.5, "approach": 2.0}
# Likely: missed by more than so many times that error, which is not yet known, once that of the pressure field is below a bound
LIKELY = {"gap_mean": (1.0, 0.15), "a_r": (0.4, 0.04), "approach": (1.0, 0.15)}
WORTH = 1.0  # times the tolerance, beside that: what is missed by less waits until it is known
GUESSES = 8  # such corrections of a load on a grid, at most
ANSWERED = 2  # iterations after which a solution has followed a correction
FIELD = 0.1  # of the error of the pressure field, beside that of the mean gap: the error of the approach
NOISE = {"gap_mean": 1.0, "a_r": 0.3, "approach": 1.0}  # standard deviation of the quantity, over its estimated error
BENDS = 0.3  # the same of a slope, relative, before two points tell it
COARSE = {"gap_mean": 0.005, "a_r": 0.03, "approach": 0.005}  # tolerance on coarser grids
TREND = {"gap_mean": 0.3, "a_r": 0.7, "approach": 0.3}  # of the last change of log p0 from grid to grid: the next one, at most,
LEAST = 0.3  # and at least, where the ratio of the last two tells
READ = 2.0  # times the tolerance: a larger error on a coarser grid says nothing of what is left to correct
DOUBT = 1.5  # times the estimated error has to be as small, on coarser grids
SLOPES = 0.05, 20.0  # of the straightened curve, that are believed
STEP, COARSE_STEP = log(2.0), log(4.0)  # the longest, in log p0
SECANTS, MOST = 6, 100  # corrections of a load on a grid: from then on by bisection, of what is known for sure, and at most
BACK = 0.5  # of the last change: the longest step in the opposite direction
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
    the surface on this grid, top: its mean gap where the highest peak just touches, as target; offsets: of x from every grid to the
    next finer one, coarsest first, as they were found at another load; grids: how many so far, ends: x at the end of those before;
    left: what x had still to change there; low, high: (x, quantity) that are too small and too large; known: (x, straightened quantity,
    relative error) of the last correction; change: of x, then; corrections: by what was known, guesses: by what was not; answered:
    iteration at which the solution will have followed; looked: last one looked at; missed: the target, by how much; side: of a jump.
    """

    quantity: str
    target: float
    tolerance: float
    x: float
    slope: float
    points: int
    top: float
    offsets: list[float] = field(default_factory=list)
    grids: int = 0
    ends: list[float] = field(default_factory=list)
    left: float = 0.0
    low: tuple | None = None
    high: tuple | None = None
    known: tuple | None = None
    change: float = 0.0
    corrections: int = 0
    guesses: int = 0
    answered: int = 0
    looked: int = -1
    missed: float = inf
    side: float | None = None
    note: str | None = None

    @property
    def p0(self):
        """The mean pressure, in the program's units."""
        return exp(self.x)

    def on_coarsest_grid(self):
        """A start on coarser grids begins, or one without any."""
        self.grids, self.ends, self.left = 0, [], 0.0
        self.x -= sum(self.offsets)

    def on_next_grid(self, points, top):
        """Go on on the next finer grid, where other pressures are too small or too large. Returns p0 to begin with."""
        if self.grids:
            self.x += self.left
            self.ends.append(self.x)
            self.x += self._next_offset()
        self.grids, self.left, self.points, self.top = self.grids + 1, 0.0, points, top
        self.low = self.high = self.known = self.side = self.note = None
        self.change, self.corrections, self.guesses, self.answered, self.looked = 0.0, 0, 0, 0, -1
        return self.p0

    def _next_offset(self):
        """By how much x is likely to change now: as at another load, or by a share of the last change."""
        if len(self.ends) <= len(self.offsets):
            return self.offsets[len(self.ends) - 1]
        changes = [b - a for a, b in zip(self.ends, self.ends[1:])]
        share = TREND[self.quantity]
        if len(changes) > 1 and changes[-2] != 0:
            share = min(max(changes[-1] / changes[-2], LEAST), share)
        return share * changes[-1] if changes else 0.0

    @property
    def found_offsets(self):
        """Of x from every grid to the next finer one."""
        return [b - a for a, b in zip(self.ends, [*self.ends[1:], self.x])]

    def agree(self, comm):
        """All ranks go on with what rank 0 has found."""
        vars(self).update(comm.bcast(vars(self)))

    def near(self, solver, progress):
        """Whether a solution on a coarser grid is as near as it need be; if not, its load may be changed."""
        if not isfinite(self._straight(self.target)) or self.corrections > 2 * SECANTS or self.note is not None:
            return True
        y, error = self._state(solver, progress)
        tolerance, f = COARSE[self.quantity], self._straight(y)
        self.left = (self._straight(self.target) - f) / self.slope if error < READ * tolerance and isfinite(f) else 0.0
        if self.known and f == self.known[1] and self._miss(y) > max(TRUST[self.quantity] * error, tolerance):
            self.x, self.left = self.known[0], 0.0  # it does not answer: few peaks are left of an ordered wall
            return True
        return not self._correct(solver, y, error, tolerance, COARSE_STEP) and max(self._miss(y), DOUBT * error) <= tolerance

    def adjust(self, solver, progress):
        """Change the load of the solver where its own numbers say that it is wrong; returns whether."""
        if solver.iterations == self.looked:  # before a checkpoint
            return False
        self.looked = solver.iterations
        y, error = self._state(solver, progress)
        self.missed = self._miss(y)
        return self._correct(solver, y, error, self.tolerance, STEP) or self._anticipate(solver, y, error, progress)

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
        if self.corrections == SECANTS + 1:  # bounds from before were less sure
            self.low = self.high = None
        self.corrections += 1
        x, f, wanted = self.x, self._straight(y), self._straight(self.target)
        self._enclose(x, y, f > wanted)
        self._learn(x, f, error)
        x += self._step(f, longest)
        if self.low and self.high:
            low, high = self.low[0], self.high[0]
            if self.quantity == "a_r" and high - low < tolerance:
                x, self.side = min(self.low, self.high, key=lambda end: abs(end[1] - self.target))
                self.note = f"a_r jumps from {self.low[1]:.4g} to {self.high[1]:.4g} at this pressure: the nearer to what was asked for"
            elif high - low < SHARP * tolerance:  # the older bound was none
                self.low, self.high = (None, self.high) if f > wanted else (self.low, None)
            elif self.corrections > SECANTS:
                x = 0.5 * (low + high)
            elif not low < x < high:  # the older bound may have been taken from a solution that had not followed yet
                self.low, self.high = (None, self.high) if f > wanted else (self.low, None)
        elif self.corrections > SECANTS:  # nothing answered: longer and longer steps
            x = self.x + copysign(min(2 * max(abs(self.change), tolerance), longest), wanted - f)
        return self._go_to(x, solver)

    def _anticipate(self, solver, y, error, progress):
        """A correction by a quantity that is not known yet: nothing is learnt from it."""
        likely, field_error = LIKELY[self.quantity]
        miss, f = self._miss(y), self._straight(y)
        if not (likely * error + WORTH * self.tolerance < miss < inf and progress.estimates[1] < field_error and isfinite(f)):
            return False
        if solver.iterations < self.answered or self.note or self.corrections > SECANTS or self.guesses == GUESSES:
            return False
        x = self.x + self._step(f, STEP)
        if (self.low and x <= self.low[0]) or (self.high and x >= self.high[0]):
            return False
        self.guesses += 1
        return self._go_to(x, solver)

    def _step(self, f, longest):
        """By how much x is to change where the straightened quantity is f: the last change may have come too early, or this one."""
        short = self._straight(self.target) - f
        if short * self.change < 0:
            longest = min(longest, BACK * abs(self.change))
        return min(max(short / self.slope, -longest), longest)

    def _go_to(self, x, solver):
        """Change the load of the solver."""
        self.change = x - self.x
        self.x, self.answered = min(max(x, RANGE[0]), RANGE[1]), solver.iterations + ANSWERED
        solver.correct_load(self.p0)
        return True

    def _enclose(self, x, y, too_much):
        """A bound on the other side that this contradicts was none."""
        if too_much:
            self.high, self.low = (x, y), self.low if self.low and self.low[0] < x else None
        else:
            self.low, self.high = (x, y), self.high if self.high and self.high[0] > x else None

    def _learn(self, x, f, error):
        """The slope between this point of the curve and the one before, as far as it is known better than by itself."""
        if self.known and isfinite(f) and x != self.known[0]:
            grain = 1 / (self.target * self.points) if self.quantity == "a_r" else 0.0
            difference = f - self.known[1]
            slope = difference / (x - self.known[0])
            noise = NOISE[self.quantity] * hypot(error, self.known[2]) + grain
            if SLOPES[0] < slope < SLOPES[1]:
                self.slope *= (slope / self.slope)**(1 / (1 + (noise / (BENDS * difference))**2))
        self.known = (x, f, error) if isfinite(f) else None
