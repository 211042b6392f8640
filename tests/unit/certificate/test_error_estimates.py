"""The estimated errors of a state do not depend on units."""

from dataclasses import replace

import numpy as np
import pytest
from contacts import random_heights, surface_over

from hpc_gfmd.bodies import body_of
from hpc_gfmd.certificate.certificate import certify
from hpc_gfmd.driver.nested import cold_gap
from hpc_gfmd.laws import law_named
from hpc_gfmd.operators.problem import Problem
from hpc_gfmd.scene import Material
from hpc_gfmd.solvers.bpx import Bpx

RELATIVE = ("errors", "attainable", "penetration", "tension", "complementarity", "residual")


def certificate_in(unit, free, dtype, steps, hardness=None, adhesive=False):
    """The certificate after some iterations, with lengths and pressures in a smaller unit."""
    surface = surface_over(random_heights((24, 20), seed=1), dtype=dtype, free=free)
    keys = {}
    if hardness:
        keys["hardness"] = hardness * unit
    if adhesive:
        keys["attraction"] = law_named("exponential", 0.03 * unit**2, 0.3 * unit)
    body = body_of(Material(), free)
    problem = Problem(surface.grid, surface.h * dtype(unit), 0.3 * unit, body=body, **keys)
    solver = Bpx(problem)
    light = replace(problem, p0=0.3)  # no start in full contact, which is a matter of p*
    solver.start(cold_gap(light))
    for _ in range(steps):
        solver.step()
    return certify(solver.problem_now, solver.state, solver.levels, dual=True)


@pytest.mark.parametrize("steps", [4, 40])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize(
    ("free", "keys"),
    [
        ((False, False), {}),
        ((False, False), {"hardness": 0.5}),
        ((False, False), {"adhesive": True}),
        ((True, False), {}),
        ((True, True), {}),
    ],
)
def test_relative_errors_do_not_depend_on_units(free, keys, dtype, steps):
    plain, scaled = (certificate_in(unit, free, dtype, steps, **keys) for unit in (1, 16))
    assert scaled.gap_mean == 16 * plain.gap_mean
    for name in RELATIVE:
        assert getattr(scaled, name) == getattr(plain, name), name
    if steps == 40:
        assert max(plain.errors) < 0.1


@pytest.mark.parametrize("steps", [2, 40])
def test_what_wrong_heights_leave_is_attainable_once_it_is_the_larger_part(steps):
    surface = surface_over(random_heights((24, 20), seed=1))
    problem = Problem(surface.grid, surface.h, 0.3, height_error=1e-3)
    solver = Bpx(problem)
    solver.start(cold_gap(problem))
    for _ in range(steps):
        solver.step()
    certificate = certify(problem, solver.state, solver.levels)
    expected = certificate.errors[1:] if steps == 40 else (0.0, 0.0)
    assert certificate.attainable == pytest.approx(expected, rel=1e-3)
