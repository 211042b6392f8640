"""The gap mode: with it the preconditioner is still symmetric, and knows the answer to a change of
the load as it knows other waves."""

import numpy as np
import pytest

from hpc_gfmd.bodies.free import Free
from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.bodies.layer import Layer
from hpc_gfmd.kernels.multilevel import restrict_level, smooth_level
from hpc_gfmd.operators.elastic import Elastic, reader
from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.parallel.grid import Grid

N = (144, 160)
GRIDS = {
    "half-space": (Grid(N), HALF_SPACE),
    "layer": (Grid(N, (0.9, 1.0)), Layer(0.3, 0.3, "bonded")),
    "free": (Grid(N, nominal=(96, 106)), Free((True, True))),
}


class Tangent:
    """M and K on the free points of a contact t, fields that are 0 on it; K relative to the
    shortest wave, as M has it."""

    def __init__(self, grid, body, t):
        self.t, self.scale, self.elastic = t, body.scale(grid), Elastic(grid, body, np.float64)
        self.levels = Multilevel(grid, body, np.float64, N[0])
        self.transfer = self.levels.transfers[0].tables

    def precondition(self, r, anew=False):
        fields, z = np.zeros((2, N[0] + 2, N[1])), np.zeros((N[0] + 2, N[1]))
        fields[:, 1:-1] = r, self.t
        restrict_level(fields, self.levels.fields[0][:2], self.transfer)
        self.levels.sweep_levels(anew)
        smooth_level(
            fields,
            self.levels.z,
            z,
            1.0,
            self.levels.damping,
            self.levels.coupling,
            self.transfer,
            self.levels.nominal[0],
        )
        return z[1:-1] * (1 - self.t)

    def stiffness(self, u):
        out = np.empty(N)
        self.elastic.pressure_rows(reader(u))
        self.elastic.pressure_columns()
        self.elastic.use_rows(lambda i0, i1, x: out.__setitem__(slice(i0, i1), x[: i1 - i0]))
        return out * (1 - self.t) / self.scale

    def spectrum(self, r, steps=30):
        """Eigenvalues of M K, by Lanczos as conjugate gradients have it."""
        d, rz, alpha, diagonal, beside, beta = 0, 1.0, 1.0, [], [], 0.0
        for k in range(steps):
            z = self.precondition(r)
            before, rz = rz, np.vdot(r, z)
            if k > 0:
                beta = rz / before
                beside.append(np.sqrt(beta) / alpha)
            d = z + beta * d
            Kd = self.stiffness(d)
            diagonal.append(beta / alpha)
            alpha = rz / np.vdot(d, Kd)
            diagonal[-1] += 1 / alpha
            r = r - alpha * Kd
        return np.linalg.eigvalsh(np.diag(diagonal) + np.diag(beside, 1) + np.diag(beside, -1))


@pytest.mark.parametrize("share", [0.001, 0.01, 0.1])
@pytest.mark.parametrize("name", GRIDS)
def test_no_wave_is_left_out(name, share):
    (grid, body), random = GRIDS[name], np.random.default_rng(3)
    t = np.zeros(N)
    t[: grid.nominal[0], : grid.nominal[1]] = random.random(grid.nominal) < share
    tangent = Tangent(grid, body, t)
    r, s = random.standard_normal((2, *N)) * (1 - t)
    before = tangent.spectrum(r)
    tangent.precondition(r, anew=True)
    after = tangent.spectrum(r)
    assert np.vdot(s, tangent.precondition(r)) == pytest.approx(
        np.vdot(r, tangent.precondition(s)), rel=1e-9
    )
    assert after[0] > 0.4
    assert after[-1] < 1.05 * before[-1]
    assert before[0] < 0.2 or share > 0.001


def test_where_there_is_none():
    """Small grids, nothing in contact, much in contact."""
    mode = Multilevel(Grid(N), HALF_SPACE, np.float64, N[0]).gap_mode
    assert [mode.wanted(share) for share in (0.0, 1e-4, 0.1, 0.5, 1.0)] == [
        False,
        True,
        True,
        False,
        False,
    ]
    assert (mode.find(np.full((18, 20), 0.1)) == 0).all()  # M has it
    assert not Multilevel(Grid((96, 96)), HALF_SPACE, np.float64, 96).gap_mode.wanted(0.1)
