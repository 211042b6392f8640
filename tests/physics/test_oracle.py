"""Every solver against dense linear algebra that shares no code with it."""

import numpy as np
import oracle
import pytest
from contacts import EXACT, random_heights, relative

import hpc_gfmd
from hpc_gfmd.solvers import solver_names

GRIDS = [
    ((8, 8), (1.0, 1.0)),
    ((9, 7), (1.0, 1.0)),
    ((12, 16), (2.0, 0.5)),
    ((1, 20), (1.0, 1.0)),
    ((16, 16), (1.0, 1.0)),
    ((5, 13), (1.0, 3.0)),
]


def test_oracle_satisfies_its_equations():
    z = random_heights((10, 9))
    exact = oracle.solve(z, 0.4, 2.0, (1.0, 1.5))
    K = oracle.stiffness(z.shape, (1.0, 1.5), 2.0)
    p = 0.4 + K @ exact.displacement.ravel()
    assert np.abs(p - exact.pressure.ravel()).max() < 1e-12 * p.max()
    assert exact.gap.min() == 0
    assert not (exact.gap * exact.pressure).any()
    assert exact.pressure.mean() == pytest.approx(0.4, rel=1e-12)


@pytest.mark.parametrize("load", [0.03, 0.4, 2.0])
@pytest.mark.parametrize(("n", "sizes"), GRIDS)
def test_default_solver(n, sizes, load):
    z = random_heights(n, seed=sum(n))
    exact = oracle.solve(z, load, 2.0, sizes)
    found = hpc_gfmd.solve(z, load, 2.0, sizes, **EXACT | {"residual": 1e-12})
    assert found.status == "converged"
    assert found.a_r == exact.a_r
    assert found.gap_mean == pytest.approx(exact.gap_mean, rel=1e-10)
    assert relative(found.pressure, exact.pressure) < 1e-10
    assert relative(found.gap, exact.gap) < 1e-10
    shift = found.displacement - exact.displacement
    assert np.abs(shift - shift.mean()).max() < 1e-10 * np.ptp(z)


@pytest.mark.parametrize("name", solver_names())
@pytest.mark.parametrize("load", [0.05, 1.0])
def test_every_solver(name, load):
    z = random_heights((12, 11), seed=3)
    exact = oracle.solve(z, load)
    found = hpc_gfmd.solve(z, load, name=name, **EXACT | {"residual": 1e-10})
    assert found.status == "converged"
    assert found.a_r == exact.a_r
    assert found.gap_mean == pytest.approx(exact.gap_mean, rel=1e-7)
    assert relative(found.pressure, exact.pressure) < 1e-7
