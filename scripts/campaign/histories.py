"""Families of small walls whose loads follow from each other: dents that stay, bodies that relax.

Loads or mean gaps rise, fall, return to 0 and are held; times stand still at jumps. Each step is
compared with the exact contact on the exact wall of the steps before.
"""

from functools import partial

import numpy as np

import hpc_gfmd

from .registry import Wall, compared, family, keywords, outcome
from .shapes import choice, log_uniform, rough, square_pixels
from .table import SLACK
from .truth import Contact

LARGEST = 24  # points along an axis
SOFTEST = 0.35  # range of the hardness over E* g_rms, above all loads
HARDEST = 3.0
LIGHTEST = 0.01  # range of the loads p*
HEAVIEST = 0.3


def _history(rng, is_hard, relaxes):
    """Return a wall with random loads or mean gaps, and their times if it relaxes."""
    n = tuple(map(int, rng.integers(4, LARGEST + 1, 2)))
    z = rough(rng, n, modes=(1, max(n))) if rng.random() < 0.7 else rng.standard_normal(n)
    count = int(rng.integers(3, 8))
    loads = np.array([log_uniform(rng, LIGHTEST, HEAVIEST) for _ in range(count)])
    loads[1:] *= rng.random(count - 1) < 0.9  # others are unloaded
    targets = None
    if rng.random() < 0.3:
        touch = (z.max() - z.mean()) / z.std()
        gaps = [touch * share for share in rng.uniform(0.05, 0.99, count)]
        targets = "gap_over_h_rms", tuple(gaps)
        loads = ()
    if rng.random() < 0.3:  # held
        loads = loads[:1].repeat(count) if targets is None else loads
        targets = targets and (targets[0], targets[1][:1] * count)
    shares = rng.dirichlet(np.ones(rng.integers(1, 4))) * rng.uniform(0.1, 0.95)
    elements = [(float(share), log_uniform(rng, 0.1, 10)) for share in shares] if relaxes else []
    times = np.cumsum([choice(rng, (0, log_uniform(rng, 0.1, 10))) for _ in range(count)])
    return Wall(
        z,
        square_pixels(n),
        tuple(map(float, loads)),
        free=choice(rng, ((False, False), (False, False), (False, False), (True, True))),
        hardness_star=log_uniform(rng, SOFTEST, HARDEST) if is_hard else None,
        targets=targets,
        judge=partial(judged_rows, elements=elements, times=times.tolist()),
    )


@family
def history_dents(rng):
    return _history(rng, is_hard=True, relaxes=False)


@family
def history_relaxation(rng):
    return _history(rng, is_hard=False, relaxes=True)


@family
def history_both(rng):
    return _history(rng, is_hard=True, relaxes=True)


class Steps:
    """The exact contacts of loads that follow from each other.

    Attributes
    ----------
    dents, u, q : ndarray
        Depth of the dents, displacement, and memory of each element, after the last step.
    """

    def __init__(self, wall, elements):
        self.wall = wall
        self.shares, self.taus = np.array(elements).reshape(-1, 2).T
        self.dents = np.zeros_like(wall.heights)
        self.u = self.dents
        self.q = np.zeros((len(elements), *self.u.shape))

    def solve(self, p, dt, hardness):
        """Return (contact, truth, modulus) of the next step, with the truth None without a load.

        p, hardness: in the units of the wall; the modulus is that of the step.
        """
        wall = self.wall
        e, f = (x[:, None, None] for x in _decays(dt, self.taus))
        r = self.shares[:, None, None]
        k = 1 + float(np.sum(r * (f - 1)))
        c = np.sum(r * (e * self.q - f * self.u), axis=0) / k
        changed = wall.heights - self.dents + c
        contact = Contact(changed, wall.physical_sizes, wall.free)
        truth = None
        gap = changed.max() - changed
        modulus = k * wall.E_star
        if p > 0:
            unit = modulus * contact.g_rms
            truth = contact.solve(p / unit, hardness=hardness and hardness / unit)
            gap = truth.gap * contact.height_unit
        self.dents = self.dents + np.maximum(-gap, 0)
        u = np.maximum(gap, 0) + wall.heights - self.dents
        self.q = e * self.q + f * (u - self.u)
        self.u = u
        return contact, truth, modulus


def _decays(dt, taus):
    """Return exp(-dt/tau) and its mean over the step, of each element."""
    e = np.exp(-dt / taus)
    return e, (1 - e) * taus / dt if dt else np.ones_like(taus)


def judged_rows(wall, way, elements, times):
    """Yield (number of the load, columns) of each load of a history.

    A mean gap is compared with the truth at the load that was found.
    """
    unit = wall.E_star * Contact(wall.heights, wall.physical_sizes, wall.free).g_rms
    hardness = wall.hardness_star and wall.hardness_star * unit
    if wall.targets:
        quantity = "gap_mean"
        values = np.array(wall.targets[1]) * wall.heights.std()
    else:
        quantity = "pressure"
        values = np.array(wall.loads) * unit
    keys = {"hardness": hardness, "history": True} if hardness else {}
    if elements:
        keys |= {"relaxation": elements, "time": times}
    solutions = hpc_gfmd.solve(
        wall.heights,
        precision=way["precision"],
        accuracy=way["accuracy"],
        fields=["pressure"],
        **{quantity: values},
        **keys,
        **keywords(wall),
    )
    steps = Steps(wall, elements)
    kkt = 0.0
    for number, (solution, value) in enumerate(zip(solutions, values, strict=True)):
        dt = times[number] - times[max(number - 1, 0)]
        contact, truth, modulus = steps.solve(solution.p, dt, hardness)
        columns = {"p_star": solution.p / unit}
        if truth is None:
            exact = contact.h[contact.D].mean() * contact.height_unit
            exact = max(exact, value) if wall.targets else exact
            true = (solution.a_r, abs(solution.gap_mean / exact - 1), 0.0)
            columns |= outcome(solution, 0, true)
        else:
            columns |= compared(solution, truth, contact, modulus)
            kkt = max(kkt, truth.kkt)
            if wall.targets:
                off = abs(truth.gap_mean * contact.height_unit / value - 1)
                columns["true"][1] += off if off > way["accuracy"] + SLACK else 0.0
        yield number, columns | {"kkt": kkt}
