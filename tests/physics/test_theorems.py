"""Theorems of linear elasticity and of frictionless contact that hold whatever the wall is: Betti,
superposition, Barber."""

import numpy as np
import pytest
from contacts import EXACT, random_heights, relative

import hpc_gfmd

N, SIZES = (24, 20), (1.0, 1.0)


def solved(heights, p_star, sizes=SIZES, **how):
    return hpc_gfmd.solve(
        heights,
        p_star=p_star,
        physical_sizes=sizes,
        boundary="periodic",
        fields=("pressure", "gap", "displacement"),
        **EXACT,
        **how,
    )


@pytest.mark.parametrize("how", [{}, {"thickness": 0.1, "nu": 0.3}], ids=["half-space", "layer"])
def test_betti(how):
    """Two contacts of one body: the pressure of either does the same work on the other's
    displacement."""
    one, other = (solved(random_heights(N, seed), 0.1 * (seed + 1), **how) for seed in (0, 1))
    work = [np.mean((a.pressure - a.p) * b.displacement) for a, b in ((one, other), (other, one))]
    assert abs(work[0]) > 1e-3 * np.std(one.pressure) * np.std(other.displacement)
    assert work[0] == pytest.approx(work[1], rel=1e-8)


def test_superposition_in_full_contact():
    """There all is linear: pressures of walls add up, and their mean does not matter to what
    varies."""
    a, b = random_heights(N, 0), random_heights(N, 1)
    pressures = [solved(z, 30.0).pressure for z in (a, b, a - 2 * b)]
    varying = [p - p.mean() for p in pressures]
    assert min(p.min() for p in pressures) > 0
    assert relative(varying[2], varying[0] - 2 * varying[1]) < 1e-10


@pytest.mark.parametrize("sizes", [(1.0, 1.0), (1.0, 2.5)])
def test_more_load_is_more_contact(sizes):
    """Barber (1974): with the load no point leaves the contact, at none the pressure falls, and the
    contact gets stiffer."""
    steps = solved(
        random_heights(N, 3), np.geomspace(1e-3, 3.0, 25), sizes, observables=["stiffness"]
    )
    for before, after in zip(steps, steps[1:]):
        assert (after.pressure >= before.pressure - 1e-8 * after.p).all()
        assert (after.gap <= before.gap + 1e-8 * before.gap.max()).all()
    stiffness = steps.values("stiffness")
    known = np.isfinite(stiffness)  # none once contact is full
    assert known.sum() > 10
    assert (
        np.diff(stiffness[known]) >= -1e-9 * stiffness[known][1:]
    ).all()  # the same where no point has come into contact
    assert stiffness[known][-1] > 100 * stiffness[known][0]
    p, gap = steps.values("p")[known], steps.values("gap_mean")[known]
    secants, stiffness = -np.diff(p) / np.diff(gap), stiffness[known]
    assert (
        secants >= stiffness[:-1] * (1 - 1e-3)
    ).all()  # it lies between the tangents at both ends
    assert (secants <= stiffness[1:] * (1 + 1e-3)).all()
