"""Exact contacts by an active-set Newton method in float64.

It uses NumPy and SciPy only and nothing of the package's solvers.

From a guess of the elastic points C and of those that yield, the pressure follows from a linear
problem on C (if it is small) or on the rest F, solved by conjugate gradients that are
preconditioned by the inverse operator. Points that violate the bounds of their set change it. If
the sets repeat, projected gradients of the dual problem, which always converge, are taken in
between. Without a hardness no point yields.

Units are those of operators/problem.py: lengths in a = sqrt(a_x a_y), heights in g_rms a, pressures
in E* g_rms, so that K = |q|/2 and p0 is p*.

With free edges, S between two points is that of a periodic cell minus its images, which are summed
by rows independently of the package, and K is its inverse. (q is rounded near the end of axes with
free edges, and tests/physics/test_free.py computes S by quadrature.)
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import fft, optimize, special

SIGN = 1e-13  # relative violation of a sign that counts as rounding error
# Relative pressure or gap below which a point could also be on the other side: half of what a truth
# may violate its own conditions by (DOUBTFUL).
TIE = 1e-8
ROUGH = 1e-4  # relative residual of the first linear problems
INNER = 1e-13  # and of the last ones
BOUND = 1e-12  # relative distance to the hardness at which a point yields
PATIENCE = 4  # rounds in which the number of wrong points may fail to decrease
EPS = 2e-14  # relative rounding errors of transforms, with a margin
ABOVE_LOADS = 1.1  # smallest hardness over the largest load
# Violation of its own conditions above which a truth is rejected: 2 % of the smallest accuracy that
# is judged. Rounding errors of K h alone make 1e-8 at p* = 1e-7.
DOUBTFUL = 2e-8
FEW = 30  # number of wrong points up to which they may change one at a time
MURTY = 60  # rounds in which they do
ROUNDS = 250  # linear problems
FIRST_STEPS = 30  # of projected gradients before the first linear problem
MORE_STEPS = 20  # when active sets repeat; twice as many each time
MOST_STEPS = 1500
ROUNDED = 0.055  # width over which the kink of |q| is rounded along free axes, over 1/a


@dataclass(frozen=True)
class Truth:
    """The exact solution of a load.

    Attributes
    ----------
    pressure : ndarray
        In units of E* g_rms.
    contact : int
        Points in contact.
    gap_mean : float
        In units of g_rms a.
    ties_in, ties_out : int
        Points of C and of F that could also be on the other side.
    kkt : float
        Largest relative violation of p = p0 + K u, g = u + h, p >= 0, g >= 0, mean p = p0.
    gap : ndarray
        In units of g_rms a, below 0 in dents.
    """

    pressure: np.ndarray
    contact: int
    gap_mean: float
    ties_in: int
    ties_out: int
    kkt: float
    gap: np.ndarray

    def errors(self, contact, gap_mean, pressure):
        """Return the true relative errors of area, mean gap and pressure field (L2) of a solution
        in the units of the truth. Ties do not count as errors of the area."""
        too_many = contact - self.contact - self.ties_out
        too_few = self.contact - self.ties_in - contact
        points = max(too_many, too_few, 0)
        gap_error = abs(gap_mean - self.gap_mean)
        if self.gap_mean:
            gap_error = gap_error / self.gap_mean
        elif gap_error:
            gap_error = np.inf
        with np.errstate(over="ignore", invalid="ignore"):
            p_error = np.linalg.norm(pressure - self.pressure) / np.linalg.norm(self.pressure)
        p_error = float(p_error) if np.isfinite(p_error) else np.inf
        return points / self.contact, float(gap_error), p_error


class Contact:
    """The contact of a wall.

    Along axes with free edges the grid is twice as long, nothing touches beyond the wall, and K is
    the inverse of S in free space.

    Parameters
    ----------
    z : ndarray
        Heights, peaks up.
    sizes : (float, float)
        Size of the cell.
    free : (bool, bool)
        Whether x and y have free edges.

    Attributes
    ----------
    K, S : ndarray
        Stiffness and compliance in Fourier space.
    h : ndarray
        Initial gap on the grid, in units of g_rms a.
    D : ndarray of bool
        Points of the wall.
    N : int
        Their number.
    g_rms, height_unit : float
        rms slope, and g_rms a, in the units of the wall.
    """

    def __init__(self, z, sizes, free=(False, False)):
        self.shape = z.shape
        spacings = np.array(sizes, float) / z.shape
        a = np.sqrt(spacings[0]) * np.sqrt(spacings[1])
        self.n = tuple(n * (1 + ends) for n, ends in zip(z.shape, free))
        if any(free):
            self.S = _compliance(z.shape, tuple(map(float, sizes)), tuple(map(bool, free)))
            self.K = np.divide(1, self.S, out=np.zeros_like(self.S), where=self.S != 0)
        else:
            q_x = 2 * np.pi * fft.fftfreq(self.n[0]) * (a / spacings[0])
            q_y = 2 * np.pi * fft.rfftfreq(self.n[1]) * (a / spacings[1])
            self.K = np.hypot(q_x[:, None], q_y) / 2
            self.S = np.divide(1, self.K, out=np.zeros_like(self.K), where=self.K > 0)
        h = np.max(z) - np.asarray(z, float)
        scale = h.max()
        h = h / scale
        g_rms = _slope(h, spacings / a) if any(free) else _spectral_slope(h, self.K)
        self.D = np.zeros(self.n, bool)
        self.D[: z.shape[0], : z.shape[1]] = True
        self.N = z.size
        self.h = np.zeros(self.n)
        self.h[self.D] = (h / g_rms).ravel()
        self.height_unit = scale * g_rms  # = g_rms a in the scene's units
        self.g_rms = self.height_unit / a

    def errors_of(self, solution, truth, modulus):
        """Return the true errors of (area, mean gap, pressure) of an hpc_gfmd.Solution.

        modulus: E*, in the units of the solution.
        """
        points = round(solution.a_r * self.N)
        with np.errstate(all="ignore"):
            pressure = np.asarray(solution.pressure, np.float64) / modulus / self.g_rms
            return truth.errors(points, solution.gap_mean / self.height_unit, pressure)

    def times(self, multiplier, x):
        """Return a field multiplied in Fourier space."""
        return fft.irfft2(multiplier * fft.rfft2(x), s=self.n)

    def solve(self, p_star, start=None, hardness=None):
        """Return the exact solution of a load, from the pressure of a similar one if there is a
        start; the hardness is in units of p*."""
        limit = np.inf if hardness is None else hardness
        p = self.D * p_star if start is None else self.on_cell(start)
        p = self._dual_gradients(p, p_star, limit, FIRST_STEPS)
        elastic, yielded = self._sets(p, limit)
        fewest = np.inf
        waits = 0
        steps = MORE_STEPS
        inner = ROUGH
        for _ in range(ROUNDS):
            p, g = self._linear(elastic, yielded, p, p_star, limit, inner)
            tiny_p = SIGN * p.max()
            tiny_g = SIGN * self.h.max()
            to_open = elastic & (p < -tiny_p)
            to_yielded = elastic & (p > limit + tiny_p)
            to_elastic = self.D & ~elastic & np.where(yielded, g > tiny_g, g < -tiny_g)
            wrong = to_open | to_yielded | to_elastic
            count = int(wrong.sum())
            if count == 0 and inner == INNER:
                break
            if count <= FEW or waits:
                inner = INNER
            if count < fewest:
                fewest = count
                waits = 0
            else:
                waits += 1
            if waits >= PATIENCE and count <= FEW and waits < MURTY:
                # Only the last point changes (Murty), so that active sets do not repeat.
                wrong.ravel()[np.flatnonzero(wrong)[:-1]] = False
            elif waits >= PATIENCE:
                p = self._within_bounds(p, elastic, yielded, limit)
                p = self._dual_gradients(p, p_star, limit, steps)
                elastic, yielded = self._sets(p, limit)
                fewest = np.inf
                waits = 0
                steps = min(2 * steps, MOST_STEPS)
                continue
            yielded = (yielded & ~wrong) | (to_yielded & wrong)
            elastic = (elastic & ~wrong) | (to_elastic & wrong)
            if not (elastic.any() or yielded.any()):
                elastic = self.D & (g <= g[self.D].min())
        p = self._within_bounds(p, elastic, yielded, limit)
        return self._truth(p, g, elastic, yielded, p_star, count == 0)

    def _sets(self, p, limit):
        """Return the elastic and the yielding points of a pressure between its bounds."""
        yielded = self.D & (p >= limit * (1 - BOUND))
        return (p > 0) & ~yielded, yielded

    @staticmethod
    def _within_bounds(p, elastic, yielded, limit):
        """Return p, clipped on elastic points, the limit on yielding ones and 0 on others."""
        return np.where(yielded, limit, np.where(elastic, np.clip(p, 0, limit), 0))

    def _truth(self, p, g, elastic, yielded, p_star, is_settled):
        """Return the Truth of a pressure, a gap and the sets of points to which they belong.

        is_settled: whether no point has the wrong sign.
        """
        D = self.D
        exact = np.where(elastic, 0, np.where(yielded, np.minimum(g, 0), np.maximum(g, 0)))
        exact = np.where(D, exact, g)
        p_rms = np.sqrt(np.sum(p * p) / self.N)
        gap_mean = np.maximum(exact[D], 0).mean()
        kkt = max(
            self._violation(p, exact, elastic, yielded, p_star),
            abs(p.sum() / (self.N * p_star) - 1),
            float(not is_settled),
        )
        is_open = D & ~elastic & ~yielded
        return Truth(
            pressure=p[D].reshape(self.shape),
            contact=int(elastic.sum() + yielded.sum()),
            gap_mean=float(gap_mean),
            ties_in=int(np.sum(elastic & (p < TIE * p_rms))),
            ties_out=int(np.sum(is_open & (exact < TIE * max(gap_mean, 1e-6 * self.h.max())))),
            kkt=float(kkt),
            gap=exact[D].reshape(self.shape),
        )

    def _violation(self, p, g, elastic, yielded, p_star):
        """Return the relative violation (L2) of p = p0 + K (g - h) or, where it is less, that of
        the signs of the gap S p + h times the stiffest K.

        Without rounding the second is never less than the first. Rounding errors of K h spoil the
        first where p is small, those of S p the second where nearly all is closed.
        """
        size = np.linalg.norm(p)
        fresh = p_star * (self.N / self.h.size) + self.times(self.K, g - self.h)
        in_pressure = np.linalg.norm(fresh - p) / size
        if not elastic.any():
            return in_pressure
        gap = self.times(self.S, p) + (self.h - self.h[elastic].mean())
        gap -= gap[elastic].mean()
        allowed = np.where(elastic, 0, np.where(yielded, np.minimum(gap, 0), np.maximum(gap, 0)))
        wrong_gap = np.linalg.norm((gap - allowed)[self.D])
        return min(in_pressure, wrong_gap * self.K.max() / size)

    def _linear(self, elastic, yielded, p, p_star, limit, inner):
        """Return pressure and gap for given elastic and yielding points; the others are open.

        The linear problem on the smaller set is solved.
        """
        carried = np.where(yielded, limit, 0.0)
        if elastic.any() and elastic.sum() <= 0.5 * self.h.size:
            return self._closed(elastic, p, p_star, inner, carried)
        return self._open(elastic, p_star, inner, carried)

    def _dual_gradients(self, p, p_star, limit, steps):
        """Take accelerated projected gradient steps (FISTA with restarts) for the pressure.

        It is between 0 and the limit and has the mean p*.
        """
        step = 1 / self.S.max()
        inertia = 1.0
        p = self._projected_on_bounds(p, p_star, limit)
        y = p
        for _ in range(steps):
            new = self._projected_on_bounds(
                y - step * (self.times(self.S, y) + self.h), p_star, limit
            )
            following = (1 + np.sqrt(1 + 4 * inertia**2)) / 2
            if np.sum((y - new) * (new - p)) > 0:
                following = 1.0
                y = new
            else:
                y = new + (inertia - 1) / following * (new - p)
            p = new
            inertia = following
        return p

    def _projected_on_bounds(self, p, p_star, limit):
        """Shift p and clip it to 0 and the limit so that its mean is p*."""
        inside = p[self.D]
        low = -inside.max()
        high = 2 * p_star - inside.min()
        shift = optimize.brentq(
            lambda shift: np.clip(inside + shift, 0, limit).mean() - p_star,
            low,
            high,
            xtol=EPS * (high - low),
        )
        return np.where(self.D, np.clip(p + shift, 0, limit), 0)

    def on_cell(self, field):
        """Return a field of the wall, surrounded by zeros."""
        out = np.zeros(self.n)
        out[self.D] = field.ravel()
        return out

    def _closed(self, C, p, p_star, inner, carried):
        """Return pressure and gap from the linear problem on C: S p + u0 + h = 0, mean p = p_star.

        carried: pressure of points that are not in C.
        """
        N = self.N
        n_c = int(C.sum())
        load = N * p_star - np.sum(carried)

        def apply(x):
            y = np.where(C, self.times(self.S, x), 0)
            return np.where(C, y - y.sum() / n_c, 0)

        def precondition(x):
            y = np.where(C, self.times(self.K, x) + self.floor * x, 0)
            return np.where(C, y - y.sum() / n_c, 0)

        p = np.where(C, p, 0)
        p = np.where(C, p + (load - p.sum()) / n_c, carried)
        if n_c > 1:
            u = self.times(self.S, p)
            h = self.h - self.h[C].mean()
            b = np.where(C, -(u + h), 0)
            b = np.where(C, b - b.sum() / n_c, 0)
            rounding = EPS * np.hypot(np.linalg.norm(h[C]), np.linalg.norm(u[C]))
            p = p + _conjugate_gradients(apply, precondition, b, 4 * n_c, inner, rounding)
            p = np.where(C, p + (N * p_star - p.sum()) / n_c, carried)
        # The depth that the points in contact have in common is left out of every sum.
        g = self.times(self.S, p) + (self.h - self.h[C].mean())
        g -= g[C].mean()
        return p, g

    @property
    def floor(self):
        """Multiple of the identity in the preconditioner, because K loses the mean."""
        return 0.5 * self.K[self.K > 0].min()

    def _open(self, C, p_star, inner, carried):
        """Return pressure and gap from the linear problem on F: K g + p_star - K h = carried."""
        F = ~C
        b = p_star * (self.N / self.h.size) - self.times(self.K, self.h)
        b = b - carried
        g = np.zeros(self.n)
        if F.any():
            mean = 1 / self.K[self.K > 0].min()

            def precondition(x):
                return np.where(F, self.times(self.S, x) + mean * x.mean(), 0)

            def apply(x):
                return np.where(F, self.times(self.K, x), 0)

            g = _conjugate_gradients(
                apply, precondition, np.where(F, -b, 0), 4 * int(F.sum()), inner, 0.0
            )
        p = b + carried + self.times(self.K, g)
        return p, g


@lru_cache(maxsize=8)
def _compliance(n, sizes, free):
    """Return the transform of S between points of a wall with free edges, 0 for the translation.

    The grid is twice as long along free axes. S is that of a larger periodic cell minus its images,
    which are far away in units of both spacings.
    """
    spacings = np.divide(sizes, n)
    spacings /= np.sqrt(spacings.prod())
    cell = [
        2 * k + 128 + int(8 * max(spacings) / s) if ends else k
        for k, s, ends in zip(n, spacings, free)
    ]
    q_x, q_y = (
        np.pi - ROUNDED * _even_mean((np.pi - q) / ROUNDED) if ends else q
        for q, ends in zip(
            (abs(2 * np.pi * fft.fftfreq(cell[0])), 2 * np.pi * fft.rfftfreq(cell[1])), free
        )
    )
    q = np.hypot(q_x[:, None] / spacings[0], q_y / spacings[1])
    periodic = fft.irfft2(np.divide(2, q, out=np.zeros_like(q), where=q > 0), cell)
    i, j = (
        np.minimum(np.arange(m), m - np.arange(m))
        for m in (k * (1 + ends) for k, ends in zip(n, free))
    )
    x = i * spacings[0]
    y = j * spacings[1]
    X, Y = cell * spacings
    if all(free):
        images = (
            _row(x, y, Y) + _other_rows(x, y, X, Y)
            if X > Y
            else (_row(y, x, X) + _other_rows(y, x, Y, X)).T
        )
    else:
        images = _other_rows(x, y, X, Y) if free[0] else _other_rows(y, x, Y, X).T
    S = fft.rfft2(periodic[np.ix_(i, j)] - images).real
    S[0, 0] = 0
    return S


def _even_mean(t):
    """Return the mean of |t + x| for a normally distributed x."""
    return t * (2 * special.ndtr(t) - 1) + np.sqrt(2 / np.pi) * np.exp(-t * t / 2)


def _row(x, y, Y):
    """Return the displacement by unit forces at (0, jY), j not 0, except for a constant.

    The sum up to J is continued by the Euler-Maclaurin formula.
    """
    total = 0.0
    J = 200
    for sign in (-1, 1):
        a = np.arange(1, J + 1)[:, None, None] * Y + sign * y
        r = np.hypot(x[:, None], a)
        total = (
            total
            + np.sum(1 / r, axis=0)
            - 1 / r[-1] / 2
            - np.log(a[-1] + r[-1]) / Y
            + Y * a[-1] / r[-1] ** 3 / 12
        )
    return total / np.pi


def _other_rows(x, y, X, Y):
    """Return the displacement by unit forces at (iX, jY), i not 0, with Poisson's sum over j."""
    rows, waves = (np.arange(1, 2 + int(6 * ratio)) for ratio in (1 + Y / X, 1 + Y / (X - x.max())))
    q = 2 * np.pi / Y * waves
    distances = np.abs(x[:, None] - X * np.concatenate([-rows, rows]))
    coupled = 4 * special.k0(distances[..., None] * q).sum(axis=1) @ np.cos(np.outer(q, y))
    return (coupled - 2 * np.log(2 * np.pi / X * np.sinc(x / X))[:, None]) / (np.pi * Y)


def _spectral_slope(h, K):
    """Return the rms slope of the Fourier series; K is |q|/2."""
    weight = np.full(K.shape[1], 2.0)
    weight[0] = 1
    if h.shape[1] % 2 == 0:
        weight[-1] = 1
    return np.sqrt(np.sum(weight * np.abs(fft.rfft2(h) / h.size) ** 2 * (2 * K) ** 2))


def _slope(h, spacings):
    """Return the rms slope between neighbouring points."""
    return np.sqrt(
        sum(
            np.mean((np.diff(h, axis=axis) / s) ** 2)
            for axis, s in enumerate(spacings)
            if h.shape[axis] > 1
        )
    )


def _conjugate_gradients(apply, precondition, b, max_steps, relative, absolute):
    """Return the solution of apply(x) = b to a relative or an absolute residual (L2).

    They end where rounding errors make the operator lose its sign, which scipy's do not.
    """
    x = np.zeros_like(b)
    r = b
    size = np.sqrt(np.sum(b * b))
    if size <= absolute:
        return x
    z = precondition(r)
    d = z
    rz = float(np.sum(r * z))
    if not rz > 0:
        return x
    for _ in range(min(max_steps, 2000)):
        Kd = apply(d)
        dKd = float(np.sum(d * Kd))
        if not dKd > 0:
            break
        x = x + (rz / dKd) * d
        r = r - (rz / dKd) * Kd
        if np.sqrt(np.sum(r * r)) < max(relative * size, absolute):
            break
        z = precondition(r)
        new = float(np.sum(r * z))
        if not new > 0:
            break
        d = z + (new / rz) * d
        rz = new
    return x


def truths(z, sizes, loads, free=(False, False), hardness=None, hardness_star=None):
    """Return the contact, the truths of its loads in the order of solving and the hardness in units
    of p*, None without one.

    The hardness is given in units of p* (hardness_star), or over the largest pressure of the loads
    without one, but at least ABOVE_LOADS times the largest load.
    """
    contact = Contact(z, sizes, free)
    if hardness_star is not None:
        return contact, _in_turn(contact, loads, hardness_star), hardness_star
    elastic = _in_turn(contact, loads)
    if hardness is None:
        return contact, elastic, None
    largest_pressure = max(truth.pressure.max() for truth in elastic)
    hardness = float(max(hardness * largest_pressure, ABOVE_LOADS * max(loads)))
    return contact, _in_turn(contact, loads, hardness), hardness


def _in_turn(contact, loads, *hardness):
    """Return the truths of the loads, each from the one before if both are near."""
    exact = []
    start = None
    for p_star in loads:
        is_near = start is not None and 0.5 < p_star / start.mean() < 2 and not hardness
        truth = contact.solve(p_star, start if is_near else None, *hardness)
        if is_near and not truth.kkt < DOUBTFUL:
            truth = contact.solve(p_star)
        start = truth.pressure
        exact.append(truth)
    return exact
