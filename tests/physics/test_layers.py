"""Layers of finite thickness: the compliance against the equations of elasticity, contacts against
dense linear algebra and both limits."""

import numpy as np
import oracle
import pytest
from contacts import EXACT, field, heights_of, relative, rough, sweep_of

import hpc_gfmd
from hpc_gfmd.bodies import body_of
from hpc_gfmd.scene import Material

LAYERS = [
    (0.3, "bonded"),
    (0.0, "bonded"),
    (0.45, "bonded"),
    (0.3, "frictionless"),
    (0.5, "frictionless"),
]
# Coatings: (nu, base), the base as (Young's modulus over E* of the coating, Poisson's ratio).
BASES = [(0.3, (0.05, 0.2)), (0.5, (0.7, 0.5)), (0.0, (30.0, 0.1))]
every_layer = pytest.mark.parametrize(("nu", "base"), LAYERS)
every_body = pytest.mark.parametrize(("nu", "base"), LAYERS + BASES)


def material(nu, base, t, E_star=1.0):
    """Return the table [material] of a layer or a coating."""
    table = {"E_star": E_star, "thickness": t, "nu1": nu}
    if isinstance(base, str):
        return table | {"base": base}
    return table | {"base": "elastic", "base_E": base[0] * E_star, "base_nu": base[1]}


def softness(q, t, nu, base):
    """Return the deflection of a layer under p = cos(q x) over that of a half-space.

    It solves the equations of plane strain with Airy's function [(A + B z) cosh q z + (C + D z)
    sinh q z] cos q x, z from the base upwards, and (A + B z) exp q z cos q x in an elastic base.
    sigma_zz = -q^2 phi and sigma_xz = q phi' sin q x; u_x and u_z follow from Hooke's law with
    G = 1/2 and E* = E/(1 - nu^2) = 2 G/(1 - nu).
    """

    def rows(z, nu, elastic_base=False):
        c = np.cosh(q * z)
        s = np.sinh(q * z)
        phi = np.array([c, z * c, s, z * s])
        d1 = np.array([q * s, c + q * z * s, q * c, s + q * z * c])
        d2 = np.array([q * q * c, 2 * q * s + q * q * z * c, q * q * s, 2 * q * c + q * q * z * s])
        d3 = np.array(
            [q**3 * s, 3 * q * q * c + q**3 * z * s, q**3 * c, 3 * q * q * s + q**3 * z * c]
        )
        if elastic_base:  # exp = cosh + sinh
            phi, d1, d2, d3 = (d[:2] + d[2:] for d in (phi, d1, d2, d3))
        # 2G eps_xx = (1 - nu) sxx - nu szz with sxx = phi'' and szz = -q^2 phi; u_x is the integral
        # of eps_xx. 2G (du_z/dx + du_x/dz) = 2 sxz.
        u_x = ((1 - nu) * d2 + nu * q * q * phi) / q  # times sin q x
        du_x = ((1 - nu) * d3 + nu * q * q * d1) / q
        sxz = q * d1  # times sin q x
        u_z = (du_x - 2 * sxz) / q  # times cos q x: du_z/dx = -q u_z sin
        return np.array([phi, sxz, u_x, u_z])

    below = rows(0.0, nu)
    top = rows(t, nu)
    if isinstance(base, str):
        fixed = below[[3, 2 if base == "bonded" else 1]]
    else:
        twice_G = base[0] / (1 - nu) / (1 + base[1])
        under = rows(0.0, base[1], True) / np.array([[1], [1], [twice_G], [twice_G]])
        fixed = np.hstack([below, -under])
    surface = np.zeros((2, fixed.shape[1]))
    surface[0, :4] = top[1]
    surface[1, :4] = -q * q * top[0]
    A = np.vstack([fixed, surface])
    coefficients = np.linalg.solve(A, np.append(np.zeros(len(A) - 1), -1.0))  # sigma_zz = -1 on top
    deflection = -(top[3] @ coefficients[:4])  # downwards, 2 G = 1
    return deflection / (2 / q * (1 - nu))  # S of the half-space is 2/(E* q)


@every_body
@pytest.mark.parametrize("qt", [0.03, 0.3, 1.0, 2.5, 6.0])
def test_compliance_is_that_of_elasticity(nu, base, qt):
    body = body_of(Material(**material(nu, base, 0.7)))
    K = body.stiffness(np.array([qt / 0.7 * 0.2]), 0.2)[0]
    assert qt / 0.7 * 0.2 / 2 / K == pytest.approx(softness(qt / 0.7, 0.7, nu, base), rel=1e-6)


@every_body
def test_against_the_oracle(nu, base):
    surface = rough((1, 4, 4), seed=3, physical_sizes=[2.5, 2.5])
    step = sweep_of(surface, E_star=3.0, layer=material(nu, base, 0.2, 3.0), **EXACT).solve(0.4)
    exact = oracle.solve(
        heights_of(surface),
        0.4,
        3.0,
        (2.5, 2.5),
        lambda q: softness(q, 0.2, nu, base) if q * 0.2 < 15 else 1.0,
    )
    assert step.status == "converged"
    assert step.contact_points / step.N == exact.a_r
    assert step.gap_mean == pytest.approx(exact.gap_mean, rel=1e-6)
    assert relative(field(step, "pressure"), exact.pressure) < 1e-6
    assert np.ptp(field(step, "displacement") - exact.displacement) < 1e-6 * np.ptp(exact.gap)


@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_thin_layers_are_springs(nu):
    """As in Winkler's foundation p = (M/t) times the penetration of the undeformed heights."""
    surface = rough((2, 8, 4))
    z = heights_of(surface)
    t = 0.01 / 64
    spring = (1 - nu) ** 2 / (1 - 2 * nu) / t
    p = 0.2 * spring * z.std()
    depth = np.linspace(0, np.ptp(z), 200001)
    loads = np.array([np.maximum(d - (z.max() - z), 0).mean() for d in depth[::200]])
    d = np.interp(p / spring, loads, depth[::200])
    step = sweep_of(surface, layer={"thickness": t, "nu1": nu}, **EXACT).solve(p)
    assert step.contact_points / step.N == pytest.approx(np.mean(z > z.max() - d), abs=2e-3)
    assert step.gap_mean == pytest.approx(np.maximum(z.max() - z - d, 0).mean(), rel=3e-3)
    assert relative(field(step, "pressure"), spring * np.maximum(d - (z.max() - z), 0)) < 1e-2


def test_limits_of_the_stiffness():
    """Thick layers are half-spaces, a stiff base is a rigid one, and under a thin coating only the
    base deforms."""
    q = np.geomspace(1e-2, 30, 50)

    def K(nu, base, t):
        return body_of(Material(**material(nu, base, t))).stiffness(q, 1.0)

    for nu, base in LAYERS + BASES:
        assert K(nu, base, 1e4) == pytest.approx(q / 2, rel=1e-12)
    assert K(0.3, (1e9, 0.2), 0.3) == pytest.approx(K(0.3, "bonded", 0.3), rel=1e-5)
    for E, nu in ((0.05, 0.2), (20.0, 0.45)):
        assert K(0.3, (E, nu), 1e-7) == pytest.approx(q / 2 * E / (1 - nu**2), rel=1e-3)


def test_the_approach_in_low_memory():
    """It depends on the mean height, although low memory does not keep the heights."""
    ways = ({"low_memory": low, "accuracy": 1e-5, "precision": "double"} for low in (True, False))
    low, plain = (
        sweep_of(rough((2, 16, 4)), layer={"thickness": 0.05, "nu1": 0.3}, **way).solve(0.1)
        for way in ways
    )
    assert low.approach == pytest.approx(plain.approach, rel=1e-5)


@every_layer
def test_a_flat_layer_is_compressed_as_a_whole(nu, base):
    """Its modulus is E(1 - nu)/((1 + nu)(1 - 2 nu)) if bonded, E* if frictionless."""
    E_star, t, p = 2.0, 0.1, 0.3
    modulus = E_star
    if base == "bonded":
        modulus *= (1 - nu) ** 2 / (1 - 2 * nu)
    flat = hpc_gfmd.solve(np.zeros((8, 6)), p, E_star, nu=nu, thickness=t, base=base)
    assert flat.approach == pytest.approx(p * t / modulus)
    assert flat.value("energy") == pytest.approx(p**2 * t / modulus / 2)
