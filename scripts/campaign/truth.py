"""Exact contacts by an active-set Newton method in float64, NumPy and scipy.fft only: nothing of
the package's solvers is used here.

Guess the contact C. Its pressure follows from a linear problem on C (few points touch) or on the
rest F (most touch), each by conjugate gradients preconditioned by the inverse operator; points of
the wrong sign change sides. Where that goes round in circles, steps of projected conjugate
gradients (Polonsky and Keer) lie between, which always converge. Units: those of
operators/problem.py: lengths in a = sqrt(a_x a_y), heights in g_rms a, pressures in E* g_rms, so
that K = |q|/2 and p0 is p*. With free edges the S between two points that makes the discrete
problem is that of a periodic cell (q rounded near the end of an axis that ends) less its images, by
sums over rows of images of its own (tests/physics/test_free.py has S by quadrature), and K its
inverse.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import fft, special

SIGN = 1e-13  # relative: a violation smaller than that is rounding
TIE = 1e-9  # of the rms pressure or of the gap: closer than this to changing sides is a tie
ROUGH, INNER = 1e-4, 1e-13  # relative residual of the linear problems, first and in the end
BOUND = 1e-12  # relative: a pressure as near to the hardness yields
PATIENCE = 4  # rounds without fewer points on the wrong side
EPS = 2e-14  # relative rounding errors of a transform, and more
DOUBTFUL = 1e-10  # a truth that violates its own conditions by more than this is none
FEW = 30  # points on the wrong side of which one at a time may change
MURTY = 60  # times that this is tried
ROUNDS = 250
# width of the kink of |q| where the wave numbers of an axis that ends are rounded, over 1/a: part
# of the discretisation
ROUNDED = 0.055


@dataclass(frozen=True)
class Truth:
    """pressure (in p0 = p* units); contact: points; gap_mean; ties_in, ties_out: points of C and of
    F that are as good on the other side; kkt: the largest violation of p = p0 + K u, g = u + h, p
    >= 0, g >= 0, mean p = p0, relative; rounds: linear problems."""

    pressure: np.ndarray
    contact: int
    gap_mean: float
    ties_in: int
    ties_out: int
    kkt: float
    rounds: int

    def errors(self, contact, gap_mean, pressure):
        """Compute the true relative errors of area, mean gap and pressure field (L2), ties and the
        last digits of the gap left out."""
        over = max(contact - self.contact - self.ties_out, self.contact - self.ties_in - contact, 0)
        off = abs(gap_mean - self.gap_mean)
        gap = off / self.gap_mean if self.gap_mean else (np.inf if off else 0.0)
        with np.errstate(over="ignore", invalid="ignore"):
            p = np.linalg.norm(pressure - self.pressure) / np.linalg.norm(self.pressure)
        return over / self.contact, float(gap), float(p) if np.isfinite(p) else np.inf


class Contact:
    """A wall: heights z (peaks up) in a cell of physical sizes. free: whether it ends along x,
    along y; the grid is then twice as long, nothing touches beyond the wall, and K is the inverse
    of S in free space. D: the points of the wall, N of them."""

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

    def times(self, multiplier, x):
        return fft.irfft2(multiplier * fft.rfft2(x), s=self.n)

    def solve(self, p_star, start=None, hardness=None):
        """Find the Truth at p*. start: the pressure of a similar load, without a hardness (unit of
        p*)."""
        if hardness is not None:
            return self._yielding(p_star, hardness)
        h, D, N = self.h, self.D, self.N
        if start is None:
            p = self._projected(1.0 * D, p_star, 12)
        else:
            p = self._projected(self.on_cell(start), p_star, 3)
        C = p > 0
        best, waits, patience, inner = np.inf, 0, 4, ROUGH
        for rounds in range(1, ROUNDS):  # noqa: B007
            nearly_closed = C.sum() > 0.5 * h.size
            p, g = (self._open if nearly_closed else self._closed)(C, p, p_star, inner)
            p_rms = np.sqrt(np.sum(p * p) / N)
            tiny_p, tiny_g = SIGN * max(p_rms, p_star), SIGN * h.max()
            wrong = np.where(C, p < -tiny_p, D & (g < -tiny_g))
            count = int(wrong.sum())
            if count == 0 and inner == INNER:
                break
            if count <= FEW or waits:
                inner = INNER
            if count < best:
                best, waits = count, 0
            else:
                waits += 1
            if waits >= patience and count <= FEW and waits < MURTY:
                wrong.ravel()[np.flatnonzero(wrong)[:-1]] = (
                    False  # the last one alone (Murty): no circles
                )
            elif waits >= patience:
                p = self._projected(np.where(C, np.maximum(p, 0), 0), p_star, 10 * patience)
                C = p > 0
                best, waits, patience = np.inf, 0, min(2 * patience, 64)
                continue
            C = C ^ wrong
            if not C.any():
                C = D & (g <= g[D].min())
        p, g = np.where(C, np.maximum(p, 0), 0), np.where(C, 0, np.where(D, np.maximum(g, 0), g))
        p_rms, gap_mean = np.sqrt(np.sum(p * p) / N), g[D].mean()
        kkt = max(
            self._violation(p, g, C, np.zeros_like(C), p_star),
            abs(p.sum() / (N * p_star) - 1),
            float(count > 0),
        )
        ties_in = int(np.sum(C & (p < TIE * p_rms)))
        ties_out = int(np.sum(D & ~C & (g < TIE * max(gap_mean, 1e-6 * h.max()))))
        return Truth(
            p[D].reshape(self.shape),
            int(C.sum()),
            float(gap_mean),
            ties_in,
            ties_out,
            float(kkt),
            rounds,
        )

    def _yielding(self, p_star, hardness):
        """Find the Truth where a hardness limits the pressure, by an active set of three states.

        Guess which points are elastic and which yield. That gives a linear problem; points that
        violate the bounds of their state change it. Where this goes round in circles, projected
        gradients of the dual problem lie between, which always converge.
        """
        h, D, N = self.h, self.D, self.N
        p = self._dual_gradients(D * p_star, p_star, hardness, 30)
        yielded = D & (p >= hardness * (1 - BOUND))
        elastic = (p > 0) & ~yielded
        fewest, waits, steps, inner = np.inf, 0, 20, ROUGH
        for rounds in range(1, ROUNDS):  # noqa: B007
            p, g = self._with_yielded(elastic, yielded, p, p_star, hardness, inner)
            tiny_p, tiny_g = SIGN * hardness, SIGN * h.max()
            to_open = elastic & (p < -tiny_p)
            to_yielded = elastic & (p > hardness + tiny_p)
            to_elastic = D & ~elastic & np.where(yielded, g > tiny_g, g < -tiny_g)
            wrong = to_open | to_yielded | to_elastic
            count = int(wrong.sum())
            if count == 0 and inner == INNER:
                break
            if count <= FEW or waits:
                inner = INNER
            if count < fewest:
                fewest, waits = count, 0
            else:
                waits += 1
            if waits >= PATIENCE and count <= FEW and waits < MURTY:
                wrong.ravel()[np.flatnonzero(wrong)[:-1]] = False  # the last one alone: no circles
            elif waits >= PATIENCE:
                p = np.where(yielded, hardness, np.where(elastic, np.clip(p, 0, hardness), 0))
                p = self._dual_gradients(p, p_star, hardness, steps)
                yielded = D & (p >= hardness * (1 - BOUND))
                elastic = (p > 0) & ~yielded
                fewest, waits, steps = np.inf, 0, min(2 * steps, 1500)
                continue
            yielded = (yielded & ~wrong) | (to_yielded & wrong)
            elastic = (elastic & ~wrong) | (to_elastic & wrong)
        p = np.where(yielded, hardness, np.where(elastic, np.clip(p, 0, hardness), 0))
        exact = np.where(elastic, 0, np.where(yielded, np.minimum(g, 0), np.maximum(g, 0)))
        exact = np.where(D, exact, g)
        p_rms, gap_mean = np.sqrt(np.sum(p * p) / N), np.maximum(exact[D], 0).mean()
        kkt = max(
            self._violation(p, exact, elastic, yielded, p_star),
            abs(p.sum() / (N * p_star) - 1),
            float(count > 0),
        )
        ties_in = int(np.sum(elastic & (p < TIE * p_rms)))
        is_open = D & ~elastic & ~yielded
        ties_out = int(np.sum(is_open & (exact < TIE * max(gap_mean, 1e-6 * h.max()))))
        touching = int(elastic.sum() + yielded.sum())
        field = p[D].reshape(self.shape)
        return Truth(field, touching, float(gap_mean), ties_in, ties_out, float(kkt), rounds)

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

    def _with_yielded(self, elastic, yielded, p, p_star, hardness, inner):
        """Find pressure and gap where these points are elastic, those yield, and the others are
        open, from the linear problem on the smaller side."""
        carried = yielded * hardness
        if elastic.any() and elastic.sum() <= 0.5 * self.h.size:
            return self._closed(elastic, p, p_star, inner, carried)
        return self._open(elastic, p, p_star, inner, carried)

    def _dual_gradients(self, p, p_star, hardness, steps):
        """Take accelerated projected gradient steps (FISTA with restarts) for the pressure between
        0 and the hardness, of the mean p*."""
        step, inertia = 1 / self.S.max(), 1.0
        p = self._projected_on_bounds(p, p_star, hardness)
        y = p
        for _ in range(steps):
            new = self._projected_on_bounds(
                y - step * (self.times(self.S, y) + self.h), p_star, hardness
            )
            following = (1 + np.sqrt(1 + 4 * inertia**2)) / 2
            if np.sum((y - new) * (new - p)) > 0:
                following = 1.0
                y = new
            else:
                y = new + (inertia - 1) / following * (new - p)
            p, inertia = new, following
        return p

    def _projected_on_bounds(self, p, p_star, hardness):
        """Shift p and cut it off at 0 and the hardness such that its mean is p*."""
        low, high = -p.max(), hardness - p[self.D].min()
        for _ in range(80):
            middle = 0.5 * (low + high)
            if np.clip(p[self.D] + middle, 0, hardness).mean() < p_star:
                low = middle
            else:
                high = middle
        return np.where(self.D, np.clip(p + 0.5 * (low + high), 0, hardness), 0)

    def on_cell(self, field):
        """Put zeros around a field of the wall."""
        out = np.zeros(self.n)
        out[self.D] = field.ravel()
        return out

    def _closed(self, C, p, p_star, inner, carried=0.0):
        """Find pressure on C and gap from the linear problem g = 0 on C with mean p = p_star: S p +
        u0 + h = 0 there. carried: pressure of points that are not in C."""
        N, n_c = self.N, int(C.sum())
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
        """A little of the identity in the preconditioner: K alone forgets the mean."""
        return 0.5 * self.K[self.K > 0].min()

    def _open(self, C, p, p_star, inner, carried=0.0):
        """Find gap on F and pressure from the linear problem p = 0, or what is carried, on F: K g +
        p_star - K h = 0 there."""
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

    def _projected(self, p, p_star, steps):
        """Take steps of Polonsky and Keer's conjugate gradients for the pressure, preconditioned by
        nothing: robust, slow at the end."""
        S, h = self.S, self.h
        N = self.N
        p = p * (N * p_star / p.sum())
        t, old, fresh = np.zeros_like(p), 1.0, True
        for _ in range(steps):
            g = self.times(S, p) + h
            C = p > 0
            g -= g[C].mean()
            new = float(np.sum(g[C] ** 2))
            if new == 0:
                break
            t = np.where(C, g + (0 if fresh else new / old) * t, 0)
            r = self.times(S, t)
            r -= r[C].mean()
            curvature = float(np.sum(r[C] * t[C]))
            if curvature <= 0:
                break
            step = float(np.sum(g[C] * t[C])) / curvature
            p = np.maximum(np.where(C, p - step * t, p), 0)
            late = self.D & (p == 0) & (g < 0)
            p[late] -= step * g[late]
            fresh = bool(late.any())
            old = new
            if not p.any():  # too long a step: on the highest point alone
                p[np.unravel_index(np.argmin(np.where(self.D, g, np.inf)), p.shape)] = 1.0
                fresh = True
            p *= N * p_star / p.sum()
        return p


@lru_cache(maxsize=8)
def _compliance(n, sizes, free):
    """Make the transform of S between points of a wall that ends, on a cell twice as long; 0 for a
    rigid translation. Of a larger cell, the images in which are far in units of either spacing."""
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
    (x, y), (X, Y) = (k * s for k, s in zip((i, j), spacings)), cell * spacings
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
    """Average |t + a normally distributed number|."""
    return t * (2 * special.ndtr(t) - 1) + np.sqrt(2 / np.pi) * np.exp(-t * t / 2)


def _row(x, y, Y):
    """Compute the displacement by unit forces at (0, jY), j not 0, but for a constant: the sum to
    J, and the rest by Euler and Maclaurin."""
    total, J = 0.0, 200
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
    """Compute the displacement by unit forces at (iX, jY), i not 0, all j, by Poisson's sum over
    j."""
    rows, waves = (np.arange(1, 2 + int(6 * ratio)) for ratio in (1 + Y / X, 1 + Y / (X - x.max())))
    q = 2 * np.pi / Y * waves
    distances = np.abs(x[:, None] - X * np.concatenate([-rows, rows]))
    coupled = 4 * special.k0(distances[..., None] * q).sum(axis=1) @ np.cos(np.outer(q, y))
    return (coupled - 2 * np.log(2 * np.pi / X * np.sinc(x / X))[:, None]) / (np.pi * Y)


def _spectral_slope(h, K):
    """Compute the rms slope of the Fourier series; K: |q|/2."""
    weight = np.full(K.shape[1], 2.0)
    weight[0] = 1
    if h.shape[1] % 2 == 0:
        weight[-1] = 1
    return np.sqrt(np.sum(weight * np.abs(fft.rfft2(h) / h.size) ** 2 * (2 * K) ** 2))


def _slope(h, spacings):
    """Compute the rms slope between neighbouring points."""
    return np.sqrt(
        sum(
            np.mean((np.diff(h, axis=axis) / s) ** 2)
            for axis, s in enumerate(spacings)
            if h.shape[axis] > 1
        )
    )


def _conjugate_gradients(apply, precondition, b, most, relative, absolute):
    x, r = np.zeros_like(b), b
    size = np.sqrt(np.sum(b * b))
    if size <= absolute:
        return x
    z = precondition(r)
    d, rz = z, float(np.sum(r * z))
    if not rz > 0:
        return x
    for _ in range(min(most, 2000)):
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
        d, rz = z + (new / rz) * d, new
    return x
