"""Every solver against dense linear algebra that shares no code with it."""

import numpy as np
import oracle
import pytest
from contacts import EXACT, random_heights, relative, rough

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


@pytest.mark.parametrize(
    ("load", "hardness", "yields"),
    [(0.05, 1e9, 0.0), (0.05, 0.6, 0.03), (0.05, 0.3, 0.1), (0.2, 0.5, 0.29), (0.4, 0.402, 0.9)],
)
def test_with_a_hardness(load, hardness, yields):
    """p = 0 where the gap is open, the hardness where there is a dent; without end it is
    elastic."""
    surface = hpc_gfmd.make_surface(**rough((2, 16, 2), hurst=0.9))
    exact = oracle.solve_yielding(surface.heights, load, hardness)
    found = hpc_gfmd.solve(
        surface,
        load,
        hardness=hardness,
        **EXACT,
        fields=["pressure", "gap", "plastic", "displacement"],
    )
    assert found.status == "converged"
    assert found.a_r == exact.a_r
    assert found.value("a_plastic") == np.mean(exact.gap < 0) >= yields
    assert found.gap_mean == pytest.approx(exact.gap_mean, rel=1e-9)
    assert found.value("energy") == pytest.approx(exact.energy, rel=1e-9)
    assert relative(found.pressure, exact.pressure) < 1e-9
    assert relative(found.gap - found.plastic, exact.gap) < 1e-9
    assert relative(found.displacement - found.plastic, exact.displacement) < 1e-9
    assert found.gap.min() == 0
    assert found.pressure.max() <= hardness
    assert not (found.gap * found.pressure).any()
    if not yields:
        elastic = hpc_gfmd.solve(surface, load, **EXACT)
        assert relative(found.pressure, elastic.pressure) < 1e-12
        assert found.fft_pairs == elastic.fft_pairs
    for accuracy in (1e-2, 1e-5):
        rough_one = hpc_gfmd.solve(surface, load, hardness=hardness, accuracy=accuracy)
        area, gap, pressure = rough_one.errors
        assert max(rough_one.errors) < accuracy
        assert abs(rough_one.a_r - exact.a_r) <= area * exact.a_r
        assert abs(rough_one.gap_mean - exact.gap_mean) <= gap * exact.gap_mean
        assert relative(rough_one.pressure, exact.pressure) <= pressure


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
