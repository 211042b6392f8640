"""The contract of elastic bodies; new files in hpc_gfmd/bodies are tested automatically."""

from itertools import product

import numpy as np
import pytest
from scipy.linalg import eigh
from transfers import compliance_times, interpolation, matrix, stiffness_times

from hpc_gfmd.bodies import body_classes, body_of
from hpc_gfmd.bodies.base import SQRT2
from hpc_gfmd.operators.elastic import Elastic
from hpc_gfmd.parallel.coarsening import levels
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.scene import Material
from hpc_gfmd.util.errors import SceneError

BODIES = [body for cls in body_classes().values() for body in cls.examples()]
SMALL_GRIDS = [
    ((16, 16), (1.0, 1.0)),
    ((15, 12), (1.0, 0.7)),
    ((1, 16), (1.0, 1.0)),
    ((16, 1), (1.0, 1.0)),
    ((2, 2), (1.0, 3.0)),
]
LARGE_GRID = ((48, 40), (1.0, 1.0))
# largest eigenvalue of S relative to the sum of squares on the levels; residuals of solvers have
# smaller ratios
LARGEST = 2.25
every_body = pytest.mark.parametrize("body", BODIES)


@pytest.mark.quick
@every_body
def test_equal_bodies_have_equal_hashes(body):
    """They are keys of cached tables."""
    assert hash(body) == hash(type(body)(**vars(body)))
    assert body == type(body)(**vars(body))


@pytest.mark.quick
@every_body
def test_symmetric_positive_and_bounded(body):
    """K is symmetric, zero for rigid translations and positive otherwise, with eigenvalues within
    the bounds of the body."""
    for n, sizes in SMALL_GRIDS:
        grid = Grid(n, sizes)
        K = matrix(body, grid)
        assert np.allclose(K, K.T, atol=1e-12), n
        assert np.abs(K.sum(axis=0)).max() < 1e-12
        values = np.linalg.eigvalsh(K)
        assert abs(values[0]) < 1e-12
        assert values[1] > 1e-3
        if grid.N == 4:
            continue
        smallest, largest = body.bounds(grid)
        # eigenvalues with free edges are those of a half-space to within 20 %
        assert smallest * 0.8 <= values[1], n
        assert values[-1] <= largest * 1.02, n
        assert body.scale(grid) * SQRT2 <= largest * (1 + 1e-12)
        assert body.scale(grid) > 0


@pytest.mark.quick
@every_body
def test_compliance_is_the_inverse(body):
    """S K u = u less its mean; <u, K u> and <p, S p> are the energies that the operator returns."""
    for (n, sizes), dtype in product([*SMALL_GRIDS, LARGE_GRID], (np.float32, np.float64)):
        grid = Grid(n, sizes)
        tolerance = 2e3 * float(np.finfo(dtype).eps)
        elastic = Elastic(grid, body, dtype)
        u, p, back = (grid.empty(dtype) for _ in range(3))
        u[...] = np.random.default_rng(1).standard_normal(n)
        uKu = stiffness_times(elastic, u, p)
        pSp = compliance_times(elastic, p, back)
        assert np.abs(back - (u - u.mean())).max() < tolerance, n
        assert uKu == pytest.approx(np.vdot(u, p), rel=tolerance), n
        assert pSp == pytest.approx(np.vdot(p, back), rel=tolerance), n
        elastic.pressure_rows(lambda i0, i1, x, p=p: np.copyto(x[: i1 - i0], p[i0:i1]))
        assert elastic.columns(inverse=True, backward=False) == pytest.approx(pSp, rel=1e-5), n


@pytest.mark.quick
@every_body
def test_near_stiffness(body):
    """K between neighbours agrees with the operator."""
    grid = Grid((48, 40))
    u = np.zeros(grid.n)
    p = grid.empty(np.float64)
    u[5, 7] = 1
    stiffness_times(Elastic(grid, body, np.float64), u, p)
    mean = float(body.stiffness(np.zeros(1), grid.a)[0]) / grid.N  # missing in load control
    near = body.near(grid)
    assert near[0] > 0
    assert near == pytest.approx(
        [p[5, 7] + mean, p[6, 7] + mean, p[5, 8] + mean, p[6, 8] + mean], abs=2e-3 * near[0]
    )
    assert (body.near(Grid((64, 1)))[2:] == 0).all()
    assert (body.near(Grid((2, 64)))[[1, 3]] == 0).all()


@pytest.mark.quick
@every_body
def test_short_waves_see_a_half_space(body):
    """K -> |q|/2 for waves much shorter than the dimensions of the body."""
    q = np.array([1.0, 3.0])
    assert body.stiffness(q, 1e-3) == pytest.approx(q / 2, rel=1e-2)


def test_exactly_one_body_serves_a_material():
    """One body class accepts each material; unsupported boundaries are refused."""
    elastic = {"base": "elastic", "base_E": 2.0, "base_nu": 0.3}
    layer = {"thickness": 0.3, "nu1": 0.4}
    for keys in ({}, layer, layer | {"base": "frictionless"}, layer | elastic):
        material = Material(**keys)
        matching = [cls.of(material, (False, False)) for cls in body_classes().values()]
        assert len(list(filter(None, matching))) == 1
    for keys in (layer, layer | elastic):
        with pytest.raises(SceneError, match="allowed: with periodic boundaries"):
            body_of(Material(**keys), (True, False))


@every_body
@pytest.mark.parametrize(
    ("n", "sizes"), [((16, 16), (1.0, 1.0)), ((15, 12), (1.0, 0.7)), ((20, 20), (1.0, 1.0))]
)
def test_norm_of_pressures_is_bounded_by_levels(body, n, sizes):
    """<r, S r> of fields with zero mean is bounded by their squares on the levels.

    The errors of the certificate rest on this bound.
    """
    grid = Grid(n, sizes)
    S = np.linalg.pinv(matrix(body, grid), rcond=1e-9)
    hierarchy = levels(grid)
    R = np.eye(grid.N)
    squares = np.zeros((grid.N, grid.N))
    for k, (level, softness) in enumerate(zip(hierarchy, body.softness(grid), strict=True)):
        if k:
            fine = hierarchy[k - 1].n
            P = np.kron(interpolation(fine[0], level.n[0]), interpolation(fine[1], level.n[1]))
            R = P.T @ R * (level.n[0] * level.n[1] / (fine[0] * fine[1]))
        squares += softness * grid.N / (level.n[0] * level.n[1]) * R.T @ R
    free_of_mean = np.linalg.svd(np.ones((1, grid.N)))[2][1:].T
    A, B = (free_of_mean.T @ X @ free_of_mean for X in (S, squares / body.scale(grid)))
    values = eigh(A, B, eigvals_only=True)
    assert 0.1 < values[-1] <= LARGEST
