"""The family of adhesive walls at prescribed mean gaps, many of them symmetric.

Their truth is the smallest eigenvalue of dense matrices, which tells a stable state from a saddle.
"""

import numpy as np
from scipy.linalg import eigh, null_space

import hpc_gfmd
from hpc_gfmd.laws import law_named

from .registry import Wall, family, outcome
from .shapes import choice, log_uniform
from .sticky_walls import Attraction

SIDES = (6, 8, 9, 12, 16, 20, 24)
UNSTABLE = -1e-3  # a stability below this is that of a saddle
DIFFERENCE = 1e-5  # of the gap for the curvature of the law, over its range


@family
def sticky_gap(rng):
    n = choice(rng, SIDES)
    x = np.arange(n) / n - 0.5
    z = {
        "cylinder": -np.add.outer(x * x, 0 * x),
        "ball": -np.add.outer(x * x, x * x),
        "wave": np.add.outer(np.cos(2 * np.pi * x), np.cos(2 * np.pi * x)),
        "groove": -np.add.outer(0 * x, 1.0 * (x < -1 / 6)),
        "noise": rng.standard_normal((n, n)),
    }[choice(rng, ("cylinder", "ball", "wave", "groove", "noise"))]
    z = z * log_uniform(rng, 3e-3, 0.3) / np.ptp(z)
    z = z + choice(rng, (0, 0, 1e-8, 1e-3)) * np.ptp(z) * rng.standard_normal(z.shape)
    # reach is over the height of the wall here
    gap = log_uniform(rng, 0.03, 0.95) * (z.max() - z.mean()) / z.std()
    law = choice(rng, ("exponential", "exponential", "cubic", "dugdale"))
    attraction = Attraction(log_uniform(rng, 0.2, 12), log_uniform(rng, 0.05, 2), law)
    return Wall(
        z,
        (1.0, 1.0),
        (),
        units=False,
        attraction=attraction,
        targets=("gap_over_h_rms", (gap,)),
        judge=judged_gaps,
    )


def judged_gaps(wall, way):
    """Yield (number of the gap, columns) of each prescribed gap.

    At a saddle the true error of the area is infinite; that of the gap is by how much it is missed.
    """
    quantity, values = wall.targets
    reach = wall.attraction.reach * np.ptp(wall.heights)
    law = law_named(wall.attraction.law, wall.attraction.kappa * np.pi * reach**2, reach)
    adhesion = {"work": law.work, "range": law.range, "law": wall.attraction.law}
    accuracy = way["accuracy"]
    for number, value in enumerate(values):
        solution = hpc_gfmd.solve(
            wall.heights,
            boundary="periodic",
            adhesion=adhesion,
            precision=way["precision"],
            accuracy=accuracy,
            **{quantity: value},
        )
        is_saddle = least_stability(solution, law) < UNSTABLE
        missed = abs(solution.gap_mean / wall.heights.std() / value - 1)
        true = (np.inf if is_saddle else 0.0, missed, 0.0)
        points = round(solution.a_r * wall.heights.size)
        # the gap is prescribed: it may be missed by the accuracy
        claimed = (0.0, accuracy, 0.0)
        yield number, outcome(solution, points, true, claimed)


def least_stability(solution, law):
    """Return the smallest eigenvalue of K + phi'' with respect to K on the open points, at a fixed
    mean gap."""
    n = solution.pressure.shape[0]
    is_open = np.asarray(solution.pressure).ravel() == 0
    if is_open.sum() < 2:
        return 1.0
    q = 2 * np.pi * n * np.fft.fftfreq(n)
    row = np.fft.ifft2(np.hypot(q[:, None], q) / 2).real
    i = np.arange(n)
    apart = (i[:, None] - i) % n
    K = row[apart[:, None, :, None], apart[None, :, None, :]].reshape(n * n, n * n)
    K = K[np.ix_(is_open, is_open)]
    gap = np.asarray(solution.gap, float).ravel()[is_open]
    near = np.maximum(gap - DIFFERENCE * law.range, 0)
    far = gap + DIFFERENCE * law.range
    curvature = (law.traction(far) - law.traction(near)) / (far - near)
    fixed = null_space(np.ones((1, len(gap))))
    softened = fixed.T @ (K + np.diag(curvature)) @ fixed
    return float(eigh(softened, fixed.T @ K @ fixed, eigvals_only=True)[0])
